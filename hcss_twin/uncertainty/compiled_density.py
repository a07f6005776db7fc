"""The density of an image's statistics, compiled: chains ask for it some 100 000 times."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit


@njit(cache=True, nogil=True, error_model="numpy")
def log_densities(
    positions: Any,
    semivariance: Any,
    variance: Any,
    observed: Any,
    sky: Any,
    threshold: float,
    uses_coverage: bool,
    first: float,
    step: float,
    table: Any,
    centre: Any,
    width: Any,
    mean: Any,
    log_deviation: Any,
    inverse: Any,
    leverage: Any,
    basis: Any,
    freedom: float,
    density: Any,
) -> None:
    """Fill ``density`` (N,): ``ImageLikelihood.log_likelihood`` without its arrays.

    Parameters
    ----------
    positions : ndarray (N, 4)
        H, gamma, Lx, Ly on their scales.
    semivariance, variance : ndarray (N, M) and (N,)
        Of the field, expected.
    observed : ndarray (M,)
        ln of semivariances of normal scores.
    sky : ndarray (N,)
        Threshold of the sky.
    threshold : float
        Normal score above which the frame's pixels are cloudy.
    uses_coverage : bool
        Whether the threshold is a statistic.
    first, step, table
        Of :attr:`hcss_twin.uncertainty.normal_scores.ScoreSemivariance.table`.
    centre, width, mean, log_deviation, inverse, leverage, basis, freedom
        Of :class:`hcss_twin.uncertainty.estimator_noise.EstimatorNoise`.
    density : ndarray (N,)
        Result.
    """
    number, lags = positions.shape[1], semivariance.shape[1]
    count = inverse.shape[0]
    x = np.empty(number)
    feature = np.empty(mean.shape[0])
    residual, raw = np.empty(count), np.empty(count)
    for n in range(positions.shape[0]):
        inside = True
        for i in range(number):
            away = positions[n, i] - centre[i]
            inside &= abs(away) <= width[i] + 1e-9
            x[i] = min(max(away / width[i], -1.0), 1.0) if width[i] > 0.0 else 0.0
        if not inside:
            density[n] = -np.inf
            continue
        feature[0] = 1.0
        k = 1 + number
        for i in range(number):
            feature[1 + i] = x[i]
            for j in range(i, number):
                feature[k] = x[i] * x[j]
                k += 1
        size = np.sqrt(1.0 - variance[n])
        # What the uncertainty of the mean adds to a variance of 1.
        added = 0.0
        for i in range(feature.size):
            found = 0.0
            for k in range(i + 1):
                found += leverage[i, k] * feature[k]
            added += found * found
        widening = 0.5 * np.log1p(added)
        total = 0.0
        for s in range(count):
            if s < lags:
                at = (np.log(semivariance[n, s] / variance[n]) - first) / step
                at = min(max(at, 0.0), table.size - 1.0)
                low = min(int(at), table.size - 2)
                expected = table[low] + (at - low) * (table[low + 1] - table[low])
                raw[s] = (observed[s] - expected) / size
            else:
                raw[s] = (sky[n] - np.sqrt(variance[n]) * threshold) / size
        for s in range(count):
            found = 0.0
            for k in range(count):
                found += basis[s, k] * raw[k]
            for k in range(feature.size):
                found -= feature[k] * mean[k, s]
            spread = widening + log_deviation[0, s]
            for i in range(number):
                spread += x[i] * log_deviation[1 + i, s]
            residual[s] = found * np.exp(-spread)
            total -= spread
        square = 0.0
        for s in range(count):
            white = 0.0
            for k in range(s + 1):
                white += inverse[s, k] * residual[k]
            square += white * white
        total -= 0.5 * (freedom + count) * np.log1p(square / freedom) + count * np.log(size)
        if uses_coverage:
            total += 0.5 * np.log(variance[n])
        density[n] = total
