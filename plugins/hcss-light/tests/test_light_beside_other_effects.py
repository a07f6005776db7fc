"""Light between columns beside terms, elements, waves and clouds of images: what each adds, by hand."""

import netCDF4
import numpy as np
import pytest
from hcss_light.comparison import SampledClouds
from light_scene import DAY, NIGHT, scene

from hcss_twin import simulate
from hcss_twin.core.errors import ScenarioError
from hcss_twin.engine.clouds import FrameClouds
from hcss_twin.engine.compile import tables_of
from hcss_twin.engine.tables.over_surfaces import SurfaceStates
from hcss_twin.plan.choose_light import light_inputs
from hcss_twin.plan.make_plan import make_plan

OFF, EVEN = {"shadows": "off", "parallax": "off"}, {"temperature_texture": 0.0}
CLASSES = {"variables": ["radiance", "surface_class"]}
MASKED = {"variables": ["radiance", "cloud_mask"]}
TWO = [{"type": name, "generator": "fractal", "coverage": 0.5} for name in ("stratocumulus", "cirrus")]
TERMS = {"variables": ["radiance", "terms"]}
PRINTED = {"model": "as-printed"}


def terms_of(made):
    """Terms of independent columns."""
    names = [name for name in made.data_vars if name.startswith("radiance_") and not name.endswith("between_columns")]
    return [made[name].values.astype(float) for name in names]


@pytest.mark.parametrize("tier", [pytest.param("slant", marks=pytest.mark.campaign), "source"])
def test_terms_are_those_of_columns_and_light_between_them_is_one_more(tier):
    common = {"time": DAY, "bands": [[3.6, 3.8]], "slant": OFF, "sea": EVEN} | PRINTED
    columns, made = (
        simulate(scene(light, **common, output=TERMS | {"certificate": checked}))
        for light, checked in (("columns", 0), (tier, 8))
    )
    assert "radiance_between_columns" not in columns
    assert "computed as specified" in made.attrs["hcss_certificate"]
    for one, other in zip(terms_of(made), terms_of(columns), strict=True):
        np.testing.assert_array_equal(one, other)
    between = made.radiance_between_columns.values.astype(float)
    np.testing.assert_allclose(between, made.radiance.values.astype(float) - columns.radiance.values, atol=1e-6)
    assert np.ptp(between) > 0.05 * made.radiance.values.mean()
    whole = np.sum([*terms_of(made), between], axis=0)
    np.testing.assert_allclose(whole, made.radiance.values, rtol=1e-6)


@pytest.mark.parametrize(
    ("interval", "bands"),
    [pytest.param(60.0, [[10.5, 11.0]], marks=pytest.mark.campaign), (10.0, [[10.5, 11.0], [3.6, 3.8]])],
)
def test_an_element_above_the_clouds_hides_its_share_of_clouds_with_sides(interval, bands):
    """A body of radiance X leaves 1 - c of what is behind it: X, air included, is that which it has above columns.

    Over 10 s light is kept while the clouds drift.
    """
    track = {"x": 210.0, "y": -320.0, "altitude": 9000.0, "temperature": 250.0, "area": 4000.0}
    elements = [{"provider": "point-sources", "parameters": {"tracks": [track]}}]
    variables = ["radiance", "terms", "element_share", "element_radiance"]
    common = {"slant": OFF, "frames": {"count": 2, "interval": interval}, "bands": bands}
    without = {light: simulate(scene(light, **common)).radiance.values.astype(float) for light in ("columns", "source")}
    output = {"variables": variables, "certificate": 0}
    cubes = {light: simulate(scene(light, **common, elements=elements, output=output)) for light in without}
    share = cubes["source"].element_share.values[:, None].astype(float)
    present = np.broadcast_to(share > 0.05, without["source"].shape)
    change = {light: made.radiance.values - without[light] for light, made in cubes.items()}
    body = (without["columns"] + change["columns"] / np.where(share > 0.0, share, 1.0))[present]
    expected = share * (np.where(present, 1.0, 0.0) * -without["source"])
    expected[present] += np.broadcast_to(share, present.shape)[present] * body
    np.testing.assert_allclose(change["source"][present], expected[present], rtol=2e-3)
    assert np.max(np.abs(change["source"] - change["columns"])[present]) > 1e-3 * np.max(np.abs(expected))
    np.testing.assert_array_equal(change["source"][~present & (share == 0.0)], 0.0)
    made = cubes["source"]
    parts = [*terms_of(made), made.radiance_between_columns.values, made.element_radiance.values]
    np.testing.assert_allclose(np.sum(parts, axis=0), made.radiance.values, rtol=1e-5)
    assert any(note.startswith("elements (radiance.light = 'source')") for note in make_plan(
        scene("source", **common, elements=elements)).notes)  # fmt: skip


