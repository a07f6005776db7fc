"""Radiance of the limb: against closed forms, the air's own paths to the ground, and in cubes."""

import numpy as np
import pytest
from camera_scenes import scenario
from hcss_payload.limb import Limb, limb_radiance, tangent_heights_m
from hcss_payload.rays import geographic
from test_cube import DISK

import hcss_twin
from hcss_twin.physics.geodesy import to_earth_centred
from hcss_twin.physics.paths import Path, to_space
from hcss_twin.physics.planck import planck
from hcss_twin.physics.profile import EARTH_RADIUS_M, Profile

WAVENUMBER, HEIGHT_M, KELVIN = np.linspace(900.0, 1000.0, 5), 7e3, 250.0
WEIGHTS = np.full((1, 5), 25.0)


class Exponential:
    """Air whose extinction falls exponentially with height, at any wavenumber."""

    def __init__(self, extinction_m1):
        self.extinction_m1 = extinction_m1

    def absorber_amounts(self, paths):
        lowest = [path.legs[0].lower_m if path.legs else np.inf for path in paths]
        return self.extinction_m1 * HEIGHT_M * np.exp(-np.array(lowest) / HEIGHT_M)[:, None]

    def transmittance_of_amounts(self, wavenumber_cm1, amounts):
        return np.exp(-amounts) * np.ones(wavenumber_cm1.size)


def isothermal():
    altitude = np.linspace(0.0, 1e5, 51)
    return Profile("isothermal", altitude, 1e5 * np.exp(-altitude / HEIGHT_M), np.full(51, KELVIN))


@pytest.mark.parametrize("surface_extinction_m1", [1e-9, 1e-5, 1e-3])
def test_limb_of_isothermal_exponential_air_is_that_of_chapman(surface_extinction_m1):
    tangent = np.array([0.0, 5e3, 12e3, 30e3])
    radiance = limb_radiance(Exponential(surface_extinction_m1), isothermal(), WAVENUMBER, WEIGHTS, tangent)[:, 0]
    # The integral over a straight line, with the first correction to the length sqrt(2 pi R H) of Chapman's.
    length = np.sqrt(2.0 * np.pi * (EARTH_RADIUS_M + tangent) * HEIGHT_M)
    length *= 1.0 + 3.0 / 8.0 * HEIGHT_M / (EARTH_RADIUS_M + tangent)
    depth = surface_extinction_m1 * np.exp(-tangent / HEIGHT_M) * length
    black = np.sum(WEIGHTS[0] * planck(WAVENUMBER, KELVIN))
    assert radiance == pytest.approx(-np.expm1(-depth) * black, rel=2e-3)


@pytest.fixture(scope="module")
def plan():
    return hcss_twin.make_plan(scenario(DISK, {"camera": {"beyond": "limb"}}))


def test_amounts_of_the_limb_are_those_of_long_paths_of_the_air(plan):
    provider, grid = plan.assembly.transmittance, plan.spectral_grid
    # Toward 88 degrees at the ground a straight line has its lowest point 3.9 km below it: air above 20 km is passed
    # under the angle of the line with that tangent height.
    leg = to_space(20e3, 88.0)
    (amounts,) = provider.absorber_amounts([leg])
    levels = np.concatenate((np.arange(20e3, 1e5, 200.0), [1e5]))
    vertical = -np.diff(
        provider.absorber_amounts([*(to_space(float(level), 0.0) for level in levels[:-1]), Path()]), axis=0
    )
    impact, radius = EARTH_RADIUS_M * np.sin(np.radians(88.0)), EARTH_RADIUS_M + levels
    along = np.diff(np.sqrt((radius - impact) * (radius + impact))) / np.diff(levels)
    present = amounts > 1e-12 * amounts.max()
    # Refraction shortens paths above 20 km by less than a percent.
    assert (along @ vertical)[present] == pytest.approx(amounts[present], rel=0.01)
    assert grid.weights_cm1.shape[0] == len(plan.bands)


def test_the_table_is_accurate_between_its_heights(plan):
    grid, air = plan.spectral_grid, plan.assembly
    heights = np.array([600.0, 9.8e3, 16.2e3, 30.4e3, 45.6e3])
    exact = limb_radiance(air.transmittance, air.profile, grid.wavenumber_cm1, grid.weights_cm1, heights)
    assert Limb(plan)(heights) == pytest.approx(exact.T, rel=5e-3)


def test_tangent_heights_are_the_least_along_a_line():
    origin = to_earth_centred(np.float64(35.0), np.float64(20.0), 7e5)
    rng = np.random.default_rng(4)
    direction = rng.normal(size=(400, 3))
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    closest = -(direction @ origin)
    height = geographic(origin + closest[:, None] * direction)[2]
    limb = direction[(closest > 0.0) & (height > 1e3) & (height < 1e5)]
    along = np.linspace(-2e5, 2e5, 4001)
    for line, own in zip(limb, tangent_heights_m(origin, limb), strict=True):
        points = origin + (-(line @ origin) + along)[:, None] * line
        assert own == pytest.approx(geographic(points)[2].min(), abs=0.5)
    assert len(limb) > 3


def test_a_full_disk_has_a_limb_that_fades_to_space():
    # 8.1 to 9.0 degrees from the middle of the disk, 0.08 mrad or 3 km a pixel.
    edge = {"rows": 200, "columns": 24, "detector_pitch": 8e-6, "principal_point": [1980.0, 11.5], "beyond": "limb"}
    cube = hcss_twin.simulate(scenario(DISK, {"camera": edge}))
    kind, radiance = cube["pixel_kind"].values[0], cube["radiance"].values[0, 0]
    height = cube["pixel_tangent_height"].values[0]
    limb = kind == 2
    zenith = cube["pixel_view_zenith"].values[0]
    assert np.all(radiance[kind == 0] > 10.0)
    assert np.all(np.isnan(radiance[kind == 1]))
    assert 84.0 < np.nanmax(zenith[kind == 0]) <= 85.0 < np.nanmin(zenith[kind == 1])
    assert limb.sum() > 20
    assert np.all(np.isfinite(radiance[limb]))
    assert np.all((height[limb] > 0.0) & (height[limb] < 1e5))
    order = np.argsort(height[limb])
    height, radiance = height[limb][order], radiance[limb][order]
    # Air thins out with height, but ozone emits most around 22 km.
    for part in (height < 1e4, height > 3e4):
        assert np.all(np.diff(radiance[part]) <= 0.0)
    ozone, below = (radiance[(height > low) & (height < high)].max() for low, high in ((2e4, 2.5e4), (1.3e4, 1.8e4)))
    assert ozone > below
    assert radiance[0] > 4.0 * ozone > 1e3 * radiance[-1]
    assert cube.attrs["hcss_certificate"].startswith("PASSED")
