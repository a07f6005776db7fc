"""What a plan finds out before anything is computed, and what it says was left out or filled in."""

import numpy as np
import pytest
from cheap import CHEAP
from refusals import problems_of

from hcss_twin import Scenario, ScenarioError, make_plan
from hcss_twin.engine.compile import compile_tables
from hcss_twin.plan.description import describe

TINY = {"image.rows": 8, "image.columns": 8, "frames.count": 2}
COARSE = {"accuracy": 1e-2, "bands": ["lwir-10.8"]}


@pytest.mark.parametrize(
    ("overrides", "field", "message"),
    [
        ({"time": "3000-01-01T00:00:00Z"}, "time", "1700 to 2200"),
        ({"frames.first": 10_000_000, "frames.interval": 1e6}, "frames", "1700 to 2200"),
        ({"bands": [[17.0, 30.0]]}, "bands[0]", "0.3 to 16 um"),
        ({"bands": [[0.26, 0.28]]}, "bands[0]", "0.3 to 16 um"),
        ({"clouds.top": 40.0}, "clouds.thickness_min", "closest valid choice is 7"),
        (
            {"atmosphere.provider": "table", "atmosphere.parameters": {"file": "us-standrd"}},
            "atmosphere.parameters.file",
            "closest is",
        ),
        ({"sea.parameters": {"water_index": "watr"}}, "sea.parameters.water_index", "closest is 'water'"),
        ({"output.variables": ["radiance_sun"]}, "output.variables", "radiance_sea_reflected_sun"),
        # 26 air masses: LOWTRAN7's table ends at 88 degrees.
        (
            {
                **CHEAP,
                "atmosphere.provider": "table",
                "time": "2024-03-21T12:00:00Z",
                "place.latitude": 90.0,
                "place.longitude": 0.0,
            },
            "time",
            "air mass",
        ),
    ],
)
def test_what_cannot_be_had_is_said_before_the_scene_is_computed(overrides, field, message):
    problems = problems_of(lambda: make_plan(Scenario.load("stratus", {**TINY, **overrides})))
    assert message in problems[field]


@pytest.mark.long
def test_a_sun_lower_than_the_table_is_seen_through_air_that_the_plan_says_is_fitted():
    """The default radiance model follows light leg by leg and asks for no path of 26 air masses."""
    low = {"time": "2024-03-21T12:00:00Z", "place.latitude": 90.0, "place.longitude": 0.0}
    coarse = {"frames.count": 1, "bands": ["mwir-3.7"], "accuracy": 1e-2}
    plan = make_plan(Scenario.load("stratus", {**TINY, **low, **coarse, "atmosphere.provider": "table"}))
    assert 89.0 < plan.sun_track.at(0.0).zenith_deg < 90.0
    assert any("by a power law fitted to them" in note for note in plan.assembly.notes())
    tables = compile_tables(plan)
    assert all(np.all(np.isfinite(each)) and np.all(each >= 0.0) for each in tables.tables[0].columns.cores)
    assert tables.estimated_error < plan.accuracy.relative


def test_all_that_does_not_fit_is_said_at_once():
    overrides = {
        "bands": [[17.0, 30.0]],
        "atmosphere.parameters": {"file": "nope"},
        "sea.parameters": {"water_index": "x"},
    }
    with pytest.raises(ScenarioError) as caught:
        make_plan(Scenario.load("stratus", {**TINY, **overrides}))
    fields = {problem.field for problem in caught.value.problems}
    assert fields >= {"bands[0]", "atmosphere.parameters.file", "sea.parameters.water_index"}
    assert str(caught.value).startswith("stratus:")


def test_the_highest_cloud_the_table_allows_runs():
    overrides = {**TINY, **COARSE, "clouds.top": 20_000.0, "clouds.anchor": "base"}
    plan = make_plan(Scenario.load("cirrus", overrides))
    assert compile_tables(plan).axes[0].dense_m[-1] == plan.layers[0].thickness_max_m


def notes(name, **overrides):
    overrides["output.variables"] = ["cloud_mask"]  # notes do not depend on them, and no radiance is analysed
    return " ".join(make_plan(Scenario.load(name, {**TINY, **overrides})).assembly.notes())


@pytest.mark.parametrize("provider", ["mie", "bulk"])
def test_notes_on_ice_and_on_droplets_are_told_where_a_layer_has_them(provider):
    optics = {"optics.provider": provider}
    water, ice = notes("stratus", **optics), notes("cirrus", **optics)
    both = notes("cirrus-over-cumulus", **optics)
    clear = notes("stratus", **optics, **{"clouds": {"layers": []}})
    assert [" ice " in f" {text} " for text in (water, ice, both, clear)] == [False, True, True, False]
    assert ["droplets" in text for text in (water, ice, both, clear)] == [True, False, True, False]


def test_two_frames_far_apart_need_two_tables():
    overrides = {**TINY, **CHEAP, "frames.interval": 6 * 86400.0, "accuracy": 1e-4, "bands": ["mwir-3.7"]}
    tables = compile_tables(make_plan(Scenario.load("stratus", overrides)))
    assert len(tables.time_s) == 2


def test_what_was_filled_in_is_told():
    plan = make_plan(
        Scenario.from_toml("time = 2024-04-20T12:30:00+10:00\nplace = {latitude = 35.0, longitude = 150.0}", TINY)
    )
    assert {item.field for item in plan.filled_in} == {
        "atmosphere.profile",
        "atmosphere.gases",
        "sea.temperature",
        "sea.wind_speed",
    }
    assert any("no cloud" in item.why for item in plan.omissions)
    assert describe(plan)["uncompressed_bytes"] == 2 * 8 * 8 * (3 * 4 + 1)


def test_a_band_narrower_than_the_atmosphere_resolves_is_told():
    plan = make_plan(Scenario.load("stratus", {**TINY, "bands": ["lwir-10.8", [10.8, 10.81]]}))
    told = [note for note in plan.notes if "not resolved" in note]
    assert len(told) == 1
    assert "'10.8-10.81um' is 0.857 cm-1 wide" in told[0]


def test_a_sea_too_cold_for_its_model_is_refused_with_key_value_and_range():
    scenario = Scenario.load("stratus", {**TINY, "sea.temperature": 262.0})
    with pytest.raises(ScenarioError, match=r"sea\.temperature: 262 K is outside .*; allowed: 263.15 to 318.15 K"):
        make_plan(scenario)


def test_a_sea_that_sends_nothing_has_a_plan():
    foam = {"sea.model": "rough-sea", "sea.wind_speed": 38.0, "sea.parameters": {"foam_emissivity": 0.0}}
    calm = {"sea.parameters": {**foam.pop("sea.parameters"), "re_reflection": False, "shadowing": "none"}}
    scenario = Scenario.load("stratus", {**TINY, **foam, **calm, "bands": ["mwir-3.7"], "view.zenith": 0.0})
    assert make_plan(scenario).omissions
