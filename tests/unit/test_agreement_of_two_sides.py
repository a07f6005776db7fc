"""The statistics by which propagation is compared with brute force, on numbers whose distribution is known."""

import numpy as np
import pytest
from benchmark_module import benchmark_module

REPETITIONS = 16
COUNT = 60
OUTPUTS = 6


@pytest.fixture(scope="module")
def agreement():
    module = benchmark_module("agreement")
    module.RESAMPLES = 59
    return module


def dependent(rng, count, level=0.0, spread=1.0):
    """Outputs that follow two numbers, a symmetric and a skew one; a few are missing."""
    common = np.column_stack([rng.normal(level, spread, count), rng.exponential(spread, count)])
    weights = np.random.default_rng(3).uniform(0.0, 1.0, (2, OUTPUTS))
    values = common @ weights + 0.1 * rng.normal(size=(count, OUTPUTS))
    return np.where(rng.random((count, OUTPUTS)) < 0.1, np.nan, values)


def sides(agreement, rng, **other):
    scenes = np.stack([dependent(rng, COUNT), dependent(rng, COUNT)])
    again = [scenes[:, rng.integers(COUNT, size=COUNT)].reshape(2 * COUNT, -1) for _ in range(40)]
    error = np.std([agreement.statistics(each) for each in again], axis=0)
    told = agreement.statistics(scenes.reshape(2 * COUNT, -1))
    return agreement.Sides(scenes, dependent(rng, COUNT, **other), told, error)


@pytest.fixture(scope="module")
def alike(agreement):
    made = [sides(agreement, np.random.default_rng(number)) for number in range(REPETITIONS)]
    return [(agreement.by_bootstrap([each]), agreement.by_permutation([each])) for each in made]


def test_probabilities_are_uniform_if_both_sides_are_alike(alike):
    for found in ([one.probability for one, _ in alike], *np.transpose([two for _, two in alike])):
        assert abs(np.mean(found) - 0.5) < 4.0 / np.sqrt(12.0 * REPETITIONS)
        assert np.mean(np.array(found) < 0.1) < 0.1 + 4.0 * np.sqrt(0.09 / REPETITIONS)


def test_the_part_within_one_error_scatters_as_is_said_and_more_than_if_outputs_were_independent(alike):
    parts = np.array([one.within(1.0) for one, _ in alike])
    inside = (parts[:, 1] <= parts[:, 0]) & (parts[:, 0] <= parts[:, 2])
    assert np.mean(inside) > 0.95 - 4.0 * np.sqrt(0.95 * 0.05 / REPETITIONS)
    number = alike[0][0].z.size
    assert np.std(parts[:, 0]) > 1.5 * np.sqrt(0.68 * 0.32 / number)
    assert all(1.0 < one.independent < number / 2 for one, _ in alike)


def test_what_is_told_wrong_is_found_though_the_draws_agree(agreement):
    each = sides(agreement, np.random.default_rng(5))
    apart = agreement.Sides(each.scenes, each.others, each.told + 8.0 * each.error, each.error)
    assert agreement.by_bootstrap([apart]).probability <= 0.02


@pytest.mark.parametrize("other", [{"level": 1.0}, {"spread": 2.5}])
def test_another_level_or_spread_is_found(agreement, other):
    pairs = [sides(agreement, np.random.default_rng(number), **other) for number in (70, 71)]
    assert agreement.by_bootstrap(pairs).probability <= 0.05
    assert min(agreement.by_permutation(pairs)) <= 0.02
