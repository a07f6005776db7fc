"""Posterior density of the population that several images are from, and of the parameters of each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import log_ndtr

from hcss_twin.uncertainty.posterior_model import Likelihood
from hcss_twin.uncertainty.priors import Prior
from hcss_twin.uncertainty.scales import KINDS
from hcss_twin.uncertainty.space import Space

Array = NDArray[np.float64]

# Of the first guess of a population's spread, on the scale; and its scatter among walkers.
_LEAST_SPREAD, _SCATTER = 0.05, 0.2


@dataclass(frozen=True)
class PopulationModel:
    """Parameters of several images, and the distribution from which they are.

    On its scale each parameter of an image is normally distributed, cut off at the limits of its prior,
    which is that of the mean. A position has the means, the logarithms of the spreads, and then the
    parameters of each image. Between images and between parameters the density is a product but for the
    likelihoods, which have the parameters of one image each.
    """

    space: Space
    likelihoods: tuple[Likelihood, ...]
    spreads: tuple[Prior, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """Means, spreads, and the parameters of each image."""
        free = self.space.names
        each = (f"{name}[{image}]" for image in range(len(self.likelihoods)) for name in free)
        return (*(f"mean_{name}" for name in free), *(f"spread_{name}" for name in free), *each)

    def log_probability(self, position: Array) -> Array:
        """Return ln of the posterior density (N,) of positions (N, D)."""
        mean, log_spread, own = self.parts(position)
        given = self.log_given(own, mean, log_spread).sum(axis=1)
        total: Array = np.sum(self.log_hyperprior(mean, log_spread) + given, axis=1)
        for image in range(len(self.likelihoods)):
            total = total + self.log_likelihood(image, own[:, image], np.isfinite(total))
        return total

    def parts(self, position: Array) -> tuple[Array, Array, Array]:
        """Return means and logarithms of spreads (N, P), and the images' parameters (N, I, P), of positions (N, D)."""
        count = len(self.space.names)
        split = position.reshape(position.shape[0], -1, count)
        return split[:, 0], split[:, 1], split[:, 2:]

    def log_hyperprior(self, mean: Array, log_spread: Array) -> Array:
        """Return ln of the prior density of each mean and logarithm of a spread (N, P); -inf beyond limits."""
        spread = np.exp(log_spread)
        total = self.space.log_priors(mean) + log_spread
        for column, prior in enumerate(self.spreads):
            total[:, column] += prior.log_density(spread[:, column])
        return np.where(np.isnan(total), -np.inf, total)

    def log_given(self, own: Array, mean: Array, log_spread: Array) -> Array:
        """Return ln of the density of images' parameters (N, I, P) in a population; -inf beyond limits."""
        low, high = self.space.limits
        spread = np.exp(log_spread)
        with np.errstate(divide="ignore", invalid="ignore"):
            inside = _log_between((low - mean) / spread, (high - mean) / spread)
            whole = log_spread + inside
            density = -0.5 * ((own - mean[:, None]) / spread[:, None]) ** 2 - whole[:, None]
        possible = (own > low) & (own < high) & ~np.isnan(density)
        return np.where(possible, density, -np.inf)

    def log_likelihood(self, image: int, own: Array, wanted: NDArray[np.bool_]) -> Array:
        """Return ln of an image's likelihood (N,) of its parameters (N, P) where it is wanted, else -inf."""
        found = np.full(own.shape[0], -np.inf)
        if wanted.any():
            computed = self.likelihoods[image](self.space.complete(own[wanted]))
            found[wanted] = np.where(np.isnan(computed), -np.inf, computed)
        return found

    def moves(self) -> list[tuple[Any, float]]:
        """Return the sweep over images and population."""
        from hcss_twin.uncertainty.population_sweep import PopulationSweep

        return [(PopulationSweep(self), 1.0)]

    def values(self, position: Array) -> dict[str, Array]:
        """Return means and spreads (...) and the parameters of images (..., image) at positions (..., D)."""
        found: dict[str, Array] = {}
        count = len(self.space.names)
        for column, name in enumerate(self.space.names):
            scale = KINDS[name].scale
            found[f"mean_{name}"] = scale.back(position[..., column])
            found[f"spread_{name}"] = np.exp(position[..., count + column])
            found[name] = scale.back(position[..., 2 * count + column :: count])
        return found

    def start(self, rng: np.random.Generator, each: Sequence[Array]) -> Array:
        """Return where walkers start (N, D): at positions (N, free) of each image, fitted alone."""
        alone = np.stack(each, axis=1)
        low, high = (np.array(ends) for ends in zip(*((p.low, p.high) for p in self.spreads), strict=True))
        spread = np.maximum(alone.std(axis=1), _LEAST_SPREAD)
        spread = spread * np.exp(_SCATTER * rng.standard_normal(spread.shape))
        # Well inside the limits, where the density is not 0.
        spread = np.clip(spread, low + 0.01 * (high - low), high - 0.01 * (high - low))
        return np.concatenate([alone.mean(axis=1), np.log(spread), alone.reshape(alone.shape[0], -1)], axis=1)


def _log_between(low: Array, high: Array) -> Array:
    """Return ln of the normal probability between two numbers, low < high."""
    # On the side where both tails are small the difference is taken, so that nothing cancels.
    flip = low > 0.0
    a, b = np.where(flip, -high, low), np.where(flip, -low, high)
    upper, lower = log_ndtr(b), log_ndtr(a)
    return np.asarray(upper + np.log1p(-np.exp(lower - upper)))
