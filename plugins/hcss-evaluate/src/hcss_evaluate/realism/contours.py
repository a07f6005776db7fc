"""Shapes inside contours of patches: perimeter, Euler number, number of connected parts."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import label

from hcss_twin.providers import Array

_QUANTILES = (0.1, 0.3, 0.5, 0.7, 0.9)
_IN_PLANE = np.array([[[0] * 3] * 3, [[0, 1, 0], [1, 1, 1], [0, 1, 0]], [[0] * 3] * 3])


def perimeter(masks: NDArray[np.bool_]) -> Array:
    """Return the number of pixel sides between true and false in each mask (P, n, m); the frame does not count."""
    sides = np.count_nonzero(masks[:, 1:] != masks[:, :-1], axis=(1, 2))
    return np.asarray(sides + np.count_nonzero(masks[:, :, 1:] != masks[:, :, :-1], axis=(1, 2)), dtype=np.float64)


def euler_number(masks: NDArray[np.bool_]) -> Array:
    """Return the number of parts less the number of holes of each mask (P, n, m).

    Pixels that share a side are connected: pixels less pairs plus full squares of four (Euler's formula).
    """
    pairs_y, pairs_x = masks[:, 1:] & masks[:, :-1], masks[:, :, 1:] & masks[:, :, :-1]
    counts = [
        np.count_nonzero(mask, axis=(1, 2)) for mask in (masks, pairs_y, pairs_x, pairs_x[:, 1:] & pairs_x[:, :-1])
    ]
    return np.asarray(counts[0] - counts[1] - counts[2] + counts[3], dtype=np.float64)


def components(masks: NDArray[np.bool_]) -> Array:
    """Return the number of parts of each mask (P, n, m); pixels that share a side are connected."""
    labels, _ = label(masks, _IN_PLANE)
    # Labels ascend from mask to mask.
    last = np.maximum.accumulate(labels.reshape(len(masks), -1).max(axis=1, initial=0))
    return np.diff(last, prepend=0).astype(np.float64)


def contour_features(patches: Array) -> dict[str, Array]:
    """Return perimeter, Euler number and parts of what is colder than five quantiles of each patch (P, n, n)."""
    found: dict[str, Array] = {}
    for quantile in _QUANTILES:
        cold = patches < np.quantile(patches, quantile, axis=(1, 2), keepdims=True)
        found[f"perimeter at quantile {quantile}"] = perimeter(cold)
        found[f"Euler number at quantile {quantile}"] = euler_number(cold)
        found[f"parts at quantile {quantile}"] = components(cold)
    return found
