"""Hierarchical posterior of several images: the population and the parameters of each image, and its sampler.

Given the population, the images are independent, so the parameters of each image are proposed and accepted separately;
given the images, the mean and spread of each parameter are updated separately, without the likelihood. A general
sampler moves all dimensions at once, so nearly every proposal would be rejected.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from emcee.moves import Move
from emcee.state import State
from numpy.typing import NDArray
from scipy.special import log_ndtr

from hcss_evaluate.posterior.chains import Likelihood
from hcss_evaluate.posterior.parameter_space import Space
from hcss_evaluate.posterior.priors import KINDS, Prior
from hcss_twin.providers import Array

# Initial spread of a population on the scale, and its scatter among walkers.
_MIN_SPREAD, _SCATTER = 0.05, 0.2


@dataclass(frozen=True)
class PopulationModel:
    """Posterior of the parameters of several images and of their population.

    On its scale each parameter of an image is normally distributed, truncated at the limits of its prior, which is also
    the prior of the mean. A position holds the means, the logarithms of the spreads, and the parameters of each image.
    The density factorises over images and parameters except for the likelihoods, each of which depends on all
    parameters of one image.
    """

    space: Space
    likelihoods: tuple[Likelihood, ...]
    spreads: tuple[Prior, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """Means, spreads, and the parameters of each image."""
        free = self.space.names
        of_images = (f"{name}[{image}]" for image in range(len(self.likelihoods)) for name in free)
        return (*(f"mean_{name}" for name in free), *(f"spread_{name}" for name in free), *of_images)

    def log_probability(self, position: Array) -> Array:
        """Return the log posterior density (N,) of positions (N, D)."""
        mean, log_spread, of_images = self.parts(position)
        given = self.log_given(of_images, mean, log_spread).sum(axis=1)
        total: Array = np.sum(self.log_hyperprior(mean, log_spread) + given, axis=1)
        for image in range(len(self.likelihoods)):
            total = total + self.log_likelihood(image, of_images[:, image], np.isfinite(total))
        return total

    def parts(self, position: Array) -> tuple[Array, Array, Array]:
        """Split positions (N, D) into means and logarithms of spreads (N, P) and the images' parameters (N, I, P)."""
        count = len(self.space.names)
        split = position.reshape(position.shape[0], -1, count)
        return split[:, 0], split[:, 1], split[:, 2:]

    def log_hyperprior(self, mean: Array, log_spread: Array) -> Array:
        """Return the log prior density of each mean and logarithm of a spread (N, P); -inf outside the limits."""
        spread = np.exp(log_spread)
        total = self.space.log_priors(mean) + log_spread
        for column, prior in enumerate(self.spreads):
            total[:, column] += prior.log_density(spread[:, column])
        return np.where(np.isnan(total), -np.inf, total)

    def log_given(self, of_images: Array, mean: Array, log_spread: Array) -> Array:
        """Return the log density of the images' parameters (N, I, P) in a population; -inf outside the limits."""
        low, high = self.space.limits
        spread = np.exp(log_spread)
        with np.errstate(divide="ignore", invalid="ignore"):
            inside = log_normal_between((low - mean) / spread, (high - mean) / spread)
            whole = log_spread + inside
            density = -0.5 * ((of_images - mean[:, None]) / spread[:, None]) ** 2 - whole[:, None]
        possible = (of_images > low) & (of_images < high) & ~np.isnan(density)
        return np.where(possible, density, -np.inf)

    def log_likelihood(self, image: int, parameters: Array, wanted: NDArray[np.bool_]) -> Array:
        """Return an image's log-likelihood (N,) at its parameters (N, P) where requested, else -inf."""
        total = np.full(parameters.shape[0], -np.inf)
        if wanted.any():
            computed = self.likelihoods[image](self.space.complete(parameters[wanted]))
            total[wanted] = np.where(np.isnan(computed), -np.inf, computed)
        return total

    def moves(self) -> list[tuple[Any, float]]:
        """Return the move that sweeps over images and population."""
        return [(PopulationSweep(self), 1.0)]

    def values(self, position: Array) -> dict[str, Array]:
        """Return means and spreads (...) and the parameters of images (..., image) at positions (..., D)."""
        values: dict[str, Array] = {}
        count = len(self.space.names)
        for column, name in enumerate(self.space.names):
            scale = KINDS[name].scale
            values[f"mean_{name}"] = scale.back(position[..., column])
            values[f"spread_{name}"] = np.exp(position[..., count + column])
            values[name] = scale.back(position[..., 2 * count + column :: count])
        return values

    def start(self, rng: np.random.Generator, of_images: Sequence[Array]) -> Array:
        """Return the start positions of walkers (N, D), from positions (N, free) of each image fitted alone."""
        alone = np.stack(of_images, axis=1)
        low, high = (np.array(ends) for ends in zip(*((p.low, p.high) for p in self.spreads), strict=True))
        spread = np.maximum(alone.std(axis=1), _MIN_SPREAD)
        spread = spread * np.exp(_SCATTER * rng.standard_normal(spread.shape))
        # Start well inside the limits, where the density is not 0.
        spread = np.clip(spread, low + 0.01 * (high - low), high - 0.01 * (high - low))
        return np.concatenate([alone.mean(axis=1), np.log(spread), alone.reshape(alone.shape[0], -1)], axis=1)


