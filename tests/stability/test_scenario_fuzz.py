"""Any scenario gives a sound cube or a clear error; nothing else."""

import copy
from datetime import datetime, timedelta, timezone

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hcss_twin import HcssError, Scenario, make_plan, simulate
from hcss_twin.cube.variables import VARIABLES, term_variable

CLOUD_TYPES = ("cirrus", "cumulus", "simulated", "stratocumulus", "stratus")
CATALOG_BANDS = (
    "mwir-3.7",
    "mwir-4.2-4.4",
    "mwir-3.4-4.1",
    "lwir-8.5",
    "lwir-9.7",
    "lwir-10.8",
    "swir-2.7-3.0",
)
# The mask of shadows is an error without them; the groups bring it.
VARIABLE_NAMES = (*(spec.name for spec in VARIABLES if spec.name != "shadow_mask"), "terms", "truth", "all")


def _settings(examples):
    return settings(
        max_examples=examples,
        deadline=None,
        derandomize=examples < 100,
        database=None,
        suppress_health_check=list(HealthCheck),
        print_blob=False,
    )


def numbers(low, high, **options):
    return st.floats(low, high, allow_nan=False, **options)


def log_numbers(low, high):
    exponents = numbers(np.log10(low), np.log10(high))
    return st.one_of(exponents.map(lambda x: float(np.clip(10**x, low, high))), st.sampled_from([low, high]))


azimuths = numbers(0, 360, exclude_max=True)


@st.composite
def bands(draw):
    low = draw(numbers(2.5, 15.9))
    width = draw(st.sampled_from([0.001, 0.002, 0.02, 0.3]))
    return draw(st.one_of(st.sampled_from(CATALOG_BANDS), st.just([low, low + width])))


@st.composite
def layers(draw):
    base, depth = draw(numbers(0, 12_000)), draw(log_numbers(0.01, 7_000))
    low, high = sorted((draw(st.integers(0, 6)), draw(st.integers(0, 6))))
    shape = {
        "gamma": draw(numbers(1.01, 8)),
        "H": draw(numbers(0.01, 0.99)),
        "L": [draw(log_numbers(1e-3, 1e3)), draw(log_numbers(1e-3, 1e3))],
        "k": [low, high],
    }
    optional = {
        "base": base,
        "top": base + depth,
        "thickness_min": depth * draw(numbers(1e-3, 1)),
        "anchor": draw(st.sampled_from(["base", "top"])),
        "temperature": draw(numbers(150, 350)),
        "parameters": draw(
            st.sampled_from([shape, {"gamma": shape["gamma"]}, {"H": shape["H"]}, {"k": shape["k"]}])
        ),
    }
    kept = draw(st.sets(st.sampled_from(list(optional))))
    return {
        "type": draw(st.sampled_from(CLOUD_TYPES)),
        "coverage": draw(st.one_of(numbers(0, 1), st.sampled_from([0.0, 1.0, 1e-9]))),
        **{key: optional[key] for key in kept},
    }


@st.composite
def pairs(draw):
    """Two layers, one above the other, in either order; they may touch."""
    low, high = draw(layers()), draw(layers())
    base, depth = draw(numbers(0, 6_000)), draw(log_numbers(0.01, 3_000))
    gap, height = draw(st.one_of(st.just(0.0), numbers(0, 3_000))), draw(log_numbers(0.01, 7_000))
    above = base + depth + gap
    for layer, bottom, top in ((low, base, base + depth), (high, above, above + height)):
        layer |= {"base": bottom, "top": top, "thickness_min": (top - bottom) * draw(numbers(1e-3, 1))}
    return {"layers": draw(st.permutations([low, high]))}


@st.composite
def radiances(draw, models):
    """A radiance model and some of its parameters."""
    model = draw(st.sampled_from(models))
    if model == "as-printed":
        parameters = {
            "glint_scale": draw(numbers(0, 10)),
            "cloud_sun_scale": draw(numbers(0, 10)),
            **{f"literal_eq{n}": draw(st.booleans()) for n in (14, 18, 19, 20)},
        }
    else:
        # Few streams: what is held against limits here is not their accuracy.
        sun_streams = draw(st.integers(2, 6))
        parameters = {
            "streams": draw(st.integers(2, 6)),
            "closure_order": draw(st.integers(0, 1)),
            "sun_streams": sun_streams,
            "azimuth_modes": draw(st.integers(1, 2 * sun_streams)),
            "cloud_temperature": draw(st.sampled_from(["profile", "isothermal-top"])),
        }
    return {"model": model, "parameters": parameters}


