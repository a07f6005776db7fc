"""Laws of scenes with several cloud layers."""

import json

import numpy as np
import pytest
from cheap import CHEAP, NARROW
from reference_agreement import assert_tables_agree_with_the_reference_path

from hcss_twin import Scenario, ScenarioError, make_plan, simulate
from hcss_twin.models.radiance.spectral_grid import SpectralGrid
from hcss_twin.plan.clouds import layer_seed
from hcss_twin.plan.description import describe
from hcss_twin.reports.plan_text import plan_text

BASE = {
    "time": "2024-04-20T12:30:00+10:00",
    "place": {"latitude": 35.0, "longitude": 150.0},
    "image": {"rows": 48, "columns": 64},
    "frames": {"count": 2},
    "atmosphere": {"profile": "us-standard-1976", "parameters": {"aerosol": "none"}},
    "sea": {"temperature": 291.4, "wind_speed": 10.0},
    "bands": ["mwir-3.7", "lwir-10.8"],
    "seed": 3,
}
BANDS = 2
CUMULUS = {"type": "cumulus", "coverage": 0.4, "base": 66.0, "top": 3000.0}
CIRRUS = {"type": "cirrus", "coverage": 0.6, "base": 6000.0, "top": 10_000.0}
OWN = {"radiance.model": "physical", "sea.model": "rough-sea", "optics.provider": "bulk"}
"""The default models, which the paper's replace elsewhere."""


def scenario(*layers, **overrides):
    return Scenario.from_dict({**BASE, "clouds": {"layers": list(layers)}}, {**CHEAP, **overrides})


def cube(*layers, **overrides):
    return simulate(scenario(*layers, **{"output.variables": ["all"], "output.certificate": 0, **overrides}))


@pytest.fixture(scope="module")
def both():
    return cube(CUMULUS, CIRRUS)


def test_layers_in_either_order_of_the_file_give_the_same_cube(both):
    other = cube(CIRRUS, CUMULUS)
    assert set(other) == set(both)
    for name in both.variables:
        np.testing.assert_array_equal(other[name], both[name])


def test_terms_sum_to_the_total(both):
    total = sum(both[name].astype(np.float64) for name in both if name.startswith("radiance_"))
    np.testing.assert_allclose(total, both.radiance, rtol=3e-7)


def test_the_lowest_layer_is_that_of_a_scene_without_the_others(both):
    alone = cube(CUMULUS)
    np.testing.assert_array_equal(both.cloud_layer_thickness.sel(layer="cumulus"), alone.cloud_thickness)


def test_seeds_of_layers_differ_and_the_first_is_that_of_the_scene():
    seeds = {layer_seed(seed, index) for seed in (0, 1, 2, 2**63 - 1) for index in range(3)}
    assert len(seeds) == 12
    assert all(0 <= seed < 2**63 for seed in seeds)
    assert layer_seed(17, 0) == 17


def test_layers_of_the_same_type_are_independent_of_each_other():
    twins = cube(
        {"type": "stratus", "coverage": 0.5, "coverage_mode": "frame"},
        {"type": "stratus", "coverage": 0.5, "coverage_mode": "frame", "base": 4000, "top": 4967},
        **{"output.variables": ["cloud_layer_thickness"]},
    )
    low, high = (twins.cloud_layer_thickness[0, index].values > 0 for index in (0, 1))
    # Both cover half of the frame; were they the same field, half of the pixels would have both.
    assert 0.05 < np.mean(low & high) < 0.45


def test_where_one_layer_has_cloud_the_radiance_is_that_of_its_own_scene(both):
    for layer, name in ((CUMULUS, "cumulus"), (CIRRUS, "cirrus")):
        thickness = both.cloud_layer_thickness[0]
        others = thickness.sum("layer") - thickness.sel(layer=name)
        where = ((thickness.sel(layer=name) > 0) & (others == 0)).values
        assert where.any()
        plan = make_plan(scenario(layer))
        exact = SpectralGrid.reference_radiance(
            plan.assembly.model,
            plan.assembly.setting(plan.sun_track.at(0.0)),
            plan.spectral_grid,
            thickness.sel(layer=name).values[where][:10],
        )
        np.testing.assert_allclose(both.radiance[0].values[:, where][:, :10].T, exact, rtol=1e-4 + 3e-7)


def under_both(random, thickness_m):
    """Pixels under both layers."""
    return random.choice(np.flatnonzero(np.all(thickness_m > 0, axis=1)), 12)


CASES = {
    "day": {},
    "night": {"time": "2024-04-20T00:30:00+10:00"},
    "slant": {"view.zenith": 60.0, "frames.count": 3, "frames.interval": 1200.0},
    "anchored": {"clouds.layers.1.anchor": "top", "clouds.layers.0.temperature": 270.0},
    "literal": {"radiance.parameters": {"literal_eq19": True, "literal_eq20": True}},
}


@pytest.mark.parametrize(
    ("case", "accuracy"),
    [("day", 1e-2), *((case, 1e-3) for case in CASES)]
    + [pytest.param(case, 1e-4, marks=pytest.mark.campaign) for case in CASES],
)
def test_tables_of_two_layers_agree_with_the_reference_path(case, accuracy):
    plan = make_plan(scenario(CUMULUS, CIRRUS, accuracy=accuracy, **CASES[case]))
    assert_tables_agree_with_the_reference_path(plan, under_both)


@pytest.mark.parametrize(
    "time",
    [
        pytest.param("2024-04-20T12:30:00+10:00", marks=pytest.mark.long),
        pytest.param("2024-04-20T00:30:00+10:00", marks=pytest.mark.campaign),
    ],
)
def test_tables_of_two_layers_of_the_default_models_agree_with_the_reference_path(time):
    plan = make_plan(scenario(CUMULUS, CIRRUS, **{**OWN, "accuracy": 1e-2, "time": time, "frames.count": 1}))
    assert_tables_agree_with_the_reference_path(plan, under_both)


