"""Estimators of moments, quantiles and shares of the variance (Sobol indices) from draws.

y has the axes (mixture, draw, output); mixture 0 holds the draws and mixture 1 the same draws with other seeds. y is
NaN in scenes that lack the outputs (a class without pixels); all outputs are missing in the same scenes. Moments and
quantiles use every scene that has the outputs: requiring them in both scenes of a draw would favour inputs that often
produce them. Sobol indices need draws that have the outputs in all mixtures.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from hcss_twin.providers import Array

RESAMPLES = 200
"""Number of bootstrap samples of the draws for all standard errors."""

CUBIC_FROM, LINEAR_FROM = 40, 12
"""Minimum number of draws for cubic regressions, and for any regression."""

SAME = 1e-7
"""Relative spread below which an output counts as constant: single precision."""


def scenes(y: Array) -> Array:
    """Scenes of both seeds that have the outputs, (scene, output)."""
    values = y[:2].reshape(-1, y.shape[2])
    return np.asarray(values[np.isfinite(values).all(axis=1)])


def mean(y: Array) -> Array:
    """Mean over the scenes of both seeds, (output,)."""
    return np.asarray(scenes(y).mean(axis=0))


def variance(y: Array) -> Array:
    """Variance over draws and seeds, (output,); unbiased if all scenes have the outputs.

    Half of the mean squared difference between scenes of different draws (a U-statistic: W. Hoeffding, Annals of
    Mathematical Statistics 19 (1948) 293-325), because scenes of the same draw share its inputs.
    """
    of_scenes = scenes(y)
    off = of_scenes - of_scenes.mean(axis=0)
    apart = y[0] - y[1]
    twice = apart[np.isfinite(apart).all(axis=1)]  # draws that have the outputs with both seeds
    count = of_scenes.shape[0]
    squares = count * np.sum(off**2, axis=0) - np.sum(off, axis=0) ** 2 - np.sum(twice**2, axis=0)
    pairs = count * (count - 1) - 2 * twice.shape[0]
    return np.asarray(np.maximum(squares, 0.0) / pairs)  # rounding


def standard_deviation(y: Array) -> Array:
    """Square root of :func:`variance`, (output,)."""
    return np.asarray(np.sqrt(variance(y)))


def seed_variance(y: Array) -> Array:
    """Mean over draws of the variance due to the seed, E[Var(y | all other inputs)], (output,)."""
    return np.asarray(0.5 * np.mean((y[0] - y[1]) ** 2, axis=0))


def quantiles(y: Array, shares: Sequence[float]) -> Array:
    """Quantiles over the scenes of both seeds, (share, output)."""
    return np.asarray(np.quantile(scenes(y), shares, axis=0))


def total_by_seed(y: Array) -> Array:
    """Total-effect Sobol index of the seed: the variance fraction left if all other inputs are known, (output,)."""
    return _share(seed_variance(y), y)


def first_by_rest(y: Array) -> Array:
    """First-order Sobol index of all inputs except the seed, as a group, (output,)."""
    return np.asarray(1.0 - total_by_seed(y))


def first_by_regression(x: Array, y: Array) -> Array:
    """First-order Sobol index of the inputs with regressors x (draw, term), by regression, (output,).

    This is the variance explained by a regression of the mean over seeds, adjusted for the number of terms (adjusted
    coefficient of determination), divided by the variance. It is negative if an input explains less than expected by
    chance. Dependence that the terms cannot represent is missed.
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
    """First-order Sobol index of an input, (output,): Saltelli et al. (2010), table 2, row b.

    ``other`` is the mixture with all inputs of B, ``exchanged`` that of A with one input of B.
    """
    level = y.mean(axis=(0, 1))
    return _share(np.mean((y[other] - level) * (y[exchanged] - y[0]), axis=0), y, other)


def total_by_pick_freeze(y: Array, other: int, exchanged: int) -> Array:
    """Total-effect Sobol index, (output,): M. J. W. Jansen, Computer Physics Communications 117 (1999) 35-43, eq 10."""
    return _share(0.5 * np.mean((y[0] - y[exchanged]) ** 2, axis=0), y, other)


def _share(part: Array, y: Array, other: int | None = None) -> Array:
    """Divide by the variance, or by its mean over A and B if both contribute; NaN if the output does not vary."""
    whole = variance(y) if other is None else 0.5 * (variance(y) + y[other].var(axis=0, ddof=1))
    varies = whole > (SAME * np.abs(mean(y))) ** 2
    return np.asarray(np.divide(part, whole, out=np.full(whole.shape, np.nan), where=varies))


def terms_of(values: Array, count: int) -> Array | None:
    """Return the regressors for an output: powers of one input, or a quadratic form of several, (draw, term).

    ``values`` (draw, input) are one input or a group of inputs. The terms depend on ``count``, the number of draws;
    None if there are too few.
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
    """Return the bootstrap standard error of an estimate: its standard deviation over resampled draws.

    ``estimate`` takes draw numbers (count,), with repetitions, and returns an array of any shape. ``seed`` determines
    the samples; estimates with the same seed use the same samples.
    """
    generator = np.random.default_rng(seed)
    estimates = np.stack([estimate(generator.integers(count, size=count)) for _ in range(RESAMPLES)])
    return np.asarray(estimates.std(axis=0, ddof=1))
