"""Two cloud layers with sides: enclosure, uniform and empty layers, shadows, Monte Carlo, windows, refusals."""

from dataclasses import replace

import numpy as np
import pytest
from hcss_light.monte_carlo import Sunlight, radiance
from hcss_light.slices import Slices
from hcss_light.source import Direction, Particles, Surroundings
from hcss_light.stack import Stack
from hcss_light.stacked_light import StackedSlant, StackedSource
from hcss_light.stacked_photons import StackedReference
from hcss_light.stacked_source import StackedGroup, stacked_radiance, stacked_source
from hcss_light.transport import SlantLight, SourceLight
from hcss_light.voxels import Voxels, henyey_greenstein
from light_scene import DAY, NIGHT, scene

from hcss_twin import simulate
from hcss_twin.core.errors import ScenarioError
from hcss_twin.engine.compile import tables_of
from hcss_twin.engine.stages.light import LightStage
from hcss_twin.engine.stream import PartMaker
from hcss_twin.plan import choose_light
from hcss_twin.plan.make_plan import make_plan
from hcss_twin.plan.plan import COLUMNS

WATER, ICE = Particles(0.03, 0.8, np.array([1.0, 0.85])), Particles(0.002, 0.6, np.array([1.0, 0.9]))
LOW = {"type": "stratocumulus", "coverage": 0.5, "base": 600.0, "top": 1000.0, "anchor": "base", "generator": "fractal"}
LOWER, UPPER = Slices(100.0, 700.0, 20, "base", 100.0), Slices(1500.0, 2500.0, 16, "top", 100.0)


def stack(view=None):
    return Stack((LOWER, UPPER), (100.0, 2500.0), view or Direction(0.0, 0.0))


def densities(rows=12, columns=10):
    """Half of an area covered by clouds of all thicknesses, in each layer."""
    draw, result = np.random.default_rng(4), []
    for slices, most in ((LOWER, 600.0), (UPPER, 1000.0)):
        cloudy = draw.random((rows, columns)) < 0.5
        result.append(slices.density((draw.uniform(20.0, most, cloudy.shape) * cloudy).astype(np.float32)))
    return result


def group(of, emitted, sky=0.0, below=0.0, sunlight=0.0, gas=0.0):
    around = Surroundings(emitted, sky, below, np.full(of.count, sunlight), np.full(of.count, gas))
    return StackedGroup((WATER, ICE), around)


def two(light="source", upper=0.5, certificate=0, **changes):
    """The scene with a second layer, of large pixels: light reaches few of them."""
    layers = [LOW, {"type": "paper-cirrus", "coverage": upper}]
    values = {"image": {"rows": 6, "columns": 5, "pixel_size": 1000.0}, "clouds": {"layers": layers}}
    return scene(light, certificate, **(values | changes))


@pytest.mark.parametrize("zenith", [0.0, 50.0, 80.0])
@pytest.mark.parametrize("gas", [0.0, 1e-4])
def test_an_isothermal_enclosure_with_two_broken_layers_is_black(zenith, gas):
    whole, clouds = stack(Direction(zenith, 30.0)), densities()
    light_group = group(whole, np.ones(whole.count), 1.0, 1.0, 0.0, gas)
    source = stacked_source(whole, clouds, light_group, None)
    seen = stacked_radiance(whole, whole.optical(clouds, light_group.scaled_m1), source, 1.0)
    np.testing.assert_allclose(seen, 1.0, atol=1e-3)


def voxels(clouds, reference_m, slope, emitted, surface, sky):
    """The same clouds for Monte Carlo: 20 slices, 4 clear ones, 16 slices."""
    whole = stack()
    extinction = np.zeros((*clouds[0].shape[1:], whole.count))
    albedo, kind, moved = np.zeros(whole.count), whole.kind, np.zeros((whole.count, 2))
    for part, density, particles in zip(whole.parts, clouds, (WATER, ICE), strict=True):
        extinction[:, :, part] = np.moveaxis(density, 0, 2) * particles.extinction_m1
        albedo[part] = particles.albedo
    moved[whole.parts[1].start :] = reference_m * slope
    return Voxels(
        extinction, whole.edges_m, (100.0, 100.0), albedo, np.zeros(whole.count), emitted,
        surface_source=surface, sky_source=sky, kind=kind, moved_m=moved,
    )  # fmt: skip


