"""Whether two sets of scenes, made in different ways, scatter alike: tests that keep all outputs of a draw together.

Moments and quantiles of many outputs (bands, classes, radiance and brightness temperature) follow a few numbers: how
warm the drawn seas and how cloudy the drawn scenes happen to be. One such number that is off by chance moves them all:
how many lie within one standard error says nothing without how far that number itself scatters.

:func:`by_bootstrap` resamples the draws of each side, which gives the scatter of whatever is said of all differences
together; it takes the errors that are told as they are. :func:`by_permutation` exchanges draws between the sides, which
is exact if they have the same distribution, and needs no errors.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

QUANTILES = (0.05, 0.5, 0.95)
STATISTICS = ("mean", "sd", *(f"{100 * share:g} %" for share in QUANTILES))
RESAMPLES = 999


@dataclass(frozen=True)
class Sides:
    """One comparison.

    Attributes
    ----------
    scenes : ndarray (2, draw, output)
        Of the one side, each draw with two seeds; NaN where a scene has no pixels of the class.
    others : ndarray (draw, output)
        Of the other.
    told, error : ndarray (statistic, output)
        What the one side says of itself, and its standard error.
    """

    scenes: Array
    others: Array
    told: Array
    error: Array


@dataclass(frozen=True)
class Verdict:
    """How far the sides are apart.

    Attributes
    ----------
    z : ndarray (statistic, output)
        Differences in standard errors.
    chance : ndarray (resample, statistic, output)
        What these would be by chance, all of a row at once.
    """

    z: Array
    chance: Array

    @property
    def probability(self) -> float:
        """Chance of a mean square of all differences as large as it is."""
        return _probability(np.mean(self.z**2), np.mean(self.chance**2, axis=(1, 2)))

    @property
    def independent(self) -> float:
        """Number of independent differences whose mean square would scatter as much: tr(C)^2 / tr(C^2)."""
        covariance = np.cov(self.chance.reshape(self.chance.shape[0], -1), rowvar=False)
        return float(np.trace(covariance) ** 2 / np.sum(covariance**2))

    def within(self, limit: float) -> tuple[float, float, float]:
        """Return the part of the differences below a limit, and the range of it in 95 % of repetitions by chance."""
        parts = np.mean(np.abs(self.chance) < limit, axis=(1, 2))
        low, high = np.quantile(parts, (0.025, 0.975))
        return float(np.mean(np.abs(self.z) < limit)), float(low), float(high)

    @property
    def largest(self) -> tuple[float, float]:
        """Largest difference, and that which 95 % of repetitions stay below by chance."""
        high = np.quantile(np.abs(self.chance).max(axis=(1, 2)), 0.95)
        return float(np.abs(self.z).max()), float(high)


def statistics(values: Array) -> Array:
    """Mean, standard deviation and quantiles of values (scene, output) that are numbers, (statistic, output)."""
    moments = np.nanmean(values, axis=0), np.nanstd(values, axis=0, ddof=1)
    return np.stack([*moments, *np.nanquantile(values, QUANTILES, axis=0)])


def by_bootstrap(pairs: list[Sides], seed: int = 1) -> Verdict:
    """Compare what is told with the other side, whose errors are bootstrapped; of several pairs their mean."""
    rng = np.random.default_rng(seed)
    difference, variance, chance = [], [], []
    for each in pairs:
        other = statistics(each.others)
        own = statistics(_flat(each.scenes))
        own_again = np.stack(
            [statistics(_flat(each.scenes[:, _again(rng, each.scenes.shape[1])])) for _ in range(RESAMPLES)]
        )
        other_again = np.stack([statistics(each.others[_again(rng, each.others.shape[0])]) for _ in range(RESAMPLES)])
        difference.append(each.told - other)
        variance.append(each.error**2 + other_again.var(axis=0, ddof=1))
        chance.append((own_again - own) - (other_again - other))
    scale = np.sqrt(np.sum(variance, axis=0))
    return Verdict(np.sum(difference, axis=0) / scale, np.sum(chance, axis=0) / scale)


def by_permutation(pairs: list[Sides], seed: int = 2) -> tuple[float, float]:
    """Chance of a mean square of all differences, and of a largest one, as large as they are.

    Of one scene of each draw of both sides; differences are measured by their own scatter over permutations.
    """
    rng = np.random.default_rng(seed)
    own = np.concatenate([each.scenes[0] for each in pairs])
    every = np.concatenate([own, *(each.others for each in pairs)])

    def difference(order: NDArray[np.intp]) -> Array:
        return statistics(every[order[: own.shape[0]]]) - statistics(every[order[own.shape[0] :]])

    by_chance = np.stack([difference(rng.permutation(every.shape[0])) for _ in range(RESAMPLES)])
    scale = by_chance.std(axis=0)
    found, by_chance = np.abs(difference(np.arange(every.shape[0])) / scale), np.abs(by_chance / scale)
    return (
        _probability(np.mean(found**2), np.mean(by_chance**2, axis=(1, 2))),
        _probability(found.max(), by_chance.max(axis=(1, 2))),
    )


def _probability(found: float, by_chance: Array) -> float:
    return float((1 + np.sum(by_chance >= found)) / (1 + by_chance.size))


def _flat(scenes: Array) -> Array:
    return scenes.reshape(-1, scenes.shape[2])


def _again(rng: np.random.Generator, count: int) -> NDArray[np.intp]:
    return rng.integers(count, size=count)
