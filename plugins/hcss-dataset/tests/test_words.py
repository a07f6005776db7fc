"""What keys are drawn from: words of sweeps, distributions of scipy.stats, choices, sections."""

import numpy as np
import pytest
from hcss_dataset.words import drawn
from scipy import stats


def many(given, count=1000):
    random = np.random.default_rng(5)
    return [drawn("key", given, random) for _ in range(count)]


@pytest.mark.parametrize(
    ("given", "law"),
    [
        ({"distribution": "uniform", "from": 2.0, "to": 5.0}, stats.uniform(2.0, 3.0)),
        ({"distribution": "log-uniform", "from": 1.0, "to": 100.0}, stats.loguniform(1.0, 100.0)),
        ({"distribution": "normal", "mean": 3.0, "standard_deviation": 2.0}, stats.norm(3.0, 2.0)),
        ({"distribution": "gamma", "a": 2.0, "scale": 3.0}, stats.gamma(2.0, scale=3.0)),
        ({"distribution": "norm", "loc": 0.0, "scale": 1.0, "from": -1.0, "to": 0.5}, stats.truncnorm(-1.0, 0.5)),
    ],
    ids=["uniform", "log-uniform", "normal", "scipy", "truncated"],
)
def test_numbers_have_the_distribution(given, law):
    assert stats.kstest(many(given), law.cdf).pvalue > 0.01


def test_whole_numbers_stay_whole_and_in_their_range():
    found = many({"distribution": "poisson", "mu": 2.0, "from": 1, "to": 3})
    assert set(found) == {1, 2, 3}
    assert all(isinstance(each, int) for each in found)
    shares = stats.poisson(2.0).pmf([1, 2, 3])
    counts = [found.count(each) for each in (1, 2, 3)]
    assert stats.chisquare(counts, shares / shares.sum() * len(found)).pvalue > 0.01


def test_choices_have_their_weights_and_lists_equal_ones():
    found = many({"choice": ["a", "b", "c"], "weights": [1, 0, 3]})
    assert found.count("b") == 0
    assert stats.binomtest(found.count("a"), len(found), 0.25).pvalue > 0.01
    assert stats.binomtest(many([1, 2]).count(1), 1000, 0.5).pvalue > 0.01


def test_a_chosen_section_may_hold_further_draws():
    coverage = {"distribution": "uniform", "from": 0.2, "to": 0.4}
    found = many({"choice": [{"type": "stratus", "coverage": coverage}, {"type": "cumulus"}]}, 40)
    assert {each["type"] for each in found} == {"stratus", "cumulus"}
    assert all(0.2 <= each["coverage"] <= 0.4 for each in found if each["type"] == "stratus")
    assert len({each["coverage"] for each in found if "coverage" in each}) > 10


def test_units_stay_with_numbers():
    assert many({"distribution": "uniform", "from": "1 km", "to": "2 km"}, 1)[0].endswith(" km")
    assert many({"distribution": "expon", "unit": "km"}, 1)[0].endswith(" km")


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"distribution": "poison", "mu": 1.0}, "closest is 'poisson'"),
        ({"distribution": "poisson"}, "parameters of scipy.stats.poisson: 'mu' is missing"),
        ({"distribution": "poisson", "mean": 3.0}, "'mean' is unknown; allowed: mu, loc, from"),
        ({"distribution": "poisson", "mu": -1.0}, "mu = -1.0: scipy.stats.poisson has no"),
        ({"distribution": "norm", "from": 2.0, "to": 1.0}, "no probability"),
        ({"distribution": "uniform", "from": 2.0}, "lacks to"),
        ({"choice": []}, "at least one value"),
        ({"choice": [1, 2], "weights": [0, 0]}, "not all of them 0"),
        ({"choice": [1, 2], "weight": [1, 1]}, "unknown 'weight'"),
    ],
)
def test_what_cannot_be_drawn_is_refused_by_name(given, words):
    with pytest.raises(ValueError, match=words):
        drawn("key", given, np.random.default_rng(0))
