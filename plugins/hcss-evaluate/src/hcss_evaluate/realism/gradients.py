"""Gradients of patches: how steep edges are, and how much is flat."""

from __future__ import annotations

import numpy as np

from hcss_evaluate.realism.moments import standard_moment
from hcss_twin.providers import Array

_PERCENTILES = (10, 50, 90, 99)
_FLAT = 0.25
"""Pixels flatter than this share of the patch's root mean square gradient count as flat."""


def gradient_features(patches: Array) -> dict[str, Array]:
    """Return percentiles of the gradient (unit of the patches per pixel), its kurtosis and the share of flat pixels.

    Gradients are central differences of patches (P, n, n). The kurtosis is that of the components along both axes, 3
    for a Gaussian field.
    """
    along_y = (patches[:, 2:, 1:-1] - patches[:, :-2, 1:-1]) / 2.0
    along_x = (patches[:, 1:-1, 2:] - patches[:, 1:-1, :-2]) / 2.0
    size = np.hypot(along_y, along_x).reshape(len(patches), -1)
    mean_square = np.sqrt(np.mean(size**2, axis=1, keepdims=True))
    percentiles = np.percentile(size, _PERCENTILES, axis=1)
    found = {
        f"gradient, percentile {percentile}": row for percentile, row in zip(_PERCENTILES, percentiles, strict=True)
    }
    found["kurtosis of the gradient"] = standard_moment(np.stack((along_y, along_x), axis=1), 4)
    found["share of flat pixels"] = np.mean(size < _FLAT * mean_square, axis=1)
    return found