@st.composite
def sections(draw, models):
    """Every section of a valid scenario, over the whole allowed space, but of few pixels."""
    zone = timezone(timedelta(minutes=draw(st.integers(-14 * 60, 14 * 60))))
    # Now and then any year, and a series as long as the keys allow.
    extreme = draw(st.integers(0, 19)) == 7
    years = (1, 9999) if extreme else (1900, 2100)
    time = draw(st.datetimes(datetime(years[0], 1, 1), datetime(years[1], 12, 31))).replace(tzinfo=zone)
    return {
        "seed": draw(st.one_of(st.integers(0, 100), st.integers(0, 2**63 - 1))),
        "accuracy": draw(log_numbers(1e-4, 0.1)),
        "time": time,
        "place": {
            "latitude": draw(st.one_of(numbers(-90, 90), st.sampled_from([-90.0, 90.0]))),
            "longitude": draw(st.one_of(numbers(-180, 360), st.sampled_from([-180.0, 360.0]))),
        },
        "view": {
            "zenith": draw(st.one_of(numbers(0, 85), st.sampled_from([0.0, 85.0]))),
            "azimuth": draw(azimuths),
        },
        "image": {
            "rows": draw(st.integers(1, 8)),
            "columns": draw(st.integers(1, 8)),
            "pixel_size": draw(log_numbers(0.01, 1e5)),
            "samples_per_pixel": draw(st.sampled_from([1, 1, 2, 3, 64])),
        },
        "frames": {
            "count": draw(st.integers(1, 2)),
            "interval": draw(log_numbers(1e-3, 1e6 if extreme else 100)),
            "first": draw(st.one_of(st.integers(0, 10), st.integers(0, 10_000_000))),
        },
        "motion": {
            "platform_speed": draw(st.one_of(numbers(-1e5, 1e5), st.just(7500.0))),
            "wind_speed": draw(numbers(0, 150)),
            "wind_from": draw(azimuths),
            "evolution_time": draw(st.one_of(st.just("frozen"), log_numbers(1e-3, 1e12))),
        },
        "bands": draw(st.lists(bands(), min_size=1, max_size=2, unique_by=str)),
        "clouds": draw(st.one_of(layers(), layers(), pairs(), st.just({}))),
        "slant": {"shadows": draw(st.booleans()), "parallax": draw(st.booleans())},
        "sea": {
            "model": draw(st.sampled_from(["cox-munk", "rough-sea"])),
            "temperature": draw(numbers(260, 330)),
            "wind_speed": draw(st.one_of(numbers(0, 60), st.sampled_from([0.0, 60.0]))),
            "wind_from": draw(azimuths),
        },
        "optics": {"provider": draw(st.sampled_from(["mie", "bulk"]))},
        "radiance": draw(radiances(models)),
        "output": {
            "variables": draw(st.lists(st.sampled_from(VARIABLE_NAMES), min_size=1, max_size=4)),
            "compression": draw(st.sampled_from([0, 0, 0, 1, 9])),
        },
    }


PAPER = ("as-printed",)
"""The model that takes least."""
PHYSICAL = ("physical", "physical-two-stream")


@st.composite
def scenarios(draw, models=PAPER):
    """A valid scenario that leaves out any of the sections that may be left out."""
    whole = draw(sections(models))
    needed = ("time", "place", "image", "frames", "bands", "radiance")
    left_out = draw(st.sets(st.sampled_from([key for key in whole if key not in needed]), max_size=3))
    return {key: value for key, value in whole.items() if key not in left_out}


def _paths(value, path=()):
    if path:
        yield path
    entries = (
        value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    )
    for key, each in entries:
        yield from _paths(each, (*path, key))


scalars = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.integers(10**300, 10**400),
    st.floats(),
    st.text(max_size=12),
    st.sampled_from(
        ["1 km", "20 degC", "130%", "frozen", "5 kg", "nan", "1e999 m", "~x/y", "..", "/", "a" * 300]
    ),
    st.dates(),
    st.datetimes(),
    st.binary(max_size=3),
)
anything = st.recursive(
    scalars,
    lambda inner: st.one_of(
        st.lists(inner, max_size=3), st.dictionaries(st.text(max_size=6), inner, max_size=3)
    ),
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


def refusal_of(work):
    """Result and error on purpose of ``work``; any other error passes."""
    try:
        return work(), None
    except HcssError as error:
        return None, error


def check_cube(raw):
    """Simulate, and hold every variable against its limits in the table of variables."""
    made, error = refusal_of(lambda: _plan_and_cube(raw))
    if made is None:
        assert str(error).strip()
        return
    plan, cube = made
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


def _plan_and_cube(raw):
    scenario = Scenario.from_dict(raw)
    return make_plan(scenario), simulate(scenario)


def check_refusal(raw):
    """Validate and plan; only errors on purpose may come out, each with a field and a message."""
    _, error = refusal_of(lambda: make_plan(Scenario.from_dict(raw)))
    for problem in getattr(error, "problems", ()):
        assert problem.field
        assert 0 < len(problem.message) < 2000
        # The wording of the validation library is for programmers.
        assert "Input should" not in problem.message or "unicode" in problem.message


class TestAnyAllowedScenarioGivesASoundCubeOrAClearError:
    @_settings(12)
    @given(scenarios())
    def test_few(self, raw):
        check_cube(raw)

    @pytest.mark.long
    @_settings(150)
    @given(scenarios())
    def test_many(self, raw):
        check_cube(raw)

    @_settings(6)
    @given(scenarios(PHYSICAL))
    def test_few_of_the_default_models(self, raw):
        check_cube(raw)

    @pytest.mark.long
    @_settings(25)
    @given(scenarios(PHYSICAL))
    def test_more_of_the_default_models(self, raw):
        check_cube(raw)


class TestAnyOtherScenarioIsRefusedWithAMessage:
    @_settings(60)
    @given(mutated())
    def test_few(self, raw):
        check_refusal(raw)

    @pytest.mark.long
    @_settings(3000)
    @given(mutated())
    def test_many(self, raw):
        check_refusal(raw)


def test_the_drawn_scenarios_are_mostly_valid():
    """Otherwise the test of cubes would test refusals only."""
    valid = []

    @_settings(60)
    @given(scenarios((*PAPER, *PHYSICAL)))
    def draw(raw):
        valid.append(refusal_of(lambda: Scenario.from_dict(raw))[1] is None)

    draw()
    assert np.mean(valid) > 0.7
