"""Estimates from draws: moments, quantiles, and which input matters; each a function of draws alone.

y has the axes (mixture, draw, output); mixture 0 are the draws and mixture 1 the same with other seeds. Moments and
quantiles are those of a scene that has the outputs: y may be NaN where a scene has not (a class without pixels), in the
same scenes for all outputs. To ask this of both scenes of a draw would prefer inputs that often have the outputs.
Shares need draws that have them in all mixtures.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array

RESAMPLES = 200
"""Bootstrap samples of the draws, from which all standard errors come."""

CUBIC_FROM, LINEAR_FROM = 40, 12
"""Draws from which on regressions are cubic, and from which on there are any."""

SAME = 1e-7
"""Spread, relative to the mean, below which an output does not vary: that of single precision."""


def scenes(y: Array) -> Array:
    """Scenes of both seeds that have the outputs, (scene, output)."""
    values = y[:2].reshape(-1, y.shape[2])
    return np.asarray(values[np.isfinite(values).all(axis=1)])


def mean(y: Array) -> Array:
    """Mean over the scenes of both seeds, (output,)."""
    return np.asarray(scenes(y).mean(axis=0))


def variance(y: Array) -> Array:
    """Variance of one draw with one seed, (output,); unbiased where all scenes have the outputs.

    Half of the mean squared difference between scenes of different draws (W. Hoeffding, Annals of Mathematical
    Statistics 19 (1948) 293-325, for the kernel of the variance): scenes of the same draw share its inputs.
    """
    own = scenes(y)
    off = own - own.mean(axis=0)
    apart = y[0] - y[1]
    twice = apart[np.isfinite(apart).all(axis=1)]  # draws that have the outputs with both seeds
    count = own.shape[0]
    squares = count * np.sum(off**2, axis=0) - np.sum(off, axis=0) ** 2 - np.sum(twice**2, axis=0)
    pairs = count * (count - 1) - 2 * twice.shape[0]
    return np.asarray(np.maximum(squares, 0.0) / pairs)  # rounding


def standard_deviation(y: Array) -> Array:
    """Square root of :func:`variance`, (output,)."""
    return np.asarray(np.sqrt(variance(y)))


def seed_variance(y: Array) -> Array:
    """Mean over draws of the variance by seed alone, E[Var(y | all other inputs)], (output,); 1/2 of Jansen's."""
    return np.asarray(0.5 * np.mean((y[0] - y[1]) ** 2, axis=0))


def quantiles(y: Array, shares: Sequence[float]) -> Array:
    """Values below which shares of the scenes of both seeds lie, (share, output)."""
    return np.asarray(np.quantile(scenes(y), shares, axis=0))


def total_by_seed(y: Array) -> Array:
    """Total share of the seed: what of the variance stays if all other inputs are known, (output,)."""
    return _share(seed_variance(y), y)


def first_by_rest(y: Array) -> Array:
    """First-order share of all inputs but the seed together, (output,)."""
    return np.asarray(1.0 - total_by_seed(y))


def first_by_regression(x: Array, y: Array) -> Array:
    """First-order share of what the columns x (draw, term) are made of, by regression on them, (output,).

    The variance of the regression of the mean over seeds, less what as many meaningless terms would explain (adjusted
    coefficient of determination), over the variance. Negative where an input explains less than chance would. What the
    terms cannot follow is missed.
    """
    count = x.shape[0]
    target = y[:2].mean(axis=0)
    target = target - target.mean(axis=0)
    basis, triangle = np.linalg.qr(x - x.mean(axis=0))
    strength = np.abs(np.diag(triangle))
    basis = basis[:, strength > 1e-9 * max(float(strength.max(initial=0.0)), 1e-300)]
    terms = basis.shape[1]
    if count - terms - 1 < 1:
        return np.full(y.shape[2], np.nan)
    explained = np.sum((basis.T @ target) ** 2, axis=0)
    left = np.sum(target**2, axis=0) - explained
    return _share(explained / (count - 1) - left * terms / (count - 1) / (count - terms - 1), y)


def first_by_pick_freeze(y: Array, other: int, exchanged: int) -> Array:
    """First-order share of an input, (output,): Saltelli et al. (2010), table 2, row b.

    Parameters
    ----------
    other, exchanged : int
        Mixtures: that with all inputs of B, and that of A with one input of B.
    """
    level = y.mean(axis=(0, 1))
    return _share(np.mean((y[other] - level) * (y[exchanged] - y[0]), axis=0), y, other)


def total_by_pick_freeze(y: Array, other: int, exchanged: int) -> Array:
    """Total share of an input, (output,): M. J. W. Jansen, Computer Physics Communications 117 (1999) 35-43, eq 10."""
    return _share(0.5 * np.mean((y[0] - y[exchanged]) ** 2, axis=0), y, other)


def _share(part: Array, y: Array, other: int | None = None) -> Array:
    """Divide by the variance, of A and B where both have a part in it; NaN where the output does not vary."""
    whole = variance(y) if other is None else 0.5 * (variance(y) + y[other].var(axis=0, ddof=1))
    varies = whole > (SAME * np.abs(mean(y))) ** 2
    return np.asarray(np.divide(part, whole, out=np.full(whole.shape, np.nan), where=varies))


def terms_of(values: Array, count: int) -> Array | None:
    """Return what an output is regressed on: powers of one input, or a quadratic form of several.

    Parameters
    ----------
    values : ndarray (draw, input)
        Inputs; one, or several that belong together.
    count : int
        Draws that the regression has, which its terms must suit.

    Returns
    -------
    ndarray (draw, term) or None
        None where there are too few draws.
    """
    if count < LINEAR_FROM:
        return None
    spread = values.std(axis=0)
    scaled = (values - values.mean(axis=0)) / np.where(spread > 0.0, spread, 1.0)
    if count < CUBIC_FROM:
        return scaled if count >= 3 * scaled.shape[1] else None
    if scaled.shape[1] == 1:
        return np.concatenate([scaled, scaled**2, scaled**3], axis=1)
    products = [scaled[:, i] * scaled[:, j] for i in range(scaled.shape[1]) for j in range(i, scaled.shape[1])]
    quadratic = np.column_stack([scaled, *products])
    return quadratic if count >= 4 * quadratic.shape[1] else scaled


def bootstrap_error(estimate: Callable[[NDArray[np.intp]], Array], count: int, seed: np.random.SeedSequence) -> Array:
    """Return the standard error of an estimate: its standard deviation over samples of the draws with replacement.

    Parameters
    ----------
    estimate : callable
        Given the numbers of draws (count,), some of them more than once, returns an array of any shape.
    seed : SeedSequence
        Fixes the samples; all estimates with the same one are resampled alike.
    """
    generator = np.random.default_rng(seed)
    found = np.stack([estimate(generator.integers(count, size=count)) for _ in range(RESAMPLES)])
    return np.asarray(found.std(axis=0, ddof=1))