@pytest.mark.parametrize(("zenith", "shone", "limit"), [(0.0, False, 0.012), (50.0, False, 0.012), (50.0, True, 0.06)])
def test_two_broken_layers_agree_with_monte_carlo(zenith, shone, limit):
    """Thermal light of water cloud under thin ice cloud, and sunlight without emission.

    Clouds of the lower layer alone are 1 % too dark at nadir, too; in scenes the error of uniform clouds cancels.
    """
    view, sun = Direction(zenith, 20.0), Direction(40.0, 130.0)
    whole, clouds = stack(view), densities()
    emitted = np.zeros(whole.count) if shone else np.linspace(1.0, 0.6, whole.count)
    sky, below = (0.0, 0.0) if shone else (0.1, 1.1)
    light_group = group(whole, emitted, sky, below, 1.0 if shone else 0.0)
    source = stacked_source(whole, clouds, light_group, sun if shone else None)
    seen = stacked_radiance(whole, whole.optical(clouds, light_group.scaled_m1), source, below)
    slope = view.vector[:2] / view.vector[2]
    air = voxels(clouds, 2400.0, slope, emitted, below, sky)
    mean, error = radiance(
        air, [henyey_greenstein(0.85), henyey_greenstein(0.9)], view_zenith_deg=zenith, view_azimuth_deg=20.0,
        sun=Sunlight(40.0, 130.0, 1.0) if shone else None, photons=800,
    )  # fmt: skip
    away, level = seen - mean, mean.mean()
    noise = np.sqrt(np.mean(error**2) / mean.size) / level
    assert abs(away.mean() / level) < limit + 3.0 * noise
    assert np.sqrt(max(np.mean(away**2) - np.mean(error**2), 0.0)) / level < 2.5 * limit


def test_monte_carlo_of_columns_that_are_displaced_is_that_of_columns_that_stand_there():
    clouds, rolled = densities(), densities()
    rolled[1] = np.roll(rolled[1], (2, -3), axis=(1, 2))
    emitted, tables = np.linspace(1.0, 0.6, stack().count), [henyey_greenstein(0.85), henyey_greenstein(0.9)]
    seen = []
    for density, away in ((clouds, np.array([200.0, -300.0])), (rolled, np.zeros(2))):
        air = voxels(density, 1.0, away, emitted, 1.1, 0.1)
        # Photons start above the same places.
        start = (-away[0], -away[1])
        seen.append(radiance(air, tables, view_zenith_deg=30.0, photons=50, displaced_m=start)[0])
    np.testing.assert_allclose(*seen, rtol=1e-6)


def test_a_thick_layer_above_leaves_the_one_below_dark_where_its_shadow_falls():
    """Sun at 45 deg from the north: thick cloud between 1500 and 1562 m shades tops at 700 m 8.5 rows south of it."""
    whole = stack()
    clouds = [np.ones((20, 20, 4), dtype=np.float32), np.zeros((16, 20, 4), dtype=np.float32)]
    clouds[1][0, 14] = 1000.0
    light_group = group(whole, np.zeros(whole.count), sunlight=1.0)
    source = stacked_source(whole, clouds, light_group, Direction(45.0, 0.0))[19, :, 0]
    assert int(np.argmin(source)) in (5, 6)
    assert source.min() < 0.6 * np.median(source)


