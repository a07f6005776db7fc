"""The sea below clouds with sides: its reflection in Monte Carlo, shadows, and clouds that it mirrors."""

import math

import numpy as np
import pytest
from hcss_light.monte_carlo import Sunlight, radiance
from hcss_light.sea import Sea
from hcss_light.sea_surface import RoughSea, facets, glint, index_of
from hcss_light.slices import Slices
from hcss_light.source import Direction, Particles, Surroundings, absorbed_radiance
from hcss_light.voxels import LightError, Voxels, henyey_greenstein

from hcss_twin.core.catalog import Catalog
from hcss_twin.models.parameters import RoughSeaParameters
from hcss_twin.models.sea.rough_sea import RoughSea as SceneSea
from hcss_twin.providers import SeaInputs

NUMBERS = np.array([2666.0, 930.0])
BLACK = Particles(0.05, 0.0, np.array([1.0, 0.0]))


@pytest.fixture(scope="module")
def scene_sea():
    return SceneSea(SeaInputs(7.0, 0.0, 295.0, Catalog()), RoughSeaParameters())


@pytest.mark.parametrize("zenith", [0.0, 60.0, 80.0])
def test_an_isothermal_enclosure_over_a_rough_sea_is_black(zenith):
    extinction = np.zeros((4, 4, 6))
    extinction[1:3, 2, 2:5] = 0.02
    air = np.linspace(0.0, 600.0, 7), (100.0, 100.0), 0.6, np.full(6, 1e-4), np.ones(6)
    voxels = Voxels(extinction, *air, surface_source=1.0, sky_source=1.0)
    mean, error = radiance(
        voxels, henyey_greenstein(0.8), view_zenith_deg=zenith, photons=1000, sea=RoughSea(0.04, 1.35)
    )  # fmt: skip
    assert abs(mean.mean() - 1.0) < 4.0 * math.sqrt(np.mean(error**2)) / 4.0 + 1e-4


@pytest.mark.parametrize(("view", "sun", "azimuth"), [(0.0, 20.0, 0.0), (30.0, 35.0, 170.0), (60.0, 55.0, 180.0)])
def test_glint_of_monte_carlo_is_that_of_the_scenes_sea(scene_sea, view, sun, azimuth):
    """Two codes; that of the scene has the complex index and foam."""
    toward, to_sun = Direction(view, 0.0).vector, Direction(sun, azimuth).vector
    upright = 1.0 - scene_sea.emissivity(NUMBERS, np.ones(1))[0]
    expected = scene_sea.brdf(NUMBERS, toward[2:], to_sun[2:], np.radians([azimuth]))[0]
    of_facets = [
        glint(toward, to_sun, 0.5 * scene_sea.mean_square_slope, float(index_of(reflectance)))
        for reflectance in upright
    ]
    np.testing.assert_allclose(np.array(of_facets) / to_sun[2], expected, rtol=0.03)


@pytest.mark.parametrize("zenith", [0.0, 45.0, 60.0])
def test_facets_of_monte_carlo_reflect_as_much_as_the_scenes_sea(scene_sea, zenith):
    across = math.cos(math.radians(zenith))
    upright = 1.0 - scene_sea.emissivity(NUMBERS, np.ones(1))[0]
    of_facets = [
        np.sum(facets(RoughSea(scene_sea.mean_square_slope, float(index_of(reflectance))), across)[1])
        for reflectance in upright
    ]
    np.testing.assert_allclose(of_facets, 1.0 - scene_sea.emissivity(NUMBERS, np.array([across]))[0], atol=1.5e-3)


def clouds():
    """Two blocks of cloud from 400 m on over the sea, in slices that begin there."""
    thickness = np.zeros((14, 16), dtype=np.float32)
    thickness[2:6, 4:8], thickness[8:10, 10:12] = 160.0, 90.0
    return Slices(400.0, 600.0, 20, "base", 100.0), thickness


def traced(slices, thickness, view, **changes):
    """Radiance by Monte Carlo of black clouds, and its standard error."""
    density = np.moveaxis(slices.density(thickness), 0, 2).astype(float) * BLACK.extinction_m1
    levels = slices.count + 1
    edges = np.concatenate(([0.0], slices.edges_m))
    source = np.zeros(levels) if "source" not in changes else np.full(levels, changes.pop("source"))
    voxels = Voxels(np.pad(density, ((0, 0), (0, 0), (1, 0))), edges, (100.0, 100.0), 0.0, np.zeros(levels), source)
    away = (slices.top_m - 400.0) * view.vector[:2] / view.vector[2]
    return radiance(
        voxels, henyey_greenstein(0.0), view_zenith_deg=view.zenith_deg, view_azimuth_deg=view.azimuth_deg,
        displaced_m=(float(away[0]), float(away[1])), **changes,
    )  # fmt: skip


def clear_of(slices, density, around, view):
    """Points whose lines of sight, and those of their neighbours, meet no cloud."""
    amount, _ = absorbed_radiance(slices, density, BLACK, around, view, 400.0)
    return sum(np.roll(amount, (y, x), (0, 1)) for y in (-1, 0, 1) for x in (-1, 0, 1)) == 0.0


@pytest.mark.parametrize(("zenith", "azimuth"), [(20.0, 40.0), (55.0, 200.0)])
def test_shadows_on_the_sea_lie_where_monte_carlo_finds_them(zenith, azimuth):
    slices, thickness = clouds()
    view, sun, sea = Direction(25.0, 190.0), Direction(zenith, azimuth), RoughSea(0.04, 1.35)
    light = Sunlight(zenith, azimuth, 1.0)
    clear = glint(view.vector, sun.vector, 0.02, 1.35)
    mean, error = traced(slices, thickness, view, sun=light, sea=sea, photons=300)
    nothing = np.zeros(slices.count)
    around = Surroundings(nothing, 0.0, clear, nothing, nothing, glint=clear)
    sea_of_scene = Sea(slices, view, sun, 400.0)
    density = slices.density(thickness)
    change = sea_of_scene.change(sea_of_scene.paths(density, True), BLACK, around, thickness.shape)
    unseen = clear_of(slices, density, around, view)
    away = (clear + change - mean)[unseen] / clear
    assert np.min(change) < -0.9 * clear
    assert abs(away.mean()) < 0.01
    assert np.sqrt(max(np.mean(away**2) - np.mean((error[unseen] / clear) ** 2), 0.0)) < 0.06


def test_the_sea_mirrors_clouds_where_monte_carlo_finds_them():
    """Black clouds of radiance 1 over water of radiance 0 that is nearly flat; every second column is looked at."""
    slices, thickness = clouds()
    view, sea = Direction(50.0, 10.0), RoughSea(1e-4, 1.35)
    mean, _ = traced(slices, thickness, view, source=1.0, sea=sea, photons=1500)
    reflected = float(np.sum(facets(sea, math.cos(math.radians(50.0)))[1]))
    nothing = np.zeros(slices.count)
    around = Surroundings(nothing, 0.0, 0.0, nothing, nothing, mirrored=np.full(slices.count, reflected))
    sea_of_scene = Sea(slices, view, None, 400.0)
    change = sea_of_scene.change(sea_of_scene.paths(slices.density(thickness), False), BLACK, around, thickness.shape)
    clear = clear_of(slices, slices.density(thickness), around, view)
    assert change[clear].mean() == pytest.approx(mean[clear].mean(), rel=0.06)
    assert np.corrcoef(change[clear], mean[clear])[0, 1] > 0.8


def test_a_sea_that_cannot_be_is_refused():
    with pytest.raises(LightError, match="mean_square_slope above 0"):
        RoughSea(0.0, 1.3)
