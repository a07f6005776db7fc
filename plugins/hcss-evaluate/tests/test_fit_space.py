"""Priors of a fit on the scales of its chains, and which parameters are free."""

import math

import numpy as np
import pytest
from hcss_evaluate.errors import PosteriorError
from hcss_evaluate.posterior.fit_run import FitOptions
from hcss_evaluate.posterior.parameter_space import Space
from hcss_evaluate.posterior.population import log_normal_between
from scipy import stats

USUAL = {
    "H": "uniform:0.02:0.98",
    "gamma": "loguniform:1.5:4",
    "Lx": "loguniform:1:64",
    "Ly": "lognormal:8:0.5",
    "coverage": "normal:0.4:0.3",
}


def test_density_on_scales_is_that_of_the_draws():
    """The histogram of draws, on its scale, is the exponential of the density: Jacobians are right."""
    space = Space.of({}, {}, USUAL)
    drawn = space.draw(np.random.default_rng(0), 20_000)
    for column, name in enumerate(space.names):
        edges = np.quantile(drawn[:, column], np.linspace(0.02, 0.98, 25))
        middle = 0.5 * (edges[1:] + edges[:-1])
        position = np.tile(np.median(drawn, axis=0), (middle.size, 1))
        position[:, column] = middle
        density = np.exp(space.log_prior(position)) * np.diff(edges)
        counted = np.histogram(drawn[:, column], edges)[0]
        np.testing.assert_allclose(density / density.sum(), counted / counted.sum(), rtol=0.1, err_msg=name)


def test_a_cloud_type_sets_what_is_not_given():
    usual = FitOptions(cloud_type="cirrus").of_type()
    assert (usual.octaves, usual.fixed) == ((0, 4), {"gamma": 3.0})
    assert usual.priors == {"Lx": "lognormal:50:0.5", "Ly": "lognormal:10:0.5"}
    given = FitOptions(cloud_type="cirrus", octaves=(0, 6), priors={"gamma": "normal:2:1"}, fixed={"Lx": 7.0}).of_type()
    assert (given.octaves, given.fixed) == ((0, 6), {"Lx": 7.0})
    assert given.priors == {"gamma": "normal:2:1", "Ly": "lognormal:10:0.5"}
    with pytest.raises(PosteriorError, match=r"cirus.*closest is 'cirrus'"):
        FitOptions(cloud_type="cirus").of_type()


def test_positions_go_to_values_and_back():
    space = Space.of({"gamma": 2.0}, {}, USUAL)
    position = space.draw(np.random.default_rng(0), 50)
    values = space.complete(position)
    assert np.all(values[:, 1] == 2.0)
    np.testing.assert_allclose(space.position(values), position, rtol=1e-9)


def test_outside_the_limits_the_density_is_nothing():
    space = Space.of({}, {}, USUAL)
    position = space.draw(np.random.default_rng(0), 1)
    assert np.isfinite(space.log_prior(position))[0]
    for column, outside in enumerate((1.2, math.log(9.0), math.log(65.0))):
        moved = position.copy()
        moved[0, column] = outside
        assert space.log_prior(moved)[0] == -np.inf


@pytest.mark.parametrize(
    ("fixed", "priors", "message"),
    [
        ({"h": 0.5}, {}, "closest is 'H'"),
        ({}, {"L": "uniform:1:2"}, "allowed: H, Lx, Ly, coverage, gamma"),
        ({"H": 0.5}, {"H": "uniform:0:1"}, "fixed and given a prior"),
        ({"H": 1.5}, {}, "between 0 and 1"),
        ({"H": 0.5, "gamma": 2, "Lx": 3, "Ly": 3, "coverage": 0.5}, {}, "all are fixed"),
    ],
)
def test_what_is_free_and_what_is_fixed_is_checked(fixed, priors, message):
    with pytest.raises(PosteriorError, match=message):
        Space.of(fixed, priors, USUAL)


def test_the_normal_probability_between_two_numbers_keeps_its_digits_in_the_tails():
    low = np.array([-1.0, 5.0, -9.0, -np.inf, 10.0])
    high = np.array([2.0, 6.0, -8.0, 1.0, np.inf])
    # Survival functions and distribution functions, each where it is small.
    expected = np.log(
        np.where(low > 0, stats.norm.sf(low) - stats.norm.sf(high), stats.norm.cdf(high) - stats.norm.cdf(low))
    )
    np.testing.assert_allclose(log_normal_between(low, high), expected, rtol=1e-9)
