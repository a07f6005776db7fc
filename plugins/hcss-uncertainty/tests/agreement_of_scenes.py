"""Whether propagation and scenes made one by one agree: tests that keep all outputs of a draw together.

Moments and quantiles of many outputs (bands, classes, radiance and brightness temperature) follow a few numbers: how
warm the drawn seas and how cloudy the drawn scenes happen to be. One such number that is off by chance moves them all,
so that differences say little one by one. Both functions return the chance of a mean square of all differences, and
of a largest one, as large as they are: :func:`by_bootstrap` resamples the draws of each side and takes the stated
errors as they are; :func:`by_permutation` exchanges draws between the sides, which is exact and needs no errors.
"""

from dataclasses import dataclass

import numpy as np

QUANTILES = (0.05, 0.5, 0.95)
RESAMPLES = 999


@dataclass(frozen=True)
class Scenes:
    """One comparison.

    Attributes
    ----------
    propagated : ndarray (2, draw, output)
        Of propagation, each draw with two seeds; NaN where a scene has no pixels of the class.
    separate : ndarray (draw, output)
        Of scenes made one by one.
    stated, error : ndarray (statistic, output)
        What propagation states, and its standard error.
    """

    propagated: np.ndarray
    separate: np.ndarray
    stated: np.ndarray
    error: np.ndarray


def statistics(values):
    """Mean, standard deviation and quantiles of values (scene, output) that are numbers, (statistic, output)."""
    moments = np.nanmean(values, axis=0), np.nanstd(values, axis=0, ddof=1)
    return np.stack([*moments, *np.nanquantile(values, QUANTILES, axis=0)])


def by_bootstrap(scenes, seed=1, resamples=RESAMPLES):
    """Return the chances of what is stated, against separate scenes."""
    rng = np.random.default_rng(seed)

    def drawn_again(values):
        draws = values.shape[-2]
        resampled = (values[..., rng.integers(draws, size=draws), :] for _ in range(resamples))
        return np.stack([statistics(draw.reshape(-1, values.shape[-1])) for draw in resampled])

    propagated, separate = drawn_again(scenes.propagated), drawn_again(scenes.separate)
    found = scenes.stated - statistics(scenes.separate)
    by_chance = propagated - separate - (statistics(_flat(scenes.propagated)) - statistics(scenes.separate))
    return _probabilities(found, by_chance, np.sqrt(scenes.error**2 + separate.var(axis=0, ddof=1)))


def by_permutation(scenes, seed=2, resamples=RESAMPLES):
    """Return the chances of separate scenes, against one scene of each propagated draw."""
    rng = np.random.default_rng(seed)
    draws = np.concatenate([scenes.propagated[0], scenes.separate])
    count = scenes.propagated.shape[1]

    def difference(order):
        return statistics(draws[order[:count]]) - statistics(draws[order[count:]])

    by_chance = np.stack([difference(rng.permutation(draws.shape[0])) for _ in range(resamples)])
    return _probabilities(difference(np.arange(draws.shape[0])), by_chance, by_chance.std(axis=0))


def _probabilities(found, by_chance, scale):
    found, by_chance = np.abs(found / scale), np.abs(by_chance / scale)
    rises = (np.mean(by_chance**2, axis=(1, 2)) >= np.mean(found**2), by_chance.max(axis=(1, 2)) >= found.max())
    return tuple((1 + int(rise.sum())) / (1 + rise.size) for rise in rises)


def _flat(values):
    return values.reshape(-1, values.shape[-1])
