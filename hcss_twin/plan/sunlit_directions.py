"""Suns of the places that an image with directions of its own sees, where one sun for all is not accurate enough."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hcss_twin.physics.geodesy import Ellipsoid
from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.directions import SunlitDirections, second_order
from hcss_twin.plan.few_columns import OMISSION_SHARE
from hcss_twin.plan.one_direction import SUN_ANGLES
from hcss_twin.plan.rays import Rays
from hcss_twin.plan.scene_analysis import SceneAnalysis
from hcss_twin.plan.views import SUNS_WITHIN_M
from hcss_twin.scenario.scenario import Scenario

SIDE = 5
"""Pixels along each side of the image whose places are asked for."""

GAIN = 0.5
"""Part of the distance from the centre that may remain between the place of a direction and those that frames see along
it: more is not worth a sun for each view."""


def needs_own_suns(analysis: SceneAnalysis) -> bool:
    """Whether one sun for all pixels exceeds its share of the accuracy."""
    limit = OMISSION_SHARE * analysis.accuracy.relative
    return any(item.what == SUN_ANGLES and item.exceeds(limit) for item in analysis.omissions)


def with_own_suns(rays: Rays, scenario: Scenario, assembly: Assembly, times_s: Sequence[float]) -> Assembly | None:
    """Return the scene with a sun for each direction; None if frames see too different places along a direction.

    Places are those of some frames; ``reach_m`` of the scene is how far others are from the place of a direction.

    Parameters
    ----------
    times_s : sequence of float
        Of some frames.
    """
    directions = assembly.directions
    if directions is None or directions.suns is not None or assembly.reach_m is None or assembly.air_over_field.varies:
        return None
    centre_deg = scenario.place.latitude, scenario.place.longitude
    places, positions = [], []
    for time_s in times_s:
        for row in np.linspace(0, rays.image.rows - 1, SIDE).astype(int).tolist():
            for column in np.linspace(0, rays.image.columns - 1, SIDE).astype(int).tolist():
                pixel = slice(row, row + 1), slice(column, column + 1)
                positions.append([float(each[0, 0]) for each in rays.positions(pixel, time_s)])
                places.append([float(each[0, 0]) for each in rays.locations_deg(pixel, time_s, scenario)])
    x, y = np.array(positions).T
    if np.any(np.isnan(x)):
        return None
    latitude, longitude = np.array(places).T
    seen_m = np.stack(Ellipsoid.to_plane(latitude, longitude, *centre_deg), axis=-1)
    powers = second_order(x, y)
    coefficients = np.linalg.lstsq(powers, seen_m, rcond=1e-6)[0].astype(np.float64)
    left_m = np.max(np.abs(powers @ coefficients - seen_m), axis=0)
    if np.hypot(*assembly.reach_m) > SUNS_WITHIN_M or np.hypot(*left_m) > GAIN * np.hypot(*assembly.reach_m):
        return None
    sunlit = SunlitDirections(directions, centre_deg, coefficients)
    return replace(assembly, directions=sunlit, reach_m=(float(left_m[0]), float(left_m[1])))