def test_waves_change_what_the_sea_sends_where_a_column_is_clear_and_nothing_else():
    common = {
        "time": DAY, "view": {"zenith": 33.0, "azimuth": 85.0}, "bands": [[3.6, 3.8]], "slant": OFF,
        "image": {"rows": 40, "columns": 40, "pixel_size": 20.0},
    }  # fmt: skip
    change = {}
    for light in ("columns", "source"):
        calm, made = (
            simulate(scene(light, **common, sea=EVEN | {"waves": waves}, output=MASKED | {"certificate": checked}))
            for waves, checked in (("off", 0), ("on", 8))
        )
        assert "computed as specified" in made.attrs["hcss_certificate"]
        change[light] = made.radiance.values.astype(float) - calm.radiance.values
    clear = (made.cloud_mask.values == 0)[:, None]
    assert 0.2 < clear.mean() < 0.8
    mean = made.radiance.values.mean()
    assert np.std(change["columns"][clear]) > 0.01 * mean
    # With waves, clear columns are computed at more wavenumbers.
    np.testing.assert_allclose(change["source"], change["columns"], atol=5e-4 * mean)
    np.testing.assert_allclose(change["source"][~clear], 0.0, atol=5e-4 * mean)


def test_clouds_of_an_image_have_the_light_of_a_larger_image_that_is_its_mirror(tmp_path):
    """Both images have the same distribution of grey, so that the same pixels are cloudy."""
    values = np.random.default_rng(3).gamma(2.0, 1.0, (10, 10)).repeat(4, 0).repeat(3, 1)
    np.save(tmp_path / "small.npy", values)
    np.save(tmp_path / "large.npy", np.pad(values, ((160, 160), (180, 180)), mode="symmetric"))

    def seen(name, light="source", **parameters):
        given = {"image": str(tmp_path / f"{name}.npy"), "method": "coverage", "cloud_is": "bright", **parameters}
        clouds = {"type": "stratocumulus", "coverage": 0.5, "generator": "imagery", "parameters": given}
        return simulate(scene(light, clouds=clouds, slant=OFF, **PRINTED)).radiance.values

    mirrored = seen("small", beyond="mirror")
    np.testing.assert_allclose(mirrored, seen("large", beyond="clear"), rtol=2e-3)
    assert np.max(np.abs(seen("small", beyond="clear") / mirrored - 1.0)) > 0.01
    assert np.max(np.abs(seen("small", "columns") / mirrored - 1.0)) > 0.01


@pytest.fixture
def sand(tmp_path):
    """A section of surfaces: sand of 303 K east of a longitude, sea west of it."""

    def made(east_of):
        path = tmp_path / f"{east_of}.nc"
        latitude, longitude = np.linspace(19.8, 20.2, 201), np.linspace(149.8, 150.2, 200)
        with netCDF4.Dataset(path, "w") as file:
            for name, values in (("latitude", latitude), ("longitude", longitude)):
                file.createDimension(name, values.size)
                file.createVariable(name, "f8", (name,))[:] = values
            classes = file.createVariable("surface_class", "f8", ("latitude", "longitude"))
            classes[:] = np.where(longitude > east_of, 1, 0) * np.ones((201, 1))
        of = {"classes": {0: "sea", 1: "sand"}, "temperatures": {"sand": 303.0}}
        return {"provider": "raster", "parameters": {"file": str(path)} | of}

    return made


