"""Values of a swept key: lists, ranges, distributions and ensembles against closed forms."""

from datetime import UTC, datetime, timedelta

import numpy as np
import pytest
from hcss_sweep.axis import axis_of
from scipy.stats import kstest, loguniform, truncnorm

MANY = 4000


def values(given, key="view.zenith"):
    return axis_of(key, given).values


def test_a_range_has_its_ends_and_equal_steps():
    assert values({"from": 0.1, "to": 0.9, "steps": 5}) == (0.1, 0.3, 0.5, 0.7, 0.9)
    assert values({"from": 60, "to": 0, "steps": 4}) == (60, 40, 20, 0)
    assert all(isinstance(value, int) for value in values({"from": 0, "to": 60, "steps": 4}))
    assert values({"from": 0, "to": 1, "steps": 3}) == (0, 0.5, 1)


def test_a_logarithmic_range_has_equal_ratios():
    assert values({"from": 1e-4, "to": 1e-1, "steps": 4, "scale": "log"}) == (1e-4, 1e-3, 1e-2, 1e-1)


def test_a_range_of_quantities_keeps_their_unit():
    assert values({"from": "1 km", "to": "2 km", "steps": 3}) == ("1 km", "1.5 km", "2 km")


def test_a_range_of_instants_keeps_their_zone():
    start = datetime.fromisoformat("2024-01-01T12:00:00+10:00")
    got = values({"from": start, "to": start + timedelta(days=90), "steps": 4}, "time")
    assert got == tuple(start + timedelta(days=30 * n) for n in range(4))
    assert {moment.utcoffset() for moment in got} == {timedelta(hours=10)}
    assert values({"from": start.isoformat(), "to": "2024-01-03T12:00:00+10:00", "steps": 3}, "time")[1] == (
        start + timedelta(days=1)
    )


def test_random_values_of_a_list_are_drawn_equally_often_and_depend_on_the_seed():
    drawn = values({"choice": ["stratus", "cumulus", "cirrus"], "samples": MANY, "seed": 3}, "clouds.type")
    for name in ("stratus", "cumulus", "cirrus"):
        assert drawn.count(name) / MANY == pytest.approx(1 / 3, abs=0.03)
    assert drawn == values({"choice": ["stratus", "cumulus", "cirrus"], "samples": MANY, "seed": 3}, "clouds.type")
    assert drawn != values({"choice": ["stratus", "cumulus", "cirrus"], "samples": MANY, "seed": 4}, "clouds.type")


@pytest.mark.parametrize("listed", [[], "stratus", 3])
def test_a_choice_needs_a_list(listed):
    with pytest.raises(ValueError, match=r"choice = .*; allowed: a list of at least one value"):
        values({"choice": listed, "samples": 3})


def test_an_ensemble_counts_seeds():
    assert values({"count": 3, "first": 5}, "seed") == (5, 6, 7)
    assert values({"count": 2}, "seed") == (0, 1)


@pytest.mark.parametrize(
    ("given", "law"),
    [
        ({"distribution": "uniform", "from": 2, "to": 5}, ("uniform", (2, 3))),
        ({"distribution": "log-uniform", "from": 0.01, "to": 10}, (loguniform(0.01, 10).cdf, ())),
        ({"distribution": "normal", "mean": 5, "standard_deviation": 2}, ("norm", (5, 2))),
        (
            {"distribution": "normal", "mean": 0.5, "standard_deviation": 0.5, "from": 0, "to": 1},
            (truncnorm(-1, 1, 0.5, 0.5).cdf, ()),
        ),
    ],
)
def test_drawn_values_follow_their_distribution(given, law):
    drawn = values({**given, "samples": MANY, "seed": 3})
    assert kstest(drawn, law[0], law[1]).pvalue > 0.01


def test_draws_depend_on_seed_and_key_and_nothing_else():
    given = {"distribution": "uniform", "from": 0.0, "to": 1.0, "samples": MANY}
    assert values(given) == values(given)
    assert values({**given, "seed": 1}) != values(given)
    # Two keys with the same seed do not rise and fall together.
    one, other = values(given), values(given, "clouds.coverage")
    assert abs(np.corrcoef(one, other)[0, 1]) < 4 / np.sqrt(MANY)


def test_drawn_instants_lie_between_their_ends():
    low, high = datetime(2024, 1, 1, tzinfo=UTC), datetime(2024, 12, 31, tzinfo=UTC)
    drawn = values({"distribution": "uniform", "from": low, "to": high, "samples": 50}, "time")
    assert all(low <= moment <= high for moment in drawn)
    assert len(set(drawn)) == 50


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (3.0, ["3.0", "allowed", "list"]),
        ([], ["empty"]),
        ({"from": 1, "to": 2}, ["lacks steps"]),
        ({"from": 1, "to": 2, "stepz": 3}, ["stepz", "closest is 'steps'"]),
        ({"from": 1, "to": 2, "steps": 1}, ["steps = 1", "2 to"]),
        ({"from": 1, "to": "2 km", "steps": 3}, ["2 km", "one and the same unit"]),
        ({"from": "1 m", "to": "2 km", "steps": 3}, ["one and the same unit"]),
        ({"from": -1, "to": 2, "steps": 3, "scale": "log"}, ["log", "> 0"]),
        ({"from": 1, "to": 2, "steps": 3, "scale": "logg"}, ["closest is 'log'"]),
        ({"from": datetime(2024, 1, 1), "to": datetime(2024, 2, 1), "steps": 3}, ["no zone", "+00:00"]),
        ({"distribution": "gaussian", "samples": 3}, ["gaussian", "normal"]),
        ({"distribution": "uniform", "from": 3, "to": 1, "samples": 3}, ["from < to"]),
        ({"distribution": "normal", "mean": 3, "standard_deviation": 0, "samples": 3}, ["> 0"]),
        ({"distribution": "uniform", "from": 1, "to": 3, "samples": 0}, ["samples = 0"]),
        ({"count": 0}, ["count = 0"]),
        ({"count": 3, "start": 1}, ["start", "first"]),
    ],
)
def test_wrong_values_are_told_with_what_is_allowed(given, words):
    with pytest.raises(ValueError) as caught:
        values(given)
    for word in words:
        assert word in str(caught.value)
