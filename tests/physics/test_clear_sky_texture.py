"""Texture of clear sky: its statistics, its radiance, and that scenes without it do not know of it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from surface_files import write_netcdf
from xarray import Dataset

from hcss_twin import Scenario, ScenarioError, simulate
from hcss_twin.core.catalog import Catalog
from hcss_twin.engine.tables.columns import BandColumns
from hcss_twin.engine.tables.texture import OverWarmerSea
from hcss_twin.models.atmosphere.band_model.provider import BandModelTransmittance
from hcss_twin.models.atmosphere.gases import with_factors
from hcss_twin.models.atmosphere.profile_file import load_profile
from hcss_twin.models.clouds.fractal.expected_variogram import KernelCorrelation
from hcss_twin.models.parameters import BandModelParameters
from hcss_twin.models.sea.texture import SEA_TEMPERATURE, WATER_VAPOUR, TextureField, TextureShape
from hcss_twin.physics.paths import to_space
from hcss_twin.plan.make_plan import make_plan
from hcss_twin.plan.texture import change_weights, nodes_between
from hcss_twin.providers import AtmosphereInputs, Grid

SIZE = 192
BASE = {
    "time": "2020-09-06T00:45:00+00:00",
    "place": {"latitude": -15.0, "longitude": 5.0},
    "view": {"zenith": 30.0},
    "image": {"rows": SIZE, "columns": SIZE, "pixel_size": 3000.0},
    "frames": {"count": 1},
    "bands": [[3.6, 4.1], [10.3, 11.3]],
    "sea": {"temperature": 293.0, "wind_speed": 6.0},
    "output": {"variables": ["radiance", "cloud_thickness"], "certificate": 0},
}
CHEAP: dict[str, dict[str, object]] = {
    "radiance": {"model": "as-printed"},
    "sea": {"model": "cox-munk"},
    "optics": {"provider": "mie"},
}
"""What compiles in a tenth of a second, since texture is the same for all models; one scene has the default ones."""
WITHOUT_HAZE = {"parameters": {"aerosol": "none"}}
"""Haze has a kink at 70 % relative humidity, which has its own test."""


def scene(**changes: object) -> Scenario:
    each = {key: {**value, **changes.pop(key, {})} if isinstance(value, dict) else value for key, value in BASE.items()}
    return Scenario.from_dict({**each, **changes})


def field(shape: TextureShape, pixel_size_m: float, seed: int = 1, size: int = SIZE, **motion: object) -> TextureField:
    return TextureField(shape, seed, Grid(size, size, pixel_size_m), **motion)


def whole(texture: TextureField, size: int = SIZE, time_s: float = 0.0) -> np.ndarray:
    return texture.at(time_s, slice(0, size), slice(0, size)).astype(np.float64)


@pytest.mark.parametrize(
    "name", sorted({*Catalog().names("scenarios", ".toml")} - {"baseline"})
)  # the paper's has none
def test_shipped_scenes_have_the_texture_that_is_on_by_default(name: str) -> None:
    assert Scenario.load(name).sea.temperature_texture is None


def test_clear_pixels_of_the_first_shipped_scene_differ() -> None:
    few = {"image.rows": 80, "image.columns": 80, "image.pixel_size": 200.0, "frames.count": 1, "output.certificate": 0}
    models = {"radiance.model": "as-printed", "sea.model": "cox-munk", "optics.provider": "mie", "bands": ["lwir"]}
    cube = simulate(Scenario.load("stratus", {**few, **models}))
    clear = cube["radiance"].values[0, 0][cube["cloud_mask"].values[0] == 0].astype(np.float64)
    # 0.03 to 0.05 K of a black body at 291 K
    assert 0.03 * 0.016 < clear.std() / clear.mean() < 0.08 * 0.016
    assert np.unique(clear).size > 0.5 * clear.size


@pytest.mark.parametrize("shape", [SEA_TEMPERATURE, WATER_VAPOUR], ids=["sea", "vapour"])
def test_structure_function_has_the_closed_form_of_its_octaves(shape: TextureShape) -> None:
    correlation, lags = KernelCorrelation.tabulate(), np.array([2, 6, 18])
    octaves = field(shape, 3000.0).octaves
    expected = [2.0 * sum(o.variance * (1.0 - correlation(o.x.step * np.array([h]))[0]) for o in octaves) for h in lags]
    images = [whole(field(shape, 3000.0, seed, 512), 512) for seed in range(12)]
    measured = [np.mean([np.mean((image[h:] - image[:-h]) ** 2) for image in images]) for h in lags]
    np.testing.assert_allclose(measured, expected, rtol=0.12)


@pytest.mark.parametrize(("shape", "hurst"), [(SEA_TEMPERATURE, 0.5), (WATER_VAPOUR, 1 / 3)], ids=["sea", "vapour"])
def test_octaves_follow_the_power_law_of_measured_spectra(shape: TextureShape, hurst: float) -> None:
    correlation = KernelCorrelation.tabulate()

    def structure(lag_m: float) -> float:
        return 2.0 * sum(share * (1.0 - correlation(np.array([lag_m / cell]))[0]) for cell, share in shape.cells)

    assert sum(share for _, share in shape.cells) == pytest.approx(1.0)
    exponent = np.log(structure(32e3) / structure(4e3)) / np.log(8.0)
    assert exponent == pytest.approx(2.0 * hurst, abs=0.12)


def test_sensors_of_any_pixel_size_see_one_field() -> None:
    coarse = whole(field(SEA_TEMPERATURE, 3000.0, size=64), 64)
    fine = whole(field(SEA_TEMPERATURE, 750.0, size=256), 256)
    means = fine.reshape(64, 4, 64, 4).mean(axis=(1, 3))
    # Cells smaller than the coarse pixel, a fiftieth of the variance, are in the fine image only.
    assert np.sqrt(np.mean((means - coarse) ** 2)) < 0.1


@pytest.mark.parametrize("pixel_size_m", [5.0, 333.0, 3000.0, 20e3])
@pytest.mark.parametrize("first", [0, -(10**9), 10**9 + 3])
def test_pixels_have_the_same_bits_in_any_window(pixel_size_m: float, first: int) -> None:
    texture = field(WATER_VAPOUR, pixel_size_m, velocity_m_s=(11.3, -4.0), platform_speed_m_s=7e3)
    rows, columns = slice(first, first + 40), slice(first, first + 70)
    all_pixels = texture.at(1e9, rows, columns)
    assert np.isfinite(all_pixels).all()
    for y, x in ((0, 0), (13, 29), (39, 69)):
        part = texture.at(1e9, slice(first + y, first + y + 1), slice(first + x, first + min(x + 5, 70)))
        np.testing.assert_array_equal(part, all_pixels[y : y + 1, x : x + 5])


@pytest.mark.parametrize(("size", "pixel_size_m"), [(800, 20.0), (64, 20.0), (192, 3000.0)])
def test_an_image_has_no_wavelength_longer_than_itself(size: int, pixel_size_m: float) -> None:
    cells = [pixel_size_m / each.x.step for each in field(SEA_TEMPERATURE, pixel_size_m, size=size).octaves]
    assert 0.5 * max(cells) <= 0.25 * size * pixel_size_m
    assert max(cells) == min(160e3, max(cells))


def test_the_mean_of_a_scene_stays_near_the_temperature_that_is_given() -> None:
    """Of all wavelengths the mean of 16 km would differ by some .9 of the standard deviation over 300 km."""
    means = [np.mean(whole(field(SEA_TEMPERATURE, 320.0, seed, 50), 50)) for seed in range(24)]
    assert np.std(means) < 0.12


def test_vapour_drifts_with_the_wind_and_the_sea_stays() -> None:
    sea, still = field(SEA_TEMPERATURE, 3000.0), whole(field(SEA_TEMPERATURE, 3000.0))
    np.testing.assert_array_equal(whole(sea, time_s=3600.0), still)
    vapour = field(WATER_VAPOUR, 3000.0, velocity_m_s=(10.0, 0.0))
    first, later = whole(vapour), whole(vapour, time_s=600.0)  # two pixels to the east
    moved = np.corrcoef(first[:, :-2].ravel(), later[:, 2:].ravel())[0, 1]
    assert moved > 0.04 + np.corrcoef(first.ravel(), later.ravel())[0, 1]
    assert moved > 0.85


@pytest.fixture(scope="module")
def textured():
    return simulate(
        scene(
            **{**CHEAP, "sea": CHEAP["sea"] | {"temperature_texture": 0.5}},
            atmosphere={**WITHOUT_HAZE, "water_vapour_texture": 0.05},
            clouds={"type": "paper-stratus", "coverage": 0.5, "coverage_mode": "field"},
            output={"variables": ["radiance", "cloud_thickness", "sea_temperature", "water_vapour_factor"]},
        )
    )


def test_a_pixel_has_the_radiance_of_a_scene_with_its_sea_and_vapour(textured) -> None:
    clear = textured.cloud_thickness.values[0] == 0.0
    sea, vapour = textured.sea_temperature.values[0], textured.water_vapour_factor.values[0]
    warmer, moister = (sea - 293.0) / 0.5, (vapour - 1.0) / 0.05
    for t, q in ((1.0, 2.0), (-2.0, 1.0), (0.0, -1.0)):  # standard deviations
        away = np.where(clear, np.hypot(warmer - t, moister - q), np.inf)
        place = np.unravel_index(np.argmin(away), away.shape)
        assert away[place] < 1.0
        own = scene(
            **{**CHEAP, "sea": CHEAP["sea"] | {"temperature": float(sea[place])}},
            image={"rows": 1, "columns": 1},
            atmosphere={**WITHOUT_HAZE, "water_vapour_scale": float(vapour[place])},
            output={"variables": ["radiance"]},
        )
        exact = simulate(own).radiance.values[0, :, 0, 0]
        np.testing.assert_allclose(textured.radiance.values[0][:, place[0], place[1]], exact, rtol=4e-4)


def test_the_slope_of_optical_depth_jumps_at_the_kinks_of_haze_and_nowhere_else() -> None:
    profile, wavenumber, path = load_profile("tropical", Catalog()), np.array([3500.0]), [to_space(0.0, 30.0)]

    def provider(factor: float) -> BandModelTransmittance:
        air = AtmosphereInputs(with_factors(profile, {"h2o": factor}), Catalog())
        return BandModelTransmittance(air, BandModelParameters())

    low, high = 0.8, 1.2
    kinks = provider(1.0).vapour_kinks(low, high)
    assert len(kinks) == 2

    def depth(factor: float) -> float:
        return -float(np.log(provider(factor).transmittance(wavenumber, path)[0, 0]))

    def bend(factor: float) -> float:
        step = 2e-3
        return abs(depth(factor + step) - 2.0 * depth(factor) + depth(factor - step)) / step

    smooth = [bend(factor) for factor in (low, 0.5 * sum(kinks), high)]
    assert min(map(bend, kinks)) > 5.0 * max(smooth)


@pytest.mark.parametrize("kinks", [(), (-0.4, 0.9), (0.02,), (1.5, 1.6)])
@pytest.mark.parametrize("order", [1, 2, 4])
def test_polynomials_between_kinks_meet_their_nodes_and_the_scene_is_unchanged(kinks: tuple, order: int) -> None:
    nodes = nodes_between(kinks, order)
    weights = change_weights(nodes, np.array([0.0, *nodes.places]))
    if any(0.0 in segment for segment in nodes.segments):
        np.testing.assert_array_equal(weights[:, 0], 0.0)
    np.testing.assert_allclose(weights[:, 1:], np.eye(len(nodes.places)), atol=1e-12)
    inside = np.linspace(-2.0, 2.0, 41)
    bent = (
        sum(np.abs(np.array([*inside, *nodes.places]) - kink) for kink in kinks)
        + 1.0
        + 0.5 * np.array([*inside, *nodes.places])
    )
    at_scene = 1.0 + sum(abs(kink) for kink in kinks)
    change = (bent[41:] - at_scene) @ change_weights(nodes, inside)
    np.testing.assert_allclose(change, bent[:41] - at_scene, atol=1e-12)


@pytest.mark.long
def test_the_stated_error_covers_the_kink_of_haze_at_70_percent_humidity() -> None:
    """By day in 2.7-3.0 um at 5 N the path passes 70 and 80 % within the texture: haze swells otherwise below."""
    place, time = {"latitude": 5.0, "longitude": -150.0}, "2024-04-20T12:30:00+10:00"
    changes = {"time": time, "place": place, "view": {"zenith": 0.0}, "bands": ["swir-2.7-3.0"]}
    vapour = {"atmosphere": {"water_vapour_texture": 0.05}}
    cube = simulate(scene(**changes, **vapour, output={"variables": ["radiance", "water_vapour_factor"]}))
    assert float(cube.attrs["hcss_table_error_estimated"]) < 5e-3
    factor = cube.water_vapour_factor.values[0]
    for wanted in (0.92, 0.935, 0.95, 1.0):
        pixel = np.unravel_index(np.argmin(np.abs(factor - wanted)), factor.shape)
        own = scene(
            **changes,
            image={"rows": 1, "columns": 1},
            atmosphere={"water_vapour_scale": float(factor[pixel])},
            output={"variables": ["radiance"]},
        )
        exact = float(simulate(own).radiance.values[0, 0, 0, 0])
        away = abs(float(cube.radiance.values[0, 0][pixel]) / exact - 1.0)
        assert away <= float(cube.attrs["hcss_table_error_estimated"])


@pytest.mark.long
@pytest.mark.parametrize(
    ("time", "band"),
    [("2020-09-06T00:45:00+00:00", [10.3, 11.3]), ("2020-09-06T12:00:00+00:00", [3.8, 3.9])],
    ids=["night", "day"],
)
def test_the_sea_shows_through_cloud_as_where_all_is_solved_over_a_warmer_sea(time: str, band: list[float]) -> None:
    changes = {"clouds": {"type": "paper-stratus", "coverage": 0.5}, "sea": {"temperature_texture": 0.5}}
    plan = make_plan(scene(**changes, time=time, bands=[band]))
    warmer = replace(plan, assembly=plan.texture.perturbed(plan.assembly, (1.0, 0.0)))
    columns, sun = BandColumns(plan, plan.spectral_grid.all_nodes()), plan.sun_up_at(0.0)
    thickness = np.array([[2.0], [20.0]])
    scene_, derived, solved = (
        np.sum(each.cloudy(thickness, [each.plan.assembly.setting(sun)])[0], axis=1)
        for each in (columns, OverWarmerSea(columns, warmer, sun), columns.of(warmer))
    )
    warm, own = (
        np.sum(each.clear([each.plan.assembly.setting(sun)])[0], axis=0) for each in (columns.of(warmer), columns)
    )
    clear = warm - own
    np.testing.assert_allclose((derived - scene_) / clear, (solved - scene_) / clear, atol=0.01)


def test_sea_temperature_vanishes_beneath_opaque_cloud() -> None:
    same = {"clouds": {"type": "stratus", "coverage": 0.5, "coverage_mode": "field"}, "bands": [[10.3, 11.3]]}
    cube, plain = (
        simulate(scene(**{**CHEAP, "sea": CHEAP["sea"] | {"temperature_texture": each}}, **same)) for each in (0.5, 0.0)
    )
    change, thickness = cube.radiance.values[0] / plain.radiance.values[0] - 1.0, cube.cloud_thickness.values[0]
    clear, thick = thickness == 0.0, thickness > 0.8 * thickness.max()
    assert np.all(np.std(change[:, clear], axis=1) > 2e-3)
    assert np.all(np.abs(change[:, thick]) < 1e-4)


@pytest.mark.long
def test_certificate_includes_the_texture() -> None:
    cube = simulate(
        scene(
            sea={"temperature_texture": 0.5},
            atmosphere={"water_vapour_texture": 0.05},
            clouds={"type": "cirrus", "coverage": 0.5, "coverage_mode": "field"},
            output={"certificate": 12},
            accuracy=1e-2,
        )
    )
    assert cube.attrs["hcss_certificate"].startswith("computed as specified")


@pytest.mark.long
def test_over_a_map_the_sea_has_the_texture_of_a_sea_alone_and_land_that_of_its_air(tmp_path: Path) -> None:
    latitude, longitude = np.linspace(34.0, 36.0, 101), np.linspace(149.0, 151.0, 100)
    for ground, west in (("half", 0.0), ("land", 1.0)):
        classes = np.where(longitude > 150.0, 1.0, west) * np.ones((101, 1))
        write_netcdf(tmp_path / f"{ground}.nc", latitude, longitude, surface_class=classes)

    def cube(name: str | None, kelvin: float, vapour: float, *more: str) -> Dataset:
        parameters = {"file": str(tmp_path / f"{name}.nc"), "classes": {0: "sea", 1: "sand"}}
        parameters["temperatures"] = {"sand": 303.0}
        ground = {} if name is None else {"surfaces": {"provider": "raster", "parameters": parameters}}
        return simulate(scene(
            radiance={"model": "as-printed"}, optics={"provider": "mie"}, accuracy=1e-3, clouds={}, **ground,
            sea={"model": "cox-munk", "temperature_texture": kelvin},
            atmosphere={"water_vapour_texture": vapour, **WITHOUT_HAZE},
            place={"latitude": 35.0, "longitude": 150.0}, image={"rows": 30, "columns": 24, "pixel_size": 3000.0},
            output={"variables": ["radiance", *more], "certificate": 6 if name else 0},
        ))  # fmt: skip

    both = cube("half", 0.5, 0.1, "surface_class", "surface_temperature", "sea_temperature")
    assert both.attrs["hcss_certificate"].startswith("computed as specified")
    of_sea = both["surface_class"].values[0] == 0
    assert 0.3 < of_sea.mean() < 0.7
    alone, land, even = (cube(*given)["radiance"].values[0] for given in ((None, 0.5, 0.1), ("land", 0.5, 0.1),
                                                                          ("land", 0.0, 0.0)))  # fmt: skip
    radiance, kelvin = both["radiance"].values[0], both["surface_temperature"].values[0]
    np.testing.assert_allclose(radiance[:, of_sea], alone[:, of_sea], rtol=1e-4)
    np.testing.assert_allclose(radiance[:, ~of_sea], land[:, ~of_sea], rtol=1e-4)
    assert np.ptp(land / even) > 1e-4
    np.testing.assert_allclose(kelvin[~of_sea], 303.0)
    np.testing.assert_allclose(kelvin[of_sea], both["sea_temperature"].values[0][of_sea], rtol=1e-6)
    assert np.ptp(kelvin[of_sea]) > 0.5


def test_keys_that_exclude_texture_are_named() -> None:
    with pytest.raises(ScenarioError, match=r"sea_temperature.*texture"):
        simulate(scene(sea={"temperature_texture": 0.0}, output={"variables": ["sea_temperature"]}))


@pytest.mark.parametrize("per_pixel", [1.0, 1.0 / 0.05], ids=["fraction", "kelvin"])
def test_texture_of_the_sea_is_skipped_where_its_bound_is_below_a_tenth_of_the_accuracy(per_pixel: float) -> None:
    changes = {**CHEAP, "bands": [[10.3, 11.3]], "image": {"rows": 64, "columns": 64, "pixel_size": 20.0}}
    even = make_plan(scene(**changes | {"sea": CHEAP["sea"] | {"temperature_texture": 0.0}}))
    bound = next(each.bound for each in even.omissions if each.what == "texture of the sea's temperature")
    # black body at 293 K and 10.3 um: .0163 of its radiance for a kelvin
    limits = [10.0 * bound * part for part in (0.98, 1.02)]
    asked = [limit if per_pixel == 1.0 else f"{limit / 0.01633:.5g} K" for limit in limits]
    assert [make_plan(scene(**changes, accuracy=each)).texture.varies for each in asked] == [True, False]


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({}, ""),
        ({"sea": {"temperature_texture": 0.0}}, "sea.temperature_texture is 0"),
        ({"image": {"rows": 64, "columns": 64, "pixel_size": 20.0}}, ""),
        ({"image": {"rows": 64, "columns": 64, "pixel_size": 20.0}, "accuracy": 0.05}, "less than its share"),
        ({"image": {"rows": 64, "columns": 64, "pixel_size": 1.0}}, "smaller than its smallest structures"),
        ({"surfaces": {}}, "a map of the ground"),
    ],
    ids=["default", "off", "small image", "coarse accuracy", "smaller image", "map"],
)
def test_the_sea_has_texture_by_default_and_the_plan_says_where_not(changes: dict, why: str) -> None:
    cheap = {"radiance": {"model": "as-printed"}, "optics": {"provider": "mie"}}
    plan = make_plan(scene(**cheap, **{**changes, "sea": {"model": "cox-munk"} | changes.get("sea", {})}))
    omitted = [each for each in plan.omissions if each.what == "texture of the sea's temperature"]
    if not why:
        assert plan.texture.temperature_K == 0.3
        assert not omitted
        return
    assert plan.texture.temperature_K == 0.0
    (omission,) = omitted
    assert why in omission.why
    assert 0.0 < omission.bound < 0.08
    assert bool(omission.needs) == ("is 0" in why)


@pytest.mark.parametrize(
    ("changes", "deviation"),
    [
        ({"bands": [[10.3, 11.3]]}, 0.05),
        ({}, 0.0),
        ({"bands": [[10.3, 11.3]], "image": {"pixel_size": 500.0}}, 0.0),
        ({"bands": [[10.3, 11.3]], "platform": {"altitude": 800e3}}, 0.0),
        ({"bands": [[10.3, 11.3]], "output": {"variables": ["cloud_thickness"]}}, 0.0),
    ],
    ids=["wide and thermal", "with 3.6 um", "96 km", "view of each pixel", "no radiance"],
)
def test_vapour_has_texture_by_default_in_wide_thermal_images(changes: dict, deviation: float) -> None:
    assert make_plan(scene(**{**CHEAP, **changes})).texture.water_vapour == deviation


@pytest.mark.parametrize(("method", "deviation"), [("temperature", 0.0), ("otsu", 0.3)])
def test_clear_sky_of_an_image_has_the_texture_of_the_sea_unless_it_shows_its_own(
    tmp_path: Path, method: str, deviation: float
) -> None:
    kelvin = np.where(np.arange(64) < 20, 280.0, 293.0) + np.zeros((64, 64))
    Dataset({"ir": (("y", "x"), kelvin, {"units": "K", "long_name": "brightness temperature"})}).to_netcdf(
        tmp_path / "image.nc"
    )
    clouds = {
        "type": "stratus", "generator": "imagery",
        "parameters": {"image": "image.nc", "method": method, "reinterpret_pixel_size": True},
    }  # fmt: skip
    described = {**BASE, **CHEAP, "clouds": clouds, "image": {"rows": 64, "columns": 64, "pixel_size": 3000.0}}
    plan = make_plan(Scenario.from_dict(described, base=tmp_path))
    assert plan.texture.temperature_K == deviation


@pytest.mark.parametrize("given", [None, 0.0])
def test_the_plan_says_how_many_kelvin_a_texture_of_vapour_would_change(given: float | None) -> None:
    cheap = {"radiance": {"model": "as-printed"}, "optics": {"provider": "mie"}, "sea": {"model": "cox-munk"}}
    plan = make_plan(scene(**cheap, **({} if given is None else {"atmosphere": {"water_vapour_texture": given}})))
    (omission,) = [each for each in plan.omissions if each.what == "texture of water vapour"]
    assert plan.texture.water_vapour == 0.0
    assert omission.decision == ("too dear" if given is None else "switched off")
    assert omission.needs == "atmosphere.water_vapour_texture = 0.05"
    assert omission.why.endswith(" K")
    assert 0.0 < 3.0 * omission.estimate < omission.bound < 0.1


def test_the_size_that_is_stated_is_that_of_a_scene_with_as_much_less_vapour() -> None:
    cheap = {"radiance": {"model": "as-printed"}, "optics": {"provider": "mie"}, "sea": {"model": "cox-munk"}}
    even = {"sea": cheap["sea"] | {"temperature_texture": 0.0}, "bands": [[10.3, 11.3]]}
    small = {"image": {"rows": 4, "columns": 4, "pixel_size": 100e3}}  # so that all structures are within
    without, drier = (
        scene(**{**cheap, **even, **small}, atmosphere={"water_vapour_texture": 0.0, "water_vapour_scale": each})
        for each in (1.0, 0.95)
    )
    (omission,) = [each for each in make_plan(without).omissions if each.what == "texture of water vapour"]
    before, after = (float(simulate(each).radiance.values.mean()) for each in (without, drier))
    assert omission.estimate == pytest.approx(abs(after / before - 1.0), rel=0.1)


@pytest.mark.parametrize(
    "textured",
    [
        {"sea.temperature_texture": 0.5},
        {"atmosphere.water_vapour_texture": 0.05},
        {
            "sea.temperature_texture": 0.5,
            "atmosphere.water_vapour_texture": 0.05,
            "sea.waves": "on",
            "sea.wind_speed": 15.0,
            "image.pixel_size": 50.0,
        },
    ],
    ids=["sea", "vapour", "both below waves"],
)
def test_clouds_keep_from_the_sea_the_sunlight_that_it_mirrors_with_its_texture(textured: dict[str, object]) -> None:
    day = {
        "time": "2024-04-20T12:30:00+10:00",
        "place": {"latitude": 35.0, "longitude": 150.0},
        "view": {"zenith": 20.0, "azimuth": 18.72},  # toward the glint
        "image": {"rows": 40, "columns": 40, "pixel_size": 400.0},
        "clouds": {"type": "cumulus", "coverage": 0.4, "coverage_mode": "field"},
        "bands": [[3.6, 3.8]],
        "sea": {"model": "rough-sea", "temperature_texture": 0.0, "waves": "off"},
        "output": {"variables": ["radiance", "terms", "cloud_mask"], "certificate": 40},
    }
    shaded, lit = (
        simulate(Scenario.from_dict({**BASE, **CHEAP, **day}, {**textured, "slant.shadows": each}))
        for each in ("on", "off")
    )
    assert shaded.attrs["hcss_certificate"].startswith("computed as specified")
    terms = [values.values.astype(float) for name, values in shaded.items() if name.startswith("radiance_")]
    np.testing.assert_allclose(np.sum(terms, axis=0), shaded["radiance"], rtol=1e-6)
    mirrored, of_all = (cube["radiance_sea_reflected_sun"].values.astype(float) for cube in (shaded, lit))
    clear = np.broadcast_to(shaded["cloud_mask"].values[:, None] == 0, mirrored.shape)
    dark = clear & (of_all > 0.0) & (mirrored < 0.02 * of_all)
    assert dark.sum() > 10
    # Behind thick cloud nothing is left, however much the texture of the point mirrors.
    assert np.quantile(mirrored[dark] / of_all[dark], 0.5) < 1e-4


def test_no_pixel_changes_by_more_than_the_bound_of_the_vapour_that_has_no_texture() -> None:
    # Over a sea colder than the air, warm air makes up for the sea that more vapour hides: clear sky hardly changes.
    cirrus = {
        "time": "2024-01-20T00:30:00+10:00",
        "place": {"latitude": 35.0, "longitude": 150.0},
        "image": {"rows": 32, "columns": 32, "pixel_size": 100.0},
        "bands": ["lwir-10.8"],
        "atmosphere": {"profile": "us-standard-1976", "parameters": {"aerosol": "none"}},
        "clouds": {"type": "cirrus", "generator": "fractal", "coverage": 0.5},
        "sea": {"model": "cox-munk", "temperature": 277.6, "temperature_texture": 0.0},
        "accuracy": 1e-3,
    }
    even, drawn = (
        Scenario.from_dict({**BASE, **CHEAP, **cirrus}, {"atmosphere.water_vapour_texture": each})
        for each in (0.0, 0.05)
    )
    (told,) = (each for each in make_plan(even).omissions if each.what == "texture of water vapour")
    before, after = simulate(even), simulate(drawn)
    change = np.abs(after["radiance"] / before["radiance"] - 1.0).values[:, 0]
    cloudy = before["cloud_thickness"].values > 0.0
    assert told.estimate is not None
    assert told.bound is not None
    assert np.max(change[cloudy]) > 5.0 * 5.0 * told.estimate  # five deviations of clear sky are no bound
    assert np.max(change) < told.bound + 1e-3
