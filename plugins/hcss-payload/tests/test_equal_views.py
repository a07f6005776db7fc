"""A camera in orbit and images on the ground see equal radiance where they look at one place from one direction."""

import json

import numpy as np
import pytest
from camera_scenes import PASS, SCENE, merged, scenario
from hcss_payload.build import trajectory_of
from hcss_payload.passes import direction_deg
from hcss_payload.rays import geographic
from scipy.interpolate import RegularGridInterpolator

import hcss_twin
from hcss_twin.providers import Catalog

hcss_sweep = pytest.importorskip("hcss_sweep")

ACCURACY = 1e-3
SKIES = {
    "clear": {"type": "paper-stratus", "coverage": 0.0},
    "overcast": {"type": "paper-stratus", "coverage": 1.0, "base": 500.0, "top": 1000.0, "thickness_min": 490.0},
}


@pytest.fixture(scope="module", params=SKIES)
def cubes(request, tmp_path_factory):
    """Of a camera, and of grids of 100 and 150 m pixels with the platform where the camera is, by day."""
    sky = {"clouds": SKIES[request.param], "time": "2024-04-20T02:30:00Z", "frames": {"count": 1}}
    one = scenario(PASS, sky)
    trajectory = trajectory_of(one, Catalog())
    elevation, bearing = direction_deg(trajectory, (one.place.latitude, one.place.longitude), 0.0)
    height_m = float(geographic(trajectory.at(0.0))[2])
    camera = {name: PASS[name] for name in ("camera", "orbit", "attitude")}
    grid = {"platform": {"altitude": height_m}, "view": {"zenith": 90.0 - elevation, "azimuth": bearing}}
    sensors = [
        {"name": "camera", **camera},
        {"name": "fine", **grid, "image": {"rows": 64, "columns": 64, "pixel_size": 100.0}},
        {"name": "coarse", **grid, "image": {"rows": 40, "columns": 40, "pixel_size": 150.0}},
    ]
    slant = {"zenith": 125.0 - elevation, "azimuth": bearing}
    sensors.append({"name": "slant", **grid, "view": slant, "image": {"rows": 8, "columns": 8, "pixel_size": 150.0}})
    of_all = {key: value for key, value in merged(SCENE, PASS, sky).items() if key not in camera}
    of_all |= {"accuracy": ACCURACY, "sensors": sensors, "output": {"variables": ["radiance", "geometry"]}}
    of_all["sea"] = {**SCENE["sea"], "temperature_texture": 0.0, "waves": "off"}
    of_all["atmosphere"] = {"water_vapour_texture": 0.0}
    result = hcss_sweep.sweep(of_all, tmp_path_factory.mktemp(request.param))
    assert not result.failed, result.failed
    return {record.values["sensors"]: result.cube(record.point) for record in result.points}


@pytest.mark.parametrize("name", ["fine", "coarse"])
def test_radiance_is_equal_within_the_certificates(cubes, name):
    with hcss_twin.open_cube(cubes["camera"]) as seen, hcss_twin.open_cube(cubes[name]) as grid:
        assert max(json.loads(seen.attrs["hcss_accuracy_achieved"]).values()) <= ACCURACY
        latitude, longitude = grid.pixel_latitude.values, grid.pixel_longitude.values
        places = [seen[f"pixel_{kind}"].values[0] for kind in ("latitude", "longitude")]
        # Places of the grid are a plane's: rows have one latitude within a metre.
        axes = latitude[:, latitude.shape[1] // 2], longitude[longitude.shape[0] // 2]
        zenith = RegularGridInterpolator(axes, grid.pixel_view_zenith.values.reshape(latitude.shape))(tuple(places))
        np.testing.assert_allclose(seen.pixel_view_zenith.values[0], zenith, atol=0.01)
        for band, image in enumerate(seen.radiance.values[0]):
            expected = RegularGridInterpolator(axes, grid.radiance.values[0, band].astype(float))(tuple(places))
            np.testing.assert_allclose(image, expected, rtol=2.0 * ACCURACY)
            assert np.ptp(expected) > 0.0


def test_another_view_has_another_radiance(cubes):
    """The law above is not one of a scene that looks alike from everywhere."""
    with hcss_twin.open_cube(cubes["camera"]) as seen, hcss_twin.open_cube(cubes["slant"]) as grid:
        change = grid.radiance.values[0].mean((1, 2)) / seen.radiance.values[0].mean((1, 2)) - 1.0
    assert np.all(np.abs(change) > 4.0 * ACCURACY)
