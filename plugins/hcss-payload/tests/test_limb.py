"""Radiance of the limb: against closed forms, the air's own paths to the ground, and in cubes."""

import numpy as np
import pytest
from camera_scenes import scenario
from hcss_payload.limb import Limb, Shells, ground_radiance, limb_radiance, tangent_heights_m
from hcss_payload.rays import geographic
from test_cube import DISK

import hcss_twin
from hcss_twin.core.catalog import Catalog
from hcss_twin.models.atmosphere.profile_file import load_profile
from hcss_twin.physics.geodesy import Ellipsoid
from hcss_twin.physics.paths import Path, to_space
from hcss_twin.physics.planck import planck
from hcss_twin.physics.profile import EARTH_RADIUS_M, Profile
from hcss_twin.providers import View

WAVENUMBER, HEIGHT_M, KELVIN = np.linspace(900.0, 1000.0, 5), 7e3, 250.0
WEIGHTS = np.full((1, 5), 25.0)
WIDE = {"bands": ["lwir"]}
"""The band of ozone is in it."""


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
    straight = Shells(isothermal(), refraction=False)
    radiance = limb_radiance(Exponential(surface_extinction_m1), straight, WAVENUMBER, WEIGHTS, tangent)[:, 0]
    # The integral over a straight line, with the first correction to the length sqrt(2 pi R H) of Chapman's.
    length = np.sqrt(2.0 * np.pi * (EARTH_RADIUS_M + tangent) * HEIGHT_M)
    length *= 1.0 + 3.0 / 8.0 * HEIGHT_M / (EARTH_RADIUS_M + tangent)
    depth = surface_extinction_m1 * np.exp(-tangent / HEIGHT_M) * length
    black = np.sum(WEIGHTS[0] * planck(WAVENUMBER, KELVIN))
    assert radiance == pytest.approx(-np.expm1(-depth) * black, rel=2e-3)


def test_air_at_the_temperature_of_the_sea_is_black_down_to_grazing_angles():
    shells = Shells(isothermal())
    grazing = np.array([-20e3, -5e3, shells.straight_m(0.0) - 1.0])
    radiance = ground_radiance(Exponential(1e-5), shells, WAVENUMBER, WEIGHTS, grazing, KELVIN)[:, 0]
    assert radiance == pytest.approx(np.sum(WEIGHTS[0] * planck(WAVENUMBER, KELVIN)), rel=1e-12)


def test_lines_of_sight_bend_by_twice_the_refraction_of_the_horizon():
    # Standard refraction at the horizon, 34 minutes of arc in visible light at 283 K and 1010 hPa (Nautical Almanac),
    # for the density and the refractivity (-1.7 %) of the infrared at 288 K and 1013 hPa: 32.9.
    shells = Shells(load_profile("us-standard-1976", Catalog()))
    index = shells.bent_m / (EARTH_RADIUS_M + shells.level_m)
    impact = shells.bent_m[0]
    turned = np.arccosh(np.maximum(shells.bent_m / impact, 1.0))
    bending = -2.0 * impact * np.sum(np.diff(np.log(index)) / np.diff(shells.bent_m) * np.diff(turned))
    assert np.degrees(bending) * 30.0 == pytest.approx(32.9, abs=1.0)
    assert shells.straight_m(0.0) == pytest.approx((index[0] - 1.0) * EARTH_RADIUS_M)


@pytest.fixture(scope="module")
def plan():
    air = {"atmosphere": {"profile": "tropical"}}
    return hcss_twin.make_plan(scenario(DISK, WIDE, {"camera": {"beyond": "limb"}}, air))


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
    shells, spectral = Shells(air.profile), (grid.wavenumber_cm1, grid.weights_cm1)
    exact = limb_radiance(air.transmittance, shells, *spectral, heights)
    limb = Limb(plan.assembly)
    assert limb(np.array([shells.straight_m(height) for height in heights])) == pytest.approx(exact.T, rel=5e-3)
    grazing = np.array([-23.3e3, -7.3e3, 0.0, 1.3e3])
    below = ground_radiance(air.transmittance, shells, *spectral, grazing, air.sea_temperature_K)
    assert limb(grazing) == pytest.approx(below.T, rel=1e-3)
    edge = shells.straight_m(0.0) + np.array([-2.0, 2.0])
    assert np.diff(limb(edge)) == pytest.approx(0.0, abs=1e-3 * limb(edge).min())


def test_grazing_ground_continues_that_of_the_tables(plan):
    # The tables hold to 85 degrees, with a sea that reflects; the model of the paper has plane air.
    air, grid = plan.assembly, plan.spectral_grid
    clear = air.toward(View(85.0, 0.0)).clear(grid.wavenumber_cm1, None)
    band = sum(clear.values()) @ grid.weights_cm1.T
    height = EARTH_RADIUS_M * (np.sin(np.radians(85.0)) - 1.0)
    assert Limb(plan.assembly)(np.array([height]))[:, 0] == pytest.approx(band, rel=5e-3)


def test_tangent_heights_are_the_least_along_a_line():
    origin = Ellipsoid.to_earth_centred(np.float64(35.0), np.float64(20.0), 7e5)
    rng = np.random.default_rng(4)
    direction = rng.normal(size=(400, 3))
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    closest = -(direction @ origin)
    height = geographic(origin + closest[:, None] * direction)[2]
    limb = direction[(closest > 0.0) & (height > 1e3) & (height < 1e5)]
    along = np.linspace(-2e5, 2e5, 4001)
    for line, height_m in zip(limb, tangent_heights_m(origin, limb), strict=True):
        points = origin + (-(line @ origin) + along)[:, None] * line
        assert height_m == pytest.approx(geographic(points)[2].min(), abs=0.5)
    assert len(limb) > 3


def test_a_full_disk_has_a_limb_that_fades_to_space():
    # 8.1 to 9.0 degrees from the middle of the disk, 0.08 mrad or 3 km a pixel.
    edge = {"rows": 200, "columns": 24, "detector_pitch": 8e-6, "principal_point": [1980.0, 11.5], "beyond": "limb"}
    cube = hcss_twin.simulate(scenario(DISK, WIDE, {"camera": edge}))
    kind, radiance = cube["pixel_kind"].values[0], cube["radiance"].values[0, 0]
    height = cube["pixel_tangent_height"].values[0]
    limb = kind == 2
    zenith = cube["pixel_view_zenith"].values[0]
    assert np.all(radiance[kind == 0] > 10.0)
    assert np.all(radiance[kind == 1] > 20.0)
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
    assert cube.attrs["hcss_certificate"].startswith("computed as specified")