def test_truth_of_two_layers(both):
    thickness = both.cloud_layer_thickness.values
    low, high = thickness[:, 0], thickness[:, 1]
    np.testing.assert_allclose(both.cloud_thickness, low + high, rtol=2e-7)
    np.testing.assert_array_equal(both.cloud_mask, (low > 0) | (high > 0))
    np.testing.assert_array_equal(both.cloud_fraction, both.cloud_mask)
    top = np.where(high > 0, 6000.0 + high, np.where(low > 0, 66.0 + low, np.nan))
    np.testing.assert_allclose(both.cloud_top_altitude, top, rtol=1e-6)
    profile = make_plan(scenario(CUMULUS)).assembly.profile
    temperature = np.interp(top, profile.altitude_m, profile.temperature_K)
    np.testing.assert_allclose(both.cloud_top_temperature, temperature, rtol=1e-5)
    depth = both.cloud_optical_thickness.values
    for index, pick in ((0, (low > 0) & (high == 0)), (1, (low == 0) & (high > 0))):
        per_metre = np.stack([depth[:, band][pick] / thickness[:, index][pick] for band in range(BANDS)])
        np.testing.assert_allclose(per_metre, per_metre[:, :1].repeat(per_metre.shape[1], 1), rtol=1e-6)


def test_a_layer_is_named_as_the_file_has_it_whatever_its_altitude():
    with pytest.raises(ScenarioError) as caught:
        make_plan(scenario({**CIRRUS, "generator": "imagery", "parameters": {"image": "none.png"}}, CUMULUS))
    assert [problem.field for problem in caught.value.problems] == ["clouds.layers[0].parameters.image"]


def test_plan_and_provenance_name_both_layers(both):
    plan = make_plan(scenario(CIRRUS, CUMULUS))
    assert [layer["name"] for layer in describe(plan)["layers"]] == ["cumulus", "cirrus"]
    assert "cirrus: coverage 0.6 of the sky on average, base 6000 m, tops to 10000 m, 50 to 4000 m" in plan_text(plan)
    assert set(json.loads(both.attrs["hcss_providers"])) >= {"clouds[0]", "clouds[1]"}
    assert "cirrus over cumulus clouds" in both.attrs["summary"]
    assert plan.uncompressed_bytes == 2 * 48 * 64 * (BANDS * 4 + 1)


def test_layers_whose_clouds_are_as_good_as_equally_thick_run():
    nearly = np.nextafter(1.0, 0.0)
    thin = {"type": "cirrus", "coverage": 1.0, "base": 1.0, "top": 2.0, "thickness_min": float(nearly)}
    equal = cube({**thin, "thickness_min": 1.0}, **{"frames.count": 1})
    other = cube(thin, **{"frames.count": 1})
    np.testing.assert_allclose(other.radiance, equal.radiance, rtol=1e-6)


ALTOCUMULUS = {"type": "altocumulus", "coverage": 0.5}


@pytest.mark.long
@pytest.mark.parametrize(
    "more",
    [
        {},
        {"image.samples_per_pixel": 2},
        {"slant.shadows": "on", "slant.parallax": "on"},
        {"sea.temperature_texture": 0.3, "atmosphere.water_vapour_texture": 0.05},
        {"platform.altitude": 8e5, "image.pixel_size": 8e3},
        {"sea.waves": "on", "sea.model": "rough-sea", "image.pixel_size": 10.0},
        {"frames.count": 3, "frames.interval": 5400.0},
    ],
    ids=["alone", "points", "shadows", "texture", "views", "waves", "moving sun"],
)
def test_three_layers_are_certified_beside_every_effect(more):
    small = {"image.rows": 24, "image.columns": 24, "accuracy": 1e-2, "frames.count": 1, "output.certificate": 12}
    small |= {"bands": ["lwir-10.8"] if more else ["mwir-3.7", "lwir-10.8"]}
    layers = [layer | {"coverage_mode": "field"} for layer in (CUMULUS, ALTOCUMULUS, CIRRUS)]
    made = simulate(scenario(*layers, **(small | more)))
    assert made.attrs["hcss_certificate"].startswith("computed as specified")
    strata = {each["name"]: each["checked"] for each in json.loads(made.attrs["hcss_certificate_strata"])}
    assert sum(checked for name, checked in strata.items() if "three layers" in name or "two layers" in name) > 0


def test_a_third_layer_without_cloud_leaves_the_radiance_of_two(both):
    empty = {"type": "cirrus", "coverage": 0.0, "base": 13e3, "top": 14e3}
    np.testing.assert_array_equal(cube(CUMULUS, CIRRUS, empty).radiance, both.radiance)


@pytest.mark.long
@pytest.mark.parametrize("models", [{}, pytest.param(OWN, marks=pytest.mark.campaign)], ids=["as-printed", "default"])
def test_five_layers_are_certified(models):
    heights = {"cumulus": (300.0, 1200.0), "stratus": (1500.0, 2200.0), "altocumulus": (3000.0, 3600.0)}
    layers = [{"type": kind, "coverage": 0.5, "base": low, "top": high} for kind, (low, high) in heights.items()]
    layers += [{"type": "altocumulus", "coverage": 0.4, "base": 5000.0, "top": 5500.0}, CIRRUS | {"base": 9000.0}]
    small = {"image.rows": 32, "image.columns": 32, "accuracy": 1e-2, "frames.count": 1, "output.certificate": 20}
    made = simulate(scenario(*layers, **(models | small | {"bands": NARROW[1:]})))
    assert made.attrs["hcss_certificate"].startswith("computed as specified")
