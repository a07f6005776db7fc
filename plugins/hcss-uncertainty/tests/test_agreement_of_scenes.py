"""The statistics by which propagation is compared with separate scenes, on numbers whose distribution is known."""

from dataclasses import replace

import numpy as np
import pytest
from agreement_of_scenes import Scenes, by_bootstrap, by_permutation, statistics

REPETITIONS = 16
COUNT = 60
OUTPUTS = 6
TESTS = (by_bootstrap, by_permutation)


def dependent(rng, level=0.0, spread=1.0):
    """Outputs that follow two numbers, a symmetric and a skew one; a few are missing."""
    common = np.column_stack([rng.normal(level, spread, COUNT), rng.exponential(spread, COUNT)])
    weights = np.random.default_rng(3).uniform(0.0, 1.0, (2, OUTPUTS))
    values = common @ weights + 0.1 * rng.normal(size=(COUNT, OUTPUTS))
    return np.where(rng.random((COUNT, OUTPUTS)) < 0.1, np.nan, values)


def drawn(seed, **separate):
    rng = np.random.default_rng(seed)
    scenes = np.stack([dependent(rng), dependent(rng)])
    again = [scenes[:, rng.integers(COUNT, size=COUNT)].reshape(2 * COUNT, -1) for _ in range(40)]
    error = np.std([statistics(values) for values in again], axis=0)
    return Scenes(scenes, dependent(rng, **separate), statistics(scenes.reshape(2 * COUNT, -1)), error)


@pytest.mark.parametrize("test", TESTS)
def test_probabilities_are_uniform_where_the_distributions_are_the_same(test):
    for found in np.transpose([test(drawn(number), resamples=59) for number in range(REPETITIONS)]):
        assert abs(np.mean(found) - 0.5) < 4.0 / np.sqrt(12.0 * REPETITIONS)
        assert np.mean(found < 0.1) < 0.1 + 4.0 * np.sqrt(0.09 / REPETITIONS)


def test_a_wrong_statement_is_found_though_the_draws_agree():
    scenes = drawn(5)
    wrong = replace(scenes, stated=scenes.stated + 8.0 * scenes.error)
    assert by_bootstrap(wrong, resamples=59)[0] <= 0.02


@pytest.mark.parametrize("test", TESTS)
@pytest.mark.parametrize("separate", [{"level": 1.0}, {"spread": 2.5}])
def test_another_level_or_spread_is_found(test, separate):
    assert max(test(drawn(number, **separate), resamples=59)[0] for number in (70, 71)) <= 0.05
