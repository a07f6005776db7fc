"""Effective sample sizes and R-hat: equal to ArviZ's, and to closed forms."""

from dataclasses import astuple

import numpy as np
import pytest
from hcss_evaluate.posterior.mixing import Mixing, mixing


def autoregressive(coefficient, chains, draws, seed=0):
    noise = np.random.default_rng(seed).standard_normal((chains, draws))
    noise[:, 0] /= np.sqrt(1 - coefficient**2)
    for draw in range(1, draws):
        noise[:, draw] += coefficient * noise[:, draw - 1]
    return noise


CASES = {
    "independent": autoregressive(0.0, 32, 60),
    "thinned": autoregressive(0.14, 32, 51),
    "slow": autoregressive(0.9, 4, 1000),
    "antithetic": autoregressive(-0.6, 40, 70),
    "skewed": np.exp(3.0 * autoregressive(0.3, 8, 300)),
    "repeated": np.round(autoregressive(0.3, 32, 80), 1),
    "apart": autoregressive(0.3, 8, 300) + np.arange(8)[:, None] % 2,
    "of different widths": autoregressive(0.3, 8, 300) * (1 + np.arange(8)[:, None] % 2),
    "drifting": autoregressive(0.3, 8, 300) + np.linspace(0, 1, 300),
}


ARVIZ = {
    "independent": (2091.1874, 2063.8544, 1.0040844),
    "thinned": (1347.7555, 1591.6329, 1.0025154),
    "slow": (184.94249, 330.05317, 1.0266328),
    "antithetic": (9652.0425, 2781.0223, 1.0073669),
    "skewed": (1304.612, 2033.4093, 1.0041944),
    "repeated": (1498.8572, 2253.3579, 1.0090232),
    "apart": (51.558559, 859.66415, 1.1121262),
    "of different widths": (1345.7189, 337.408, 1.0676313),
    "drifting": (234.59888, 1837.2374, 1.0310475),
}
"""ess(method="bulk"), ess(method="tail") and rhat(method="rank") of ArviZ 0.23.4, whose import takes 5 s of CPU time:
with arviz==0.23.4 installed, ``python plugins/hcss-evaluate/tests/test_fit_mixing.py`` prints them."""


@pytest.mark.parametrize("name", CASES)
def test_sizes_and_r_hat_are_those_of_arviz(name):
    np.testing.assert_allclose(astuple(mixing(CASES[name])), ARVIZ[name], rtol=1e-6)


@pytest.mark.parametrize("coefficient", [-0.3, 0.0, 0.6])
def test_the_bulk_size_is_that_of_an_autoregressive_process(coefficient):
    draws = autoregressive(coefficient, 16, 5000, seed=1)
    found = mixing(draws).bulk_effective_sample_size
    assert found == pytest.approx(draws.size * (1 - coefficient) / (1 + coefficient), rel=0.05)


def test_independent_draws_count_whole_in_bulk_and_tails_and_have_r_hat_one():
    found = mixing(autoregressive(0.0, 16, 5000, seed=2))
    np.testing.assert_allclose(astuple(found), (80_000, 80_000, 1.0), rtol=0.03)
    assert found.rank_normalized_split_r_hat == pytest.approx(1.0, abs=5e-4)


def test_all_three_are_those_of_ranks():
    draws = autoregressive(0.5, 8, 200)
    np.testing.assert_allclose(astuple(mixing(np.exp(draws)))[:2], astuple(mixing(draws))[:2], rtol=1e-12)


def test_halves_that_differ_have_the_r_hat_of_their_normal_scores():
    # Two halves without a common value: scores are the halves of a normal distribution, of means -+ sqrt(2 / pi) and
    # variance 1 - 2 / pi; their mean square is 1. 16 halves of chains: 16 / 15.
    draws = autoregressive(0.0, 8, 4000)
    draws[:, 2000:] += 100.0
    expected = np.sqrt(1 + 16 / 15 * (2 / np.pi) / (1 - 2 / np.pi))
    assert mixing(draws).rank_normalized_split_r_hat == pytest.approx(expected, rel=2e-3)


def test_one_chain_of_another_width_is_seen():
    draws = autoregressive(0.0, 8, 500)
    draws[3] *= 0.3
    assert mixing(draws).rank_normalized_split_r_hat > 1.02


def test_of_several_images_the_worst_counts():
    one, other = autoregressive(0.0, 8, 200), autoregressive(0.8, 8, 200)
    assert mixing(np.stack([one, other], axis=-1)) == mixing(other)


@pytest.mark.parametrize("draws", [np.ones((4, 50)), np.arange(12.0).reshape(4, 3)])
def test_draws_that_are_too_few_or_do_not_vary_have_no_diagnostics(draws):
    np.testing.assert_equal(astuple(mixing(draws)), astuple(Mixing(np.nan, np.nan, np.nan)))


if __name__ == "__main__":
    import arviz

    for name, draws in CASES.items():
        sizes = [float(arviz.ess(draws, method=method)) for method in ("bulk", "tail")]
        print(f'    "{name}": ({sizes[0]:.8g}, {sizes[1]:.8g}, {float(arviz.rhat(draws, method="rank")):.8g}),')
