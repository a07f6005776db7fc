"""Moments, shares of the variance and their errors, against known functions and scipy."""

import numpy as np
import pytest
from hcss_uncertainty import estimators
from hcss_uncertainty.estimators import bootstrap_error, terms_of
from hcss_uncertainty.joint_sample import bootstrap_seed
from scipy import stats

ADDITIVE = np.array([2.0, 1.0, 0.5])
SHARES = ADDITIVE**2 / np.sum(ADDITIVE**2)


def additive(count, seed=0, noise=0):
    """y = 2 a + b + c / 2 with c the seed; mixtures: draws, other seed, all others, other a, other b."""
    rng = np.random.default_rng((seed, noise))
    one, two = rng.standard_normal((2, count, 3))
    mixtures = [one.copy() for _ in range(5)]
    mixtures[1][:, 2] = two[:, 2]
    mixtures[2] = two
    mixtures[3][:, 0] = two[:, 0]
    mixtures[4][:, 1] = two[:, 1]
    return one[:, :2], np.stack([mixture @ ADDITIVE for mixture in mixtures])[..., None] + 100.0


def within(found, expected, error, sigmas=4.0):
    return abs(float(found) - expected) < sigmas * float(error)


def test_pick_freeze_finds_the_shares_of_an_additive_function():
    _, y = additive(2000)
    for name, mixture in (("a", 3), ("b", 4), ("seed", 1)):
        expected = SHARES["ab".find(name) if name != "seed" else 2]
        for estimate in (
            lambda rows, mixture=mixture: estimators.first_by_pick_freeze(y[:, rows], 2, mixture),
            lambda rows, mixture=mixture: estimators.total_by_pick_freeze(y[:, rows], 2, mixture),
        ):
            error = bootstrap_error(estimate, 2000, bootstrap_seed(1))
            assert 0.0 < error[0] < 0.06
            assert within(estimate(np.arange(2000))[0], expected, error[0])


def test_regression_finds_the_shares_of_an_additive_function_from_draws_alone():
    x, y = additive(400)
    for column in (0, 1):
        terms = terms_of(x[:, [column]], 400)

        def estimate(rows, terms=terms):
            return estimators.first_by_regression(terms[rows], y[:2, rows])

        error = bootstrap_error(estimate, 400, bootstrap_seed(1))
        assert within(estimate(np.arange(400))[0], SHARES[column], error[0])
    assert within(estimators.total_by_seed(y)[0], SHARES[2], 0.01)
    np.testing.assert_allclose(estimators.first_by_rest(y) + estimators.total_by_seed(y), 1.0)


@pytest.mark.parametrize("terms", [1, 3, 6])
def test_a_share_by_regression_is_the_adjusted_coefficient_of_determination(terms):
    """R^2 = 1 - (1 - R^2) (n - 1) / (n - p - 1), with R^2 by least squares with a constant; no effect of seeds."""
    rng = np.random.default_rng(terms)
    count = 15
    x = rng.standard_normal((count, terms))
    target = x[:, 0] + rng.standard_normal(count)
    design = np.column_stack([np.ones(count), x])
    residual = target - design @ np.linalg.lstsq(design, target, rcond=None)[0]
    plain = 1.0 - np.sum(residual**2) / np.sum((target - target.mean()) ** 2)
    adjusted = 1.0 - (1.0 - plain) * (count - 1) / (count - terms - 1)
    found = estimators.first_by_regression(x, np.stack([target, target])[..., None])
    assert found[0] == pytest.approx(adjusted, rel=1e-9)
    assert abs(adjusted - plain) > 0.02


def test_inputs_together_have_the_sum_of_their_shares_where_they_add():
    x, y = additive(400)
    together = estimators.first_by_regression(terms_of(x, 400), y)[0]
    assert together == pytest.approx(SHARES[:2].sum(), abs=0.02)


def test_an_input_that_does_nothing_has_no_share_on_average():
    rng = np.random.default_rng(5)
    found = [
        estimators.first_by_regression(terms_of(rng.standard_normal((50, 1)), 50), rng.standard_normal((2, 50, 1)))
        for _ in range(400)
    ]
    assert abs(np.mean(found)) < 4.0 * np.std(found) / 20.0
    assert np.min(found) < 0.0  # and is not cut off at nothing, which would bias it