@pytest.mark.parametrize(
    ("several", "of_one", "time"),
    [
        (StackedSource, SourceLight, DAY),
        (StackedSlant, SlantLight, NIGHT),
        pytest.param(StackedSource, SourceLight, NIGHT, marks=pytest.mark.campaign),
        pytest.param(StackedSlant, SlantLight, DAY, marks=pytest.mark.campaign),
    ],
)
def test_uniform_layers_keep_the_radiance_of_the_tables_and_an_empty_one_changes_nothing(time, several, of_one):
    plan = make_plan(two("columns", time=time, bands=[[3.6, 3.7]]))
    tables = tables_of(plan)
    inputs, sun = LightStage.inputs(plan, tables.spectrum.nodes), plan.sun_at(0.0)
    light = several(inputs).at(sun)
    for thickness in ((10.0, 300.0), (87.0, 2000.0), (400.0, 0.0)):
        given = np.full((2, 3, 4), np.array(thickness)[:, None, None], np.float32)
        amount, share, change = light.correct(given)
        np.testing.assert_allclose(amount, given, rtol=1e-5)
        assert np.all(np.abs(change) < 2e-3 * tables.tables[0].clear[0, 0])
        np.testing.assert_allclose(share, 1.0, atol=5e-3)
    draw = np.random.default_rng(3)
    lower = (draw.uniform(20.0, 400.0, (16, 16)) * (draw.random((16, 16)) < 0.5)).astype(np.float32)
    amount, share, change = light.correct(np.stack((lower, np.zeros_like(lower))))
    both = light.uniform(amount) * share + change
    one = of_one(LightStage.inputs(plan, tables.spectrum.nodes)).at(sun)
    amount, share, change = one.correct(lower)
    alone = one.uniform(amount) * share + change
    assert np.mean(both) == pytest.approx(np.mean(alone), rel=3e-3)
    assert np.sqrt(np.mean((both - alone) ** 2)) < 0.01 * np.mean(alone)


def test_a_layer_that_never_has_cloud_leaves_the_bits_of_the_other_and_windows_those_of_the_image():
    both = simulate(two(upper=0.0))
    alone = simulate(two(clouds=LOW))
    np.testing.assert_array_equal(both.radiance.values, alone.radiance.values)
    whole = simulate(two(certificate=2))
    image = {"rows": 6, "columns": 5, "pixel_size": 1000.0, "window": {"rows": [2, 6], "columns": [1, 4]}}
    part = simulate(two(image=image))
    np.testing.assert_array_equal(part.radiance.values, whole.radiance.values[:, :, 2:6, 1:4])
    assert "computed as specified" in whole.attrs["hcss_certificate"]
    assert "against Monte Carlo of 2 random pixels" in whole.attrs["hcss_certificate"]
    assert np.any(whole.radiance.values != both.radiance.values)


@pytest.mark.parametrize(
    ("time", "band", "zenith", "limit"),
    [
        pytest.param(NIGHT, [10.5, 11.0], 50.0, 0.02, marks=pytest.mark.campaign),
        (DAY, [3.6, 3.8], 40.0, 0.08),
        pytest.param(NIGHT, [3.6, 3.8], 60.0, 0.08, marks=pytest.mark.campaign),
    ],
)
def test_slanted_rays_through_two_layers_are_far_nearer_to_monte_carlo_than_columns(time, band, zenith, limit):
    image, view = {"rows": 6, "columns": 5, "pixel_size": 500.0}, {"zenith": zenith, "azimuth": 30.0}
    plan = make_plan(two(time=time, bands=[band], view=view, image=image, sea={"temperature_texture": 0.0}))
    tables, found = tables_of(plan), {}
    for name, transport in (("columns", None), ("slant", StackedSlant), ("reference", StackedReference)):
        light = COLUMNS if transport is None else replace(plan.light, name=name, transport=transport)
        of_light = PartMaker(replace(plan, light=light), tables)
        found[name] = of_light.part(0, (slice(0, 6), slice(0, 5)))[0]["radiance"].astype(float)
    mean = np.mean(found["reference"])
    slant, columns = (np.sqrt(np.mean((found[name] - found["reference"]) ** 2)) / mean for name in ("slant", "columns"))
    assert slant < limit
    assert slant < 0.3 * columns
    stated = StackedSlant(LightStage.inputs(plan, tables.spectrum.nodes))
    assert slant < stated.expected_errors()[0] < stated.errors_of_columns()[0]


def test_lights_that_know_one_layer_are_refused_by_name(monkeypatch):
    found = choose_light.installed

    def of_one_layer(group):
        return [(origin, entry) for origin, entry in found(group) if "layers" not in group or entry.name != "slant"]

    monkeypatch.setattr(choose_light, "installed", of_one_layer)
    with pytest.raises(ScenarioError, match=r"radiance.light.*'slant' computes one layer.*'source'"):
        make_plan(two("slant"))


def test_monte_carlo_as_a_tier_knows_both_layers():
    image = {"rows": 4, "columns": 4, "pixel_size": 1000.0}
    reference, source = (simulate(two(light, image=image)).radiance.values for light in ("reference", "source"))
    assert np.mean(reference) == pytest.approx(np.mean(source), rel=0.01)
