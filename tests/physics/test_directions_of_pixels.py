"""Toward a sensor of a known altitude, each pixel has the view and the sun of its own place."""

import numpy as np
import pytest

from hcss_twin import Scenario, simulate
from hcss_twin.physics.geodesy import to_geographic
from hcss_twin.physics.viewing import LinesOfSight

BANDS = [{"name": "mwir", "limits": [3.6, 3.8]}, {"name": "lwir", "limits": [10.5, 11.0]}]
SEA = {
    "frames.count": 1,
    "bands": BANDS,
    "accuracy": 1e-3,
    "clouds.coverage": 0.0,
    "sea.waves": "off",
    "sea.temperature_texture": 0.0,
    "output": {"variables": ["radiance"], "certificate": 0},
}


@pytest.mark.parametrize(("zenith", "azimuth"), [(20.0, 18.72), (38.0, 60.0)])
def test_a_pixel_is_a_scene_of_its_own_place(zenith, azimuth):
    """A scene around a corner of the image, seen along the corner's line of sight, under the sun of the corner."""
    image = {"rows": 5, "columns": 5, "pixel_size": 8000.0}
    view = {"view.zenith": zenith, "view.azimuth": azimuth}
    wide = Scenario.load("stratus", {**SEA, **view, "image": image, "platform.altitude": "800 km"})
    found = simulate(wide)["radiance"].values[0]
    lines = LinesOfSight(wide.place.latitude, wide.place.longitude, zenith, azimuth, 800e3)
    worst, of_centre = 0.0, 0.0
    for row, column in ((0, 0), (0, 4), (4, 2), (2, 2)):
        x, y = ((pixel - 2) * 8000.0 for pixel in (column, row))
        seen = lines.from_points(np.array(x), np.array(y))
        latitude, longitude = to_geographic(np.array(x), np.array(y), wide.place.latitude, wide.place.longitude)
        there = {"view.zenith": float(seen.zenith_deg), "view.azimuth": float(seen.azimuth_deg)}
        suns = {"there": {"place.latitude": float(latitude), "place.longitude": float(longitude)}, "centre": {}}
        exact = {
            name: simulate(Scenario.load("stratus", {**SEA, **there, **place, "image.rows": 1, "image.columns": 1}))
            for name, place in suns.items()
        }
        errors = {
            name: np.max(np.abs(found[:, row, column] / cube["radiance"].values[0, :, 0, 0] - 1.0))
            for name, cube in exact.items()
        }
        worst, of_centre = max(worst, errors["there"]), max(of_centre, errors["centre"])
    assert worst < 0.5e-3
    assert of_centre > 1e-3
