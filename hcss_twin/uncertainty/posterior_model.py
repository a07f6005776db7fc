"""Posterior densities: of one image or one dimension, and of the population that several images are from."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.special import log_ndtr

from hcss_twin.uncertainty.priors import Prior
from hcss_twin.uncertainty.scales import KINDS
from hcss_twin.uncertainty.space import Space

Array = NDArray[np.float64]

Likelihood = Callable[[Array], Array]
"""From H, gamma, Lx, Ly, coverage (N, 5) to ln of the likelihood (N,)."""

# Of the first guess of a population's spread, on the scale; and its scatter among walkers.
_LEAST_SPREAD, _SCATTER = 0.05, 0.2


class Model(Protocol):
    """What chains need to know."""

    @property
    def names(self) -> tuple[str, ...]:
        """Name of each dimension."""
        ...

    def log_probability(self, position: Array) -> Array:
        """Return ln of the posterior density (N,) of positions (N, D)."""
        ...

    def values(self, position: Array) -> dict[str, Array]:
        """Return the parameters (...) or (..., image) at positions (..., D)."""
        ...


@dataclass(frozen=True)
class SingleModel:
    """Parameters of one image."""

    space: Space
    likelihood: Likelihood

    @property
    def names(self) -> tuple[str, ...]:
        """Free parameters."""
        return self.space.names

    def log_probability(self, position: Array) -> Array:
        """Return ln of the posterior density (N,) of positions (N, D)."""
        prior = self.space.log_prior(position)
        return _where_finite(prior, position, self.space, self.likelihood)

    def values(self, position: Array) -> dict[str, Array]:
        """Return the free parameters (...) at positions (..., D)."""
        return {name: KINDS[name].scale.back(position[..., i]) for i, name in enumerate(self.names)}


@dataclass(frozen=True)
class PopulationModel:
    """Parameters of several images, and the distribution from which they are.

    On its scale each parameter of an image is normally distributed, cut off at the limits of its prior,
    which is that of the mean. A position has the means, the logarithms of the spreads, and then the
    parameters of each image.
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
        count = len(self.space.names)
        mean, log_spread = position[:, :count], position[:, count : 2 * count]
        spread = np.exp(log_spread)
        total = self.space.log_prior(mean)
        for column, prior in enumerate(self.spreads):
            total = total + prior.log_density(spread[:, column]) + log_spread[:, column]
        low, high = self.space.limits
        with np.errstate(divide="ignore", invalid="ignore"):
            inside = _log_between((low - mean) / spread, (high - mean) / spread)
            for image in range(len(self.likelihoods)):
                own = self._own(position, image)
                density = -0.5 * ((own - mean) / spread) ** 2 - log_spread - inside
                density = np.where((own > low) & (own < high), density, -np.inf)
                total = total + np.sum(density, axis=1)
        total = np.where(np.isnan(total), -np.inf, total)
        for image, likelihood in enumerate(self.likelihoods):
            total = _where_finite(total, self._own(position, image), self.space, likelihood)
        return total

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

    def _own(self, position: Array, image: int) -> Array:
        count = len(self.space.names)
        first = (2 + image) * count
        return position[:, first : first + count]


def _where_finite(so_far: Array, position: Array, space: Space, likelihood: Likelihood) -> Array:
    """Add the likelihood where the density is not 0 already."""
    possible = np.isfinite(so_far)
    total = np.full(so_far.shape, -np.inf)
    if possible.any():
        added = so_far[possible] + likelihood(space.complete(position[possible]))
        total[possible] = np.where(np.isnan(added), -np.inf, added)
    return total


def _log_between(low: Array, high: Array) -> Array:
    """Return ln of the normal probability between two numbers, low < high."""
    # On the side where both tails are small the difference is taken, so that nothing cancels.
    flip = low > 0.0
    a, b = np.where(flip, -high, low), np.where(flip, -low, high)
    upper, lower = log_ndtr(b), log_ndtr(a)
    return np.asarray(upper + np.log1p(-np.exp(lower - upper)))
