"""Any scenario gives a sound cube or a clear error; nothing else."""

import copy
import json
import warnings

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from refusals import result_or_refusal
from scenario_space import PAPER, PHYSICAL, scenarios, wide_scenarios, write_files

from hcss_twin import Scenario, make_plan, simulate
from hcss_twin.core.errors import CertificateWarning
from hcss_twin.cube.requested_variables import term_variable
from hcss_twin.cube.variables import VARIABLES


def _settings(examples):
    return settings(
        max_examples=examples,
        deadline=None,
        derandomize=examples < 100,
        database=None,
        suppress_health_check=list(HealthCheck),
        print_blob=False,
    )


def _paths(value, path=()):
    if path:
        yield path
    entries = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, each in entries:
        yield from _paths(each, (*path, key))


scalars = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.integers(10**300, 10**400),
    st.floats(),
    st.text(max_size=12),
    st.sampled_from(["1 km", "20 degC", "130%", "frozen", "5 kg", "nan", "1e999 m", "~x/y", "..", "/", "a" * 300]),
    st.dates(),
    st.datetimes(),
    st.binary(max_size=3),
)
anything = st.recursive(
    scalars,
    lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(st.text(max_size=6), inner, max_size=3)),
    max_leaves=5,
)


@st.composite
def mutated(draw):
    """A scenario with some values replaced by anything, keys renamed, added and taken away."""
    raw = copy.deepcopy(draw(scenarios((*PAPER, *PHYSICAL))))
    for _ in range(draw(st.integers(1, 4))):
        path = draw(st.sampled_from(list(_paths(raw))))
        *parents, last = path
        target = raw
        for part in parents:
            target = target[part]
        match draw(st.sampled_from(["replace", "replace", "remove", "rename", "add"])):
            case "replace":
                target[last] = draw(anything)
            case "remove":
                del target[last]
            case "rename" if isinstance(target, dict):
                target[draw(st.one_of(st.text(max_size=8), st.just(f"{last}s")))] = target.pop(last)
            case _ if isinstance(target, dict):
                target[draw(st.text(max_size=8))] = draw(anything)
            case _:
                target.append(draw(anything))
        if not raw:
            break
    return raw


def check_cube(raw, base=None):
    """Simulate, and hold every variable against its limits in the table of variables; whether there is a cube."""
    made, error = result_or_refusal(lambda: _plan_and_cube(raw, base))
    if made is None:
        assert str(error).strip()
        return False
    plan, cube = made
    check_nothing_is_changed(raw, base, plan, cube)
    assert {spec.name for spec in plan.variables} <= set(cube)
    tables = {spec.name: spec for spec in VARIABLES}
    for spec in plan.variables:
        limits = tables.get(spec.name) or term_variable(spec.name.removeprefix("radiance_"), "")
        values = cube[spec.name].values
        present = values[np.isfinite(values)] if limits.may_be_missing else values
        assert not np.any(np.isinf(values)), spec.name
        assert np.all(np.isfinite(present)), spec.name
        if limits.lowest is not None:
            assert np.all(present >= limits.lowest), spec.name
        if limits.highest is not None:
            assert np.all(present <= limits.highest), spec.name
    if {"cloud_mask", "cloud_top_altitude"} <= set(cube):
        assert np.array_equal(np.isnan(cube["cloud_top_altitude"].values), cube["cloud_mask"].values == 0)
    return True


def _plan_and_cube(raw, base):
    scenario = Scenario.from_dict(raw, base=base)
    with warnings.catch_warnings():
        if "streams" in scenario.radiance.parameters:  # stated ones may be too few for the accuracy
            warnings.simplefilter("ignore", CertificateWarning)
        return make_plan(scenario), simulate(scenario)


def check_nothing_is_changed(raw, base, plan, cube):
    """What was asked for is what was planned and what the cube says: no value was moved into a range in silence."""
    assert Scenario.from_dict(json.loads(cube.attrs["hcss_scenario"]), base=base) == plan.scenario
    kept = json.loads(plan.scenario.to_json())
    for section in ("view", "image", "frames", "motion", "slant", "place", "sea", "atmosphere"):
        for key, value in raw.get(section, {}).items():
            assert kept[section][key] == value, (section, key)
    asked = raw.get("clouds", {})
    for given_, layer in zip(asked.get("layers", [asked] if asked else []), kept["clouds"]["layers"], strict=True):
        for key, value in given_.items():
            assert layer[key] == value or key in ("generator", "parameters"), key
    for band, resolved in zip(raw["bands"], plan.bands, strict=True):
        if isinstance(band, list):
            assert [resolved.lower_um, resolved.upper_um] == band
    assert cube.sizes["y"], cube.sizes["x"] == (raw["image"]["rows"], raw["image"]["columns"])


def check_refusal(raw):
    """Validate and plan; only errors on purpose may come out, each with a field and a message."""
    _, error = result_or_refusal(lambda: make_plan(Scenario.from_dict(raw)))
    for problem in getattr(error, "problems", ()):
        assert problem.field
        assert 0 < len(problem.message) < 2000
        # The wording of the validation library is for programmers.
        assert "Input should" not in problem.message or "unicode" in problem.message


def share_of_cubes(drawn, examples, base=None):
    """Check the cubes of drawn scenarios; share of the scenarios that give one."""
    made = []

    @_settings(examples)
    @given(drawn)
    def draw(raw):
        made.append(check_cube(raw, base))

    draw()
    return np.mean(made)


class TestAnyAllowedScenarioGivesASoundCubeOrAClearError:
    def test_few(self):
        # More than the simplest one gives a cube, or refusals only would be tested. About 0.4 do; which ones are
        # drawn depends on the version of hypothesis and on the modules that earlier tests have loaded.
        assert share_of_cubes(scenarios(), 10) > 0.1

    @pytest.mark.campaign
    @_settings(25)
    @given(scenarios())
    def test_many(self, raw):
        check_cube(raw)

    def test_few_of_the_default_models(self):
        assert share_of_cubes(scenarios(PHYSICAL), 4) > 0

    @pytest.mark.campaign
    @_settings(2)
    @given(scenarios(PHYSICAL))
    def test_more_of_the_default_models(self, raw):
        check_cube(raw)


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    return write_files(tmp_path_factory.mktemp("files"))


class TestAnyAllowedSurroundingsAndShapesOfImagesDoToo:
    """Atmospheres, particles, seas, generators, responses, 0.7 to 14.3 um, images of 1 to 4096 pixels width."""

    def test_few(self, files):
        assert share_of_cubes(wide_scenarios(PAPER), 10, files) > 0.1

    @pytest.mark.campaign
    @_settings(25)
    @given(raw=wide_scenarios(PAPER, particles=True))
    def test_many(self, raw, files):
        check_cube(raw, files)

    @pytest.mark.campaign
    @_settings(5)
    @given(raw=wide_scenarios(PHYSICAL, particles=True))
    def test_many_of_the_default_models(self, raw, files):
        check_cube(raw, files)


class TestAnyOtherScenarioIsRefusedWithAMessage:
    @_settings(40)
    @given(mutated())
    def test_few(self, raw):
        check_refusal(raw)

    @pytest.mark.campaign
    @_settings(300)
    @given(mutated())
    def test_many(self, raw):
        check_refusal(raw)