@pytest.mark.parametrize(
    ("tier", "time", "changes"),
    [
        pytest.param("slant", NIGHT, {}, marks=pytest.mark.campaign),
        ("source", DAY, {}),
        ("source", DAY, PRINTED),
        ("source", NIGHT, {"platform": {"altitude": 1.5e5}} | PRINTED),
        ("source", NIGHT, {"clouds": {"layers": TWO}}),
        ("source", NIGHT, {"clouds": {"layers": TWO}} | PRINTED),
    ],
    ids=["slant", "physical", "source", "views of pixels", "physical, two layers", "two layers"],
)
def test_each_point_has_the_light_over_its_own_ground(sand, tier, time, changes):
    common = {"time": time, "bands": [[3.6, 3.8]], "slant": OFF, "sea": EVEN, "accuracy": 5e-3, **changes}
    if "platform" in changes:
        assert make_plan(scene(tier, **common, surfaces=sand(150.0))).views.varies
    half, land = (
        simulate(scene(tier, **common, surfaces=sand(east), output=CLASSES | {"certificate": checked}))
        for east, checked in ((150.0, 6), (149.85, 0))
    )
    assert "computed as specified" in half.attrs["hcss_certificate"]
    of_sand = half.surface_class.values == 1
    assert 0.3 < of_sand.mean() < 0.7
    assert np.all(land.surface_class.values == 1)
    sea, mixed = simulate(scene(tier, **common)).radiance.values[:, 0], half.radiance.values[:, 0]
    np.testing.assert_allclose(mixed[~of_sand], sea[~of_sand], rtol=5e-3)
    np.testing.assert_allclose(mixed[of_sand], land.radiance.values[:, 0][of_sand], rtol=5e-3)
    assert np.mean(np.abs(mixed[of_sand] / sea[of_sand] - 1.0)) > 0.02


def test_clouds_with_sides_over_land_agree_with_monte_carlo(sand):
    """Twelve pixels by night over sand that is 10 K warmer than the sea; columns err several times as much."""
    cumulus = {"type": "cumulus", "generator": "fractal", "coverage": 0.45, "coverage_mode": "field"}
    common = {"slant": OFF, "sea": EVEN, "surfaces": sand(149.85), "accuracy": 5e-3, "clouds": cumulus}
    plan = make_plan(scene("source", **common))
    (of_sand,) = plan.surfaces[0].states[1]
    alone = SurfaceStates(plan, plan.surfaces[0]).plan_in(plan, of_sand)
    inputs = light_inputs(alone, tables_of(plan).spectrum.nodes)
    sampled, clouds = SampledClouds(alone, inputs), FrameClouds(alone, 0.0)
    pixels = [(row, column) for row in (6, 17, 29, 35) for column in (5, 14, 23)]
    found = [sampled.radiance(pixel, 0.0, clouds, None, 400, n)[0][0, 0] for n, pixel in enumerate(pixels)]
    error = {}
    for light in ("columns", "source"):
        made = simulate(scene(light, certificate=0, **common)).radiance.values[0, 0]
        error[light] = np.sqrt(
            np.mean([(made[at] / value - 1.0) ** 2 for at, value in zip(pixels, found, strict=True)])
        )
    assert error["source"] < 0.015
    assert error["source"] < 0.4 * error["columns"]


def test_light_over_land_is_refused_where_it_is_not_computed(sand):
    ground = sand(150.0)
    image = {"rows": 8, "columns": 8, "pixel_size": 100.0}
    for clouds in ({}, {"clouds": {"layers": TWO}}):
        with pytest.raises(
            ScenarioError, match=r"surfaces: a map of the ground cannot be computed with radiance\.light"
        ):
            make_plan(scene("reference", surfaces=ground, image=image, **clouds))
