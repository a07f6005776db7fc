"""Moments of the values of patches: spread, skewness, kurtosis."""

from __future__ import annotations

from typing import Literal

import numpy as np

from hcss_twin.providers import Array


def standard_moment(values: Array, order: Literal[3, 4]) -> Array:
    """Return the standardised moment of each patch (P, ...): order 3 is skewness, 4 kurtosis (3 if Gaussian).

    It is 0 for patches without any spread, which have no shape.
    """
    flat = values.reshape(len(values), -1)
    deviation = flat - flat.mean(axis=1, keepdims=True)
    square = deviation * deviation
    variance = square.mean(axis=1)
    spread = np.where(variance > 0.0, variance, 1.0) ** (order / 2)
    # Products are ten times as fast as powers.
    moment: Array = np.mean(square * (deviation if order == 3 else square), axis=1) / spread
    return moment


def histogram_features(patches: Array) -> dict[str, Array]:
    """Return mean, standard deviation, skewness, kurtosis of each patch (P, n, n), and skewness of the Laplacian.

    Mean and standard deviation are constant for z-scored patches. The Laplacian (five points) is skewed where plateaus
    end in sharp edges on one side only.
    """
    laplacian = (
        patches[:, 2:, 1:-1] + patches[:, :-2, 1:-1] + patches[:, 1:-1, 2:] + patches[:, 1:-1, :-2]
    ) - 4.0 * patches[:, 1:-1, 1:-1]
    return {
        "mean": patches.mean(axis=(1, 2)),
        "standard deviation": patches.std(axis=(1, 2)),
        "skewness": standard_moment(patches, 3),
        "kurtosis": standard_moment(patches, 4),
        "skewness of the Laplacian": standard_moment(laplacian, 3),
    }
