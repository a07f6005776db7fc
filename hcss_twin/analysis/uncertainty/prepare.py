"""From an image to a likelihood that knows the scatter of its statistics where the posterior lies."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from hcss_twin.analysis.uncertainty.chains import begin, extend, walkers_of
from hcss_twin.analysis.uncertainty.image_likelihood import ImageLikelihood
from hcss_twin.analysis.uncertainty.posterior_model import SingleModel
from hcss_twin.analysis.uncertainty.space import SHAPE, Space
from hcss_twin.core.arrays import Array

SIMULATIONS = (150, 150, 700)
"""Over the prior, near the posterior that these give, and near the one that those give."""

# Steps of a pilot chain, and its burn-in.
_PILOT, _SETTLED = 400, 200

# Positions of the prior among which the pilot's start is chosen, per walker; and how many of them stay.
_CANDIDATES, _CHOSEN = 64, 4

# Powers of the likelihood in pilots, less than 1 because what is learned over the prior is rough; and how much wider
# than such a pilot's draws simulations are spread.
_POWERS, _WIDER = (0.25, 0.7), 1.3

# Of the way to a limit, at least.
_INSIDE = 1e-4


def prepare(
    likelihood: ImageLikelihood, space: Space, seed: np.random.SeedSequence, told: Callable[[int], None]
) -> tuple[ImageLikelihood, Array]:
    """Learn the scatter, first over the prior and then, twice, where the posterior lies.

    The final likelihood is 0 outside the positions of the last simulations, which reach beyond four standard
    deviations of the posterior: nothing is extrapolated.

    Parameters
    ----------
    likelihood : ImageLikelihood
        Without noise.
    space : Space
        Free parameters.
    seed : SeedSequence
        Of all that is random.
    told : callable
        Is told of simulations that are done, the sum of ``SIMULATIONS`` in all.

    Returns
    -------
    likelihood : ImageLikelihood
        With noise.
    start : ndarray (N, free)
        Positions where walkers may start: the likelier half of draws of the pilot's posterior.

    Raises
    ------
    PosteriorError
        If simulated images do not vary.
    """
    rng = np.random.default_rng(seed)
    broad, *near = SIMULATIONS
    likelihood = likelihood.learn(_shapes(space, space.draw(rng, broad)), rng, told)
    candidates = space.draw(rng, _CANDIDATES * walkers_of(len(space.names)))
    for count, power in zip(near, _POWERS, strict=True):
        pilot = candidates = _pilot(_flattened(space, likelihood, power), candidates, rng)
        centre = pilot.mean(axis=0)
        low, high = _limits(space, pilot)
        drawn = pilot[rng.permutation(pilot.shape[0])[:count]]
        drawn = np.clip(centre + _WIDER * (drawn - centre), low, high)
        likelihood = likelihood.learn(_shapes(space, drawn), rng, told)
    density = SingleModel(space, likelihood).log_probability(pilot)
    return likelihood, pilot[np.argsort(-density, kind="stable")[: pilot.shape[0] // 2]]


def _flattened(space: Space, likelihood: ImageLikelihood, power: float) -> SingleModel:
    return SingleModel(space, lambda values: power * likelihood(values))


def _pilot(model: SingleModel, candidates: Array, rng: np.random.Generator) -> Array:
    """Sample the posterior of a provisional likelihood, from the likeliest of candidates."""
    walkers = walkers_of(len(model.names))
    # Candidates may be steps of a chain that stayed: walkers at one point would never leave it.
    candidates = np.unique(candidates, axis=0)
    density = model.log_probability(candidates)
    best = candidates[np.argsort(-density, kind="stable")[: _CHOSEN * walkers]]
    start = best[rng.permutation(best.shape[0])[:walkers]]
    chains = begin(model.log_probability, start, int(rng.integers(0, 2**31)))
    chains = extend(model, chains, _PILOT)
    return np.asarray(chains.positions[_SETTLED:].reshape(-1, len(model.names)))


def _shapes(space: Space, position: Array) -> Array:
    return np.asarray(space.complete(position)[:, : len(SHAPE)])


def _limits(space: Space, pilot: Array) -> tuple[Array, Array]:
    """Return how far simulations may go: to the limits of priors, but not onto them."""
    low, high = space.limits
    width = np.where(np.isfinite(high - low), high - low, np.ptp(pilot, axis=0))
    return low + _INSIDE * width, high - _INSIDE * width
