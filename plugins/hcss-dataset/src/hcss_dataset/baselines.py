"""Detectors that anyone can repeat: scale-normalised Laplacian of Gaussian, white top-hat, matched filter.

Each maps an image to one in which targets are bright, whatever the sign of their contrast; its highest pixels are the
detections.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from hcss_dataset.scoring import Detection

Image = NDArray[np.float64]

SIGMA = 0.8
"""Of the spot that filters look for, pixels."""

PATCH, BLOCK, LOADING = 5, 32, 1e-3
"""Side of the matched filter, side of the blocks that have a covariance of their own, and what is added to its
diagonal, relative to the mean variance: covariances of few patches can be inverted."""

MAX_PER_FRAME = 100
"""Detections that are kept of a frame, the number at which COCO's evaluation cuts (maxDets)."""


def laplacian(image: Image) -> Image:
    """Return the Laplacian of Gaussian, in units of the spread of all pixels."""
    filtered = np.abs(ndimage.gaussian_laplace(image, SIGMA, mode="reflect"))
    return _in_spreads(filtered)


def top_hat(image: Image) -> Image:
    """Return the image less its opening with 5 x 5 pixels, or its closing less the image where that is more."""
    bright, dark = ndimage.white_tophat(image, size=5), ndimage.black_tophat(image, size=5)
    return _in_spreads(np.maximum(bright, dark))


def matched_filter(image: Image) -> Image:
    """Return the signal-to-clutter ratio after the filter that is best for the covariance around each pixel.

    The covariance of patches is that of a block of pixels with as much again on each side.
    """
    half = PATCH // 2
    padded = np.pad(image, half, mode="reflect")
    patches = np.lib.stride_tricks.sliding_window_view(padded, (PATCH, PATCH)).reshape(*image.shape, PATCH**2)
    spot = _spot()
    result = np.empty(image.shape)
    rows, columns = image.shape
    for top in range(0, rows, BLOCK):
        for left in range(0, columns, BLOCK):
            around = patches[max(top - BLOCK, 0) : top + 2 * BLOCK, max(left - BLOCK, 0) : left + 2 * BLOCK]
            sample = around.reshape(-1, PATCH**2)
            mean = sample.mean(axis=0)
            covariance = (sample - mean).T @ (sample - mean) / len(sample)
            load = LOADING * np.trace(covariance) / PATCH**2
            filled = covariance + max(load, np.finfo(float).tiny) * np.eye(PATCH**2)
            weights = np.linalg.solve(filled, spot)
            norm = np.sqrt(max(float(spot @ weights), np.finfo(float).tiny))
            block = patches[top : top + BLOCK, left : left + BLOCK]
            result[top : top + BLOCK, left : left + BLOCK] = np.abs((block - mean) @ weights) / norm
    return result


BASELINES: Mapping[str, Callable[[Image], Image]] = {
    "log": laplacian,
    "top-hat": top_hat,
    "matched-filter": matched_filter,
}


def detect(name: str, image: Image, most: int = MAX_PER_FRAME) -> list[Detection]:
    """Return the highest local maxima of a baseline, with the centre of light of the 3 x 3 pixels around each."""
    filtered = BASELINES[name](image)
    peaks = (filtered == ndimage.maximum_filter(filtered, size=3, mode="nearest")) & (filtered > 0.0)
    rows, columns = np.nonzero(peaks)
    order = np.argsort(-filtered[rows, columns], kind="stable")[:most]
    padded, found = np.pad(filtered, 1), []
    for row, column in zip(rows[order].tolist(), columns[order].tolist(), strict=True):
        near = padded[row : row + 3, column : column + 3]
        y, x = (float(np.sum(near * offset) / near.sum()) for offset in _OFFSETS)
        found.append(Detection(row + 0.5 + y, column + 0.5 + x, float(filtered[row, column])))
    return found


_OFFSETS = np.array([-1.0, 0.0, 1.0])[:, None] * np.ones((3, 3)), np.array([-1.0, 0.0, 1.0]) * np.ones((3, 3))


def _spot() -> Image:
    """Return the spot that filters look for (PATCH^2,), without its mean."""
    at = np.arange(PATCH) - PATCH // 2
    spot = np.exp(-0.5 * (at[:, None] ** 2 + at**2) / SIGMA**2).ravel()
    result: Image = spot - spot.mean()
    return result


def _in_spreads(filtered: Image) -> Image:
    """Return a filtered image relative to its median absolute deviation, so that frames compare."""
    spread = np.median(np.abs(filtered - np.median(filtered)))
    return filtered / spread if spread > 0.0 else filtered
