"""The sweep through a population samples its density: against quadrature, and against the priors alone."""

import numpy as np
import pytest
from hcss_evaluate.posterior.chains import begin, extend
from hcss_evaluate.posterior.parameter_space import Space
from hcss_evaluate.posterior.population import PopulationModel
from hcss_evaluate.posterior.priors import Prior
from scipy.special import ndtr
from scipy.stats import kstest

LOW, HIGH = 0.02, 0.98
USUAL = {"H": f"uniform:{LOW}:{HIGH}"}
FIXED = {"gamma": 2.0, "Lx": 5.0, "Ly": 5.0, "coverage": 0.4}


def population(likelihoods, widest=0.5, least=0.01):
    spread = Prior.parse("spread_H", f"uniform:{least}:{widest}", 0.0, np.inf)
    return PopulationModel(Space.of(FIXED, {}, USUAL), tuple(likelihoods), (spread,))


def normal(centre, width):
    return lambda values: -0.5 * ((values[:, 0] - centre) / width) ** 2


BURN_IN = 40
"""Steps; autocorrelation times are 3 to 8."""


def sampled(model, steps, seed=3):
    """Positions after a burn-in, (steps, walkers, 2 + images).

    Many walkers and few steps: a step of 400 walkers takes little longer than one of 40.
    """
    rng, walkers, images = np.random.default_rng(seed), 400, len(model.likelihoods)
    alone = [rng.uniform(0.3, 0.6, (walkers, 1)) for _ in range(images)]
    chains = begin(model.log_probability, model.start(rng, alone), seed)
    return extend(model, chains, BURN_IN + steps).positions[BURN_IN:]


def quadrature(centres, widths, widest, least):
    """Mean and deviation of mean, spread and the parameter of each image, on a grid: the images' are integrated out."""
    mean, spread = np.linspace(LOW, HIGH, 123)[1:-1], np.linspace(least, widest, 99)
    parameter = np.linspace(LOW, HIGH, 641)
    m, s = mean[:, None, None], spread[None, :, None]
    given = np.exp(-0.5 * ((parameter - m) / s) ** 2) / s / (ndtr((HIGH - m) / s) - ndtr((LOW - m) / s))
    density, first, second = np.ones((mean.size, spread.size)), [], []
    for centre, width in zip(centres, widths, strict=True):
        product = given * np.exp(-0.5 * ((parameter - centre) / width) ** 2)
        whole = product.sum(axis=-1)
        density *= whole
        # Where a population has no place for an image its density is 0, whatever its mean is taken for.
        safe = np.maximum(whole, 1e-300)
        first.append((product * parameter).sum(axis=-1) / safe)
        second.append((product * parameter**2).sum(axis=-1) / safe)
    density /= density.sum()
    ones = [np.broadcast_to(mean[:, None], density.shape), np.broadcast_to(spread, density.shape), *first]
    squares = [ones[0] ** 2, ones[1] ** 2, *second]
    centre = np.array([(density * weights).sum() for weights in ones])
    return centre, np.sqrt(np.array([(density * square).sum() for square in squares]) - centre**2)


@pytest.mark.parametrize(
    ("centres", "widths"),
    [
        ([0.35, 0.42, 0.55], [0.03, 0.05, 0.04]),  # well known, apart
        ([0.40, 0.41, 0.42, 0.40], [0.10, 0.10, 0.12, 0.08]),  # a funnel: alike for all that is known
        ([0.05, 0.93], [0.05, 0.02]),  # at the limits
    ],
)
def test_means_spreads_and_images_are_those_of_quadrature(centres, widths):
    model = population([normal(*moments) for moments in zip(centres, widths, strict=True)])
    found = sampled(model, 80).reshape(-1, 2 + len(centres))
    found[:, 1] = np.exp(found[:, 1])
    centre, deviation = quadrature(centres, widths, 0.5, 0.01)
    # At least 4000 independent samples: more than 4 standard errors.
    assert np.all(np.abs(found.mean(axis=0) - centre) < 0.07 * deviation)
    np.testing.assert_allclose(found.std(axis=0), deviation, rtol=0.06)


def test_images_that_tell_nothing_leave_the_priors():
    model = population([lambda values: np.zeros(values.shape[0])] * 3)
    found = sampled(model, 90)[::30].reshape(-1, 5)
    assert kstest(found[:, 0], "uniform", (LOW, HIGH - LOW)).pvalue > 0.001
    assert kstest(np.exp(found[:, 1]), "uniform", (0.01, 0.49)).pvalue > 0.001


def test_the_density_that_a_sweep_keeps_is_that_of_the_model():
    model = population([normal(0.4, 0.05), normal(0.5, 0.02)])
    rng = np.random.default_rng(0)
    chains = begin(model.log_probability, model.start(rng, [rng.uniform(0.3, 0.6, (40, 1))] * 2), 0)
    after = extend(model, chains, 20)
    np.testing.assert_allclose(after.log_probability[-1], model.log_probability(after.positions[-1]), rtol=1e-12)
    assert np.all(np.isfinite(after.log_probability))


def test_means_and_spreads_keep_to_their_limits():
    model = population([normal(0.03, 0.2)], widest=0.3, least=0.1)
    found = sampled(model, 120).reshape(-1, 3)
    assert found[:, [0, 2]].min() > LOW
    assert found[:, [0, 2]].max() < HIGH
    assert np.exp(found[:, 1]).min() > 0.1
    assert np.exp(found[:, 1]).max() < 0.3
