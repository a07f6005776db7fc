"""The sun stands lower over the far end of a slant path."""

import math

import numpy as np
import pytest

from hcss_twin import Scenario, make_plan
from hcss_twin.physics.geometry import sun_zenith_along
from hcss_twin.providers import Sun


@pytest.mark.parametrize("azimuth", [0.0, 1.0, math.pi])
def test_the_sun_along_a_path_is_that_of_straight_lines_on_a_sphere(azimuth):
    radius, height, view, sun = 6.4e6, 1e5, 60.0, 70.0
    # The surface point on the z axis, the sensor toward x.
    start = np.array([0.0, 0.0, radius])
    toward = np.array([math.sin(math.radians(view)), 0.0, math.cos(math.radians(view))])
    sine = math.sin(math.radians(sun))
    to_sun = np.array([sine * math.cos(azimuth), sine * math.sin(azimuth), math.cos(math.radians(sun))])
    low, high = 0.0, 1e6
    for _ in range(80):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if np.linalg.norm(start + middle * toward) < radius + height else (low, middle)
    up = start + low * toward
    expected = math.degrees(math.acos(to_sun @ up / np.linalg.norm(up)))
    assert sun_zenith_along(view, sun, azimuth, height, radius) == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("view", [0.0, 20.0, 60.0, 80.0])
def test_any_sun_above_the_horizon_can_be_followed(view):
    scene = {"view.zenith": view, "view.azimuth": 90.0, "bands": [[3.7, 3.8]], "frames.count": 1}
    scene["output.variables"] = ["cloud_mask"]  # whose plan has the model, too, and analyses no radiance
    plan = make_plan(Scenario.load("stratus", scene))
    wavenumber = plan.spectral_grid.wavenumber_cm1[:2]
    for zenith in (80.0, 85.0, 87.0, 87.5, 87.9, 88.0, 89.0):
        for azimuth in (90.0, 270.0):  # behind the sensor and opposite
            terms = plan.assembly.clear(wavenumber, Sun(zenith, azimuth, 1.0))
            assert all(np.all(np.asarray(term) >= 0.0) for term in terms.values())