def test_pick_freeze_agrees_with_scipy_on_a_function_with_interactions():
    """Ishigami's function; the same function values for both."""
    count = 2**12
    rng = np.random.default_rng(3)
    one, two = rng.uniform(-np.pi, np.pi, (2, count, 3))

    def ishigami(x):
        return np.sin(x[:, 0]) + 7.0 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])

    mixed = []
    for column in range(3):
        exchanged = one.copy()
        exchanged[:, column] = two[:, column]
        mixed.append(ishigami(exchanged))
    values = {"f_A": ishigami(one)[None], "f_B": ishigami(two)[None], "f_AB": np.stack(mixed)[:, None]}
    expected = stats.sobol_indices(func=values, n=count)
    y = np.stack([ishigami(one), mixed[2], ishigami(two), *mixed])[..., None]
    for column in range(3):
        first = estimators.first_by_pick_freeze(y, 2, 3 + column)[0]
        total = estimators.total_by_pick_freeze(y, 2, 3 + column)[0]
        assert first == pytest.approx(expected.first_order[column], abs=0.03)
        assert total == pytest.approx(expected.total_order[column], abs=0.03)


def test_the_variance_is_that_of_one_draw_with_one_seed():
    """Twins that share all inputs but the seed, of which the pooled variance would be wrong by 1 / (2 n)."""
    found = [estimators.variance(additive(5, noise=number)[1])[0] for number in range(1, 2001)]
    truth = np.sum(ADDITIVE**2)
    assert abs(np.mean(found) - truth) < 4.0 * np.std(found) / np.sqrt(2000.0)
    assert np.std(found) / np.sqrt(2000.0) < 0.02 * truth


def present_by_chance(count, seed):
    """y = a, uniform between 0 and 1, in scenes that have it with probability a: their density of y is 2 y."""
    rng = np.random.default_rng((7, seed))
    a = rng.random(count)
    return np.where(rng.random((2, count)) < a, a, np.nan)[..., None]


@pytest.mark.parametrize(
    ("name", "truth"), [("mean", 2.0 / 3.0), ("standard_deviation", np.sqrt(1.0 / 18.0)), ("median", np.sqrt(0.5))]
)
def test_what_only_some_scenes_have_has_the_moments_of_these_scenes(name, truth):
    """Draws that have it with both seeds would have the density 3 y^2: mean .75, deviation .19, median .79."""
    y = present_by_chance(4000, 0)
    estimate = {"median": lambda y: estimators.quantiles(y, [0.5])[0]}.get(name) or getattr(estimators, name)
    error = bootstrap_error(lambda rows: estimate(y[:, rows]), 4000, bootstrap_seed(1))
    assert 0.0 < error[0] < 0.01
    assert within(estimate(y)[0], truth, error[0])


def test_errors_of_what_only_some_scenes_have_are_the_scatter_over_repeated_experiments():
    found, errors = [], []
    for number in range(1, 61):
        y = present_by_chance(80, number)
        y = y[:, np.isfinite(y).any(axis=(0, 2))]
        found.append([estimators.mean(y)[0], estimators.standard_deviation(y)[0]])
        errors.append(
            bootstrap_error(
                lambda rows, y=y: np.stack(
                    [estimators.mean(y[:, rows])[0], estimators.standard_deviation(y[:, rows])[0]]
                ),
                y.shape[1],
                bootstrap_seed(number),
            )
        )
    np.testing.assert_allclose(np.mean(errors, axis=0), np.std(found, axis=0), rtol=0.25)


@pytest.mark.parametrize("name", ["mean", "standard_deviation", "median", "share"])
def test_bootstrap_errors_are_the_scatter_over_repeated_experiments(name):
    def estimate(x, y, rows):
        match name:
            case "median":
                return estimators.quantiles(y[:, rows], [0.5])[0]
            case "share":
                return estimators.first_by_regression(terms_of(x[:, :1], 80)[rows], y[:2, rows])
            case _:
                return getattr(estimators, name)(y[:, rows])

    found, errors = [], []
    for number in range(1, 25):
        x, y = additive(80, noise=number)
        found.append(estimate(x, y, np.arange(80))[0])
        errors.append(bootstrap_error(lambda rows, x=x, y=y: estimate(x, y, rows), 80, bootstrap_seed(number))[0])
    assert np.mean(errors) == pytest.approx(np.std(found), rel=0.35)


def test_an_output_that_does_not_vary_has_no_shares():
    y = np.full((2, 30, 1), 3.0)
    assert np.isnan(estimators.total_by_seed(y))
    x = np.random.default_rng(0).standard_normal((30, 1))
    assert np.isnan(estimators.first_by_regression(terms_of(x, 30), y))


def test_an_input_that_does_not_vary_explains_nothing():
    _, y = additive(60)
    assert estimators.first_by_regression(terms_of(np.ones((60, 1)), 60), y)[0] == 0.0


@pytest.mark.parametrize(("draws", "terms"), [(11, None), (12, 1), (39, 1), (40, 3)])
def test_few_draws_are_not_regressed_on_many_terms(draws, terms):
    found = terms_of(np.random.default_rng(0).standard_normal((draws, 1)), draws)
    assert (None if found is None else found.shape[1]) == terms
