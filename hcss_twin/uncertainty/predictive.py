"""What images with the posterior's parameters would show, beside what the image shows."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hcss_twin.uncertainty.image_likelihood import ImageLikelihood, on_scales
from hcss_twin.uncertainty.posterior_file import VariogramCheck
from hcss_twin.uncertainty.scales import KINDS, SHAPE

Array = NDArray[np.float64]

QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)

SUSPICIOUS = 0.01
"""Of the predictive p-value: below, the image is unlike any fractal field."""

_DRAWS = 2000


def predictive_check(
    likelihoods: Sequence[ImageLikelihood], values: Sequence[Array], rng: np.random.Generator
) -> tuple[VariogramCheck, list[float]]:
    """Compare images with replicates drawn from the posterior.

    Parameters
    ----------
    likelihoods : sequence of ImageLikelihood
        One per image.
    values : sequence of ndarray (N, 5)
        All parameters of each image, draws of the posterior.
    rng : Generator
        Of the replicates.

    Returns
    -------
    check : VariogramCheck
        With an axis for the images where there are several.
    p_values : list of float
        Of each image: the part of replicates that is at least as far from the mean as the image
        (squared Mahalanobis distance; A. Gelman et al., Bayesian Data Analysis, 3rd ed., section 6.3).
    """
    lags = np.unique(np.concatenate([each.data.lags for each in likelihoods]))
    count = len(likelihoods)
    observed = np.full((count, lags.size, 2), np.nan)
    error = np.full((count, lags.size, 2), np.nan)
    predicted = np.full((len(QUANTILES), count, lags.size, 2), np.nan)
    p_values = []
    for image, (likelihood, drawn) in enumerate(zip(likelihoods, values, strict=True)):
        drawn = drawn[rng.integers(0, drawn.shape[0], _DRAWS)]
        rows = np.searchsorted(lags, likelihood.data.lags)
        shape = (-1, 2, rows.size)
        replicates = np.exp(likelihood.replicate(drawn[:, : len(SHAPE)], rng)).reshape(shape)
        centre = likelihood.replicate(_mean_shape(drawn, _DRAWS), rng)
        observed[image, rows] = likelihood.data.variogram.reshape(2, -1).T
        error[image, rows] = np.exp(centre).std(axis=0).reshape(2, -1).T
        predicted[:, image, rows] = np.moveaxis(np.quantile(replicates, QUANTILES, axis=0), 1, 2)
        p_values.append(_p_value(likelihood, drawn, rng))
    if count == 1:
        observed, error, predicted = observed[0], error[0], predicted[:, 0]
    return VariogramCheck(lags, observed, error, np.array(QUANTILES), predicted), p_values


def _mean_shape(drawn: Array, count: int) -> Array:
    position = on_scales(drawn[:, : len(SHAPE)]).mean(axis=0)
    shape = np.array([KINDS[name].scale.back(np.array(p)) for name, p in zip(SHAPE, position, strict=True)])
    return np.tile(shape, (count, 1))


def _p_value(likelihood: ImageLikelihood, drawn: Array, rng: np.random.Generator) -> float:
    noise = likelihood.noise
    assert noise is not None
    positions, residuals, _ = likelihood.residuals(drawn)
    distance = noise.square_distance(positions, residuals)
    replicated = rng.chisquare(noise.lower.shape[0], drawn.shape[0])
    return float(np.mean(replicated >= distance))
