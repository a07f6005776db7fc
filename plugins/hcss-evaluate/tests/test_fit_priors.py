"""Priors of a fit: how they are written, and that each is the distribution that it is called."""

import numpy as np
import pytest
from hcss_evaluate.errors import PosteriorError
from hcss_evaluate.posterior.priors import KINDS, Prior
from scipy import stats

USUAL = {
    "H": "uniform:0.02:0.98",
    "gamma": "loguniform:1.5:4",
    "Lx": "loguniform:1:64",
    "Ly": "lognormal:8:0.5",
    "coverage": "normal:0.4:0.3",
}
# The same distributions as scipy has them.
ORACLES = {
    "H": stats.uniform(0.02, 0.96),
    "gamma": stats.loguniform(1.5, 4),
    "Lx": stats.loguniform(1, 64),
    "Ly": stats.lognorm(0.5, scale=8),
    "coverage": stats.truncnorm(-0.4 / 0.3, 0.6 / 0.3, 0.4, 0.3),
}


@pytest.mark.parametrize("name", USUAL)
def test_a_prior_is_the_distribution_that_it_is_called(name):
    prior = Prior.parse(name, USUAL[name], KINDS[name].low, KINDS[name].high)
    part = np.linspace(0.01, 0.99, 25)
    values = ORACLES[name].ppf(part)
    np.testing.assert_allclose(prior.quantile(part), values, rtol=1e-9)
    difference = prior.log_density(values) - ORACLES[name].logpdf(values)
    np.testing.assert_allclose(difference, difference[0], atol=1e-9)
    np.testing.assert_allclose(prior.density(values), ORACLES[name].pdf(values), rtol=1e-9)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("unifrom:0:1", "closest is 'uniform'"),
        ("uniform:0", "uniform:low:high, two numbers"),
        ("uniform:a:b", "two numbers"),
        ("uniform:0.5:0.2", "low < high"),
        ("uniform:0:nan", "finite"),
        ("uniform:-1:2", "closest is uniform:0:1"),
        ("loguniform:0:1", "greater than 0"),
        ("normal:0.5:0", "standard deviation greater than 0"),
        ("normal:3:1", "a centre between 0 and 1"),
    ],
)
def test_a_prior_that_is_none_is_refused(text, message):
    with pytest.raises(PosteriorError, match=f"prior of H: .*{message}"):
        Prior.parse("H", text, 0.0, 1.0)
