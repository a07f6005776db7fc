"""Semivariances of an image along its axes: the empirical variogram."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_evaluate.measures.checks import checked_mask
from hcss_evaluate.measures.images import checked_image
from hcss_twin.core.kernels import kernel
from hcss_twin.providers import Array, ImageError


@dataclass(frozen=True)
class Semivariances:
    """Half the mean square differences of pixels at given lags.

    Attributes
    ----------
    lags : ndarray of int64 (lags,)
        Distances in pixels.
    along_x, along_y : ndarray of float64 (lags,)
        1/2 mean (f(p + lag) - f(p))^2 along columns (x) and along rows (y), in squared units of the image; NaN without
        pairs.
    pairs_x, pairs_y : ndarray of int64 (lags,)
        Number of pairs in each mean.
    """

    lags: NDArray[np.int64]
    along_x: Array
    along_y: Array
    pairs_x: NDArray[np.int64]
    pairs_y: NDArray[np.int64]

    @property
    def pooled(self) -> Array:
        """Mean over both axes (lags,), weighted with their pairs at the first lag.

        The weights are the same at all lags, so that differences between the axes do not change the slope. An axis
        without pairs at the first lag is excluded.
        """
        x, y = self.pairs_x[0], self.pairs_y[0]
        if x == 0 or y == 0:
            return self.along_y if x == 0 else self.along_x
        share = float(x) / float(x + y)
        result: Array = share * self.along_x + (1.0 - share) * self.along_y
        return result


def _mean(total: Array, pairs: NDArray[np.int64]) -> Array:
    result = np.full(total.shape, np.nan)
    np.divide(total, pairs, out=result, where=pairs > 0)
    return result


def semivariances(
    image: NDArray[Any], lags: Sequence[int] = (1, 2), mask: NDArray[np.bool_] | None = None
) -> Semivariances:
    """Measure the variogram of an image (rows, columns), any unit, along both axes, in one pass per lag.

    Lags are in pixels, each at least 1 and shorter than the longer side. A pair is used if both its pixels are in
    ``mask`` (default: all); other pixels may have any value, including NaN. Raises ImageError if a used pixel or the
    square of a difference is not finite, or image, mask or lags are invalid.
    """
    pixels = checked_image("image", image, smallest=2)
    if pixels.dtype == np.uint8:
        pixels = pixels.astype(np.float32)  # exact, and free of wrapping differences
    longest = max(pixels.shape) - 1
    distances: NDArray[Any] = np.array(list(lags))
    if distances.ndim != 1 or distances.size == 0 or distances.dtype.kind not in "iu":
        raise ImageError(f"lags: {lags!r} given, allowed: one or more whole numbers of pixels")
    distances = distances.astype(np.int64)
    for lag in distances:
        if not 1 <= lag <= longest:
            raise ImageError(f"lags: {lag} given, allowed: 1 to {longest}; closest is {min(max(1, int(lag)), longest)}")
    valid = None if mask is None else checked_mask("mask", mask, pixels.shape)
    sums, pairs = _sums(pixels, distances, valid)
    if not np.all(np.isfinite(sums)):
        raise ImageError(
            "image: a pixel is not finite, or the square of a difference is not, allowed: finite numbers "
            "wherever the mask is true"
        )
    halves: Array = 0.5 * sums
    return Semivariances(distances, _mean(halves[0], pairs[0]), _mean(halves[1], pairs[1]), pairs[0], pairs[1])


def _sums(
    pixels: NDArray[Any], lags: NDArray[np.int64], valid: NDArray[np.bool_] | None
) -> tuple[Array, NDArray[np.int64]]:
    """Return sums of squares and numbers of pairs, both (axis, lags) with x first."""
    rows, columns = pixels.shape
    sums = np.zeros((2, lags.size))
    pairs = np.zeros((2, lags.size), dtype=np.int64)
    for i, lag in enumerate(lags):
        if valid is None:
            sums[0, i], sums[1, i] = _squares(pixels, int(lag))
            pairs[0, i] = rows * max(columns - lag, 0)
            pairs[1, i] = max(rows - lag, 0) * columns
        else:
            sums[0, i], sums[1, i], pairs[0, i], pairs[1, i] = _masked_squares(pixels, valid, int(lag))
    return sums, pairs


@kernel()
def _squares(image: Any, lag: int) -> tuple[float, float]:
    rows, columns = image.shape
    # One sum per column; with a single sum each addition would wait for the previous one.
    x, y = np.zeros(columns), np.zeros(columns)
    for i in range(rows):
        for j in range(columns - lag):
            step = np.float64(image[i, j + lag] - image[i, j])
            x[j] += step * step
        if i + lag < rows:
            for j in range(columns):
                step = np.float64(image[i + lag, j] - image[i, j])
                y[j] += step * step
    return x.sum(), y.sum()


@kernel()
def _masked_squares(image: Any, valid: Any, lag: int) -> tuple[float, float, int, int]:
    rows, columns = image.shape
    x, y = np.zeros(columns), np.zeros(columns)
    pairs_x, pairs_y = np.zeros(columns, np.int32), np.zeros(columns, np.int32)
    nothing = image.dtype.type(0)
    # No branches, so that the loops are vectorised and a ragged mask is as fast as a smooth one.
    for i in range(rows):
        for j in range(columns - lag):
            both = valid[i, j] & valid[i, j + lag]
            step = np.float64(image[i, j + lag] - image[i, j] if both else nothing)
            x[j] += step * step
            pairs_x[j] += np.int32(both)
        if i + lag < rows:
            for j in range(columns):
                both = valid[i, j] & valid[i + lag, j]
                step = np.float64(image[i + lag, j] - image[i, j] if both else nothing)
                y[j] += step * step
                pairs_y[j] += np.int32(both)
    return x.sum(), y.sum(), pairs_x.sum(), pairs_y.sum()