def log_normal_between(low: Array, high: Array) -> Array:
    """Return the logarithm of the normal probability between two numbers: it normalizes truncated densities.

    Parameters
    ----------
    low, high : ndarray (...)
        Ends in standard deviations from the mean, ``low`` below ``high``; infinite ones are allowed.

    Returns
    -------
    ndarray (...)
        ln(Phi(high) - Phi(low)), to all digits in either tail.
    """
    # The difference is computed in the tail where both probabilities are small, to avoid cancellation.
    flip = low > 0.0
    a, b = np.where(flip, -high, low), np.where(flip, -low, high)
    upper, lower = log_ndtr(b), log_ndtr(a)
    return np.asarray(upper + np.log1p(-np.exp(lower - upper)))


_BEST = 2.38
"""Most efficient step size along one dimension, in standard deviations of a normal density."""

_OF_IMAGES, _OF_POPULATION = 2, 3
"""Steps per sweep: for each image, and for means and spreads."""


class PopulationSweep(Move):  # type: ignore[misc]
    """An emcee move that updates all dimensions, each block with a separate Metropolis step."""

    def __init__(self, model: PopulationModel) -> None:
        self._model = model
        self._likelihood: Array | None = None

    def propose(self, model: Any, state: State) -> tuple[State, NDArray[np.bool_]]:
        """Move each half of the walkers with step sizes from the other half."""
        random = model.random
        whole = _WalkerSet.of(self._model, state.coords, self._likelihood)
        walkers = state.coords.shape[0]
        shuffled = random.permutation(walkers)
        for members in (shuffled[: walkers // 2], shuffled[walkers // 2 :]):
            half, others = whole.take(members), np.delete(whole.of_images, members, axis=0)
            for _ in range(_OF_IMAGES):
                for image in range(others.shape[1]):
                    half.move_image(image, others[:, image], random)
            half.move_population(random)
            half.move_together(others, random)
            whole.put(members, half)
        self._likelihood = whole.likelihood
        coords = whole.position()
        moved = np.any(coords != state.coords, axis=1)
        return State(coords, log_prob=whole.log_probability(), random_state=random.get_state()), moved


class _WalkerSet:
    """Walkers (N): means and logarithms of spreads (N, P), parameters (N, I, P) and likelihoods (N, I) of images."""

    def __init__(
        self, model: PopulationModel, mean: Array, log_spread: Array, of_images: Array, likelihood: Array
    ) -> None:
        self._model = model
        self.mean, self.log_spread, self.of_images, self.likelihood = mean, log_spread, of_images, likelihood

    @classmethod
    def of(cls, model: PopulationModel, position: Array, likelihood: Array | None) -> _WalkerSet:
        mean, log_spread, of_images = (part.copy() for part in model.parts(position))
        if likelihood is None:
            everywhere = np.ones(position.shape[0], dtype=np.bool_)
            likelihoods = [
                model.log_likelihood(image, of_images[:, image], everywhere) for image in range(of_images.shape[1])
            ]
            likelihood = np.stack(likelihoods, axis=1)
        return cls(model, mean, log_spread, of_images, likelihood)

    def take(self, walkers: NDArray[np.intp]) -> _WalkerSet:
        return _WalkerSet(
            self._model, self.mean[walkers], self.log_spread[walkers], self.of_images[walkers], self.likelihood[walkers]
        )

    def put(self, walkers: NDArray[np.intp], half: _WalkerSet) -> None:
        self.mean[walkers], self.log_spread[walkers] = half.mean, half.log_spread
        self.of_images[walkers], self.likelihood[walkers] = half.of_images, half.likelihood

    def position(self) -> Array:
        return np.concatenate([self.mean, self.log_spread, self.of_images.reshape(self.of_images.shape[0], -1)], axis=1)

    def log_probability(self) -> Array:
        given = self._model.log_given(self.of_images, self.mean, self.log_spread).sum(axis=1)
        prior = self._model.log_hyperprior(self.mean, self.log_spread)
        return np.asarray(np.sum(prior + given, axis=1) + self.likelihood.sum(axis=1))

    def move_image(self, image: int, others: Array, random: Any) -> None:
        """Move one image's parameters by differences of other walkers (M, P), or by steps scaled to the population."""
        walkers, count = self.mean.shape
        if random.rand() < 0.5:
            first = random.randint(others.shape[0], size=walkers)
            second = (first + 1 + random.randint(others.shape[0] - 1, size=walkers)) % others.shape[0]
            size = 1.0 if random.rand() < 0.1 else _BEST / np.sqrt(2.0 * count)
            step = size * (others[first] - others[second])
        else:
            within = 1.0 / np.sqrt(np.exp(-2.0 * self.log_spread) + 1.0 / others.var(axis=0))
            step = _BEST / np.sqrt(count) * within * random.standard_normal((walkers, count))
        proposed = self.of_images[:, image] + step
        gain = self._given(proposed[:, None]) - self._given(self.of_images[:, image, None])
        likelihood = self._model.log_likelihood(image, proposed, np.isfinite(gain.sum(axis=(1, 2))))
        taken = _taken(gain.sum(axis=(1, 2)) + likelihood - self.likelihood[:, image], random)
        self.of_images[taken, image] = proposed[taken]
        self.likelihood[taken, image] = likelihood[taken]

    def move_population(self, random: Any) -> None:
        """Move each mean and each spread separately, with steps scaled to the number and scatter of the images."""
        images = self.of_images.shape[1]
        density = self._hyper(self.mean, self.log_spread)
        for _ in range(_OF_POPULATION):
            width = _BEST / np.sqrt(images) * np.exp(self.log_spread)
            mean = self.mean + width * random.standard_normal(self.mean.shape)
            density = self._take_population(mean, self.log_spread, density, random)
            width = _BEST / np.sqrt(2.0 * images)
            log_spread = self.log_spread + width * random.standard_normal(self.mean.shape)
            density = self._take_population(self.mean, log_spread, density, random)

    def _take_population(self, mean: Array, log_spread: Array, density: Array, random: Any) -> Array:
        """Accept or reject each mean and spread, and return the resulting log densities (N, P)."""
        proposed = self._hyper(mean, log_spread)
        taken = _taken(proposed - density, random)
        self.mean = np.where(taken, mean, self.mean)
        self.log_spread = np.where(taken, log_spread, self.log_spread)
        return np.where(taken, proposed, density)

    def move_together(self, others: Array, random: Any) -> None:
        """Move one parameter of all images with its mean, or stretch it about its mean with its spread.

        The posterior of a narrow population is a funnel, in which separate moves are small.
        """
        walkers, count = self.mean.shape
        images = self.of_images.shape[1]
        which = random.randint(count)
        mean, log_spread, of_images = self.mean.copy(), self.log_spread.copy(), self.of_images.copy()
        if random.rand() < 0.5:
            size = _BEST / np.sqrt(np.sum(1.0 / others[..., which].var(axis=0)))
            step = size * random.standard_normal(walkers)
            mean[:, which] += step
            of_images[..., which] += step[:, None]
            volume = 0.0
        else:
            # Steps of all sizes, because the length of the funnel is unknown.
            step = 10.0 ** random.uniform(-1.5, 0.0) * random.standard_normal(walkers)
            log_spread[:, which] += step
            center = mean[:, which, None]
            of_images[..., which] = center + (of_images[..., which] - center) * np.exp(step)[:, None]
            volume = images * step
        model = self._model
        before = np.sum(self._hyper(self.mean, self.log_spread), axis=1)
        after = np.sum(
            model.log_hyperprior(mean, log_spread) + model.log_given(of_images, mean, log_spread).sum(axis=1), axis=1
        )
        possible = np.isfinite(after)
        likelihood = np.stack([model.log_likelihood(i, of_images[:, i], possible) for i in range(images)], axis=1)
        gain = after - before + volume + likelihood.sum(axis=1) - self.likelihood.sum(axis=1)
        taken = _taken(gain, random)
        self.mean[taken], self.log_spread[taken] = mean[taken], log_spread[taken]
        self.of_images[taken], self.likelihood[taken] = of_images[taken], likelihood[taken]

    def _given(self, of_images: Array) -> Array:
        return self._model.log_given(of_images, self.mean, self.log_spread)

    def _hyper(self, mean: Array, log_spread: Array) -> Array:
        """Return the log density of each mean and spread (N, P), given the images' parameters."""
        given = self._model.log_given(self.of_images, mean, log_spread).sum(axis=1)
        return np.asarray(self._model.log_hyperprior(mean, log_spread) + given)


def _taken(gain: Array, random: Any) -> NDArray[np.bool_]:
    """Return the accepted proposals; those with zero density (-inf, or NaN from two of them) are rejected."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.log(random.random_sample(gain.shape)) < gain)
