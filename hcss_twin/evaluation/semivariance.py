"""Semivariances of an image along its axes: the empirical variogram."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from hcss_twin.errors import ImageError
from hcss_twin.evaluation.checks import checked_image, checked_mask


@dataclass(frozen=True)
class Semivariances:
    """Half the mean square differences of pixels that lie some lags apart.

    Attributes
    ----------
    lags : ndarray of int64 (lags,)
        Distances in pixels.
    along_x, along_y : ndarray of float64 (lags,)
        1/2 mean (f(p + lag) - f(p))^2 along columns (x) and along rows (y), in squared units of the image;
        NaN where no pair exists.
    pairs_x, pairs_y : ndarray of int64 (lags,)
        Pairs that each mean was taken over.
    """

    lags: NDArray[np.int64]
    along_x: NDArray[np.float64]
    along_y: NDArray[np.float64]
    pairs_x: NDArray[np.int64]
    pairs_y: NDArray[np.int64]

    @property
    def pooled(self) -> NDArray[np.float64]:
        """Mean over the pairs of both axes (lags,); NaN where no pair exists."""
        total = np.where(self.pairs_x > 0, self.along_x, 0.0) * self.pairs_x
        total += np.where(self.pairs_y > 0, self.along_y, 0.0) * self.pairs_y
        return _mean(total, self.pairs_x + self.pairs_y)


def _mean(total: NDArray[np.float64], pairs: NDArray[np.int64]) -> NDArray[np.float64]:
    result = np.full(total.shape, np.nan)
    np.divide(total, pairs, out=result, where=pairs > 0)
    return result


def semivariances(
    image: NDArray[Any], lags: Sequence[int] = (1, 2), mask: NDArray[np.bool_] | None = None
) -> Semivariances:
    """Measure the variogram along both axes, in one pass per lag.

    Parameters
    ----------
    image : ndarray of float32, float64 or integers (rows, columns)
        Any unit; pixels outside ``mask`` may be anything, NaN included.
    lags : sequence of int
        Distances in pixels, each at least 1 and shorter than the longer side.
    mask : ndarray of bool (rows, columns), optional
        Pixels that count: a pair counts if both its pixels do. All, by default.

    Raises
    ------
    ImageError
        If a counting pixel is not finite, or image, mask or lags are not as described.
    """
    pixels = checked_image("image", image, smallest=2)
    longest = max(pixels.shape) - 1
    distances = np.array(list(lags))
    if distances.ndim != 1 or distances.size == 0 or distances.dtype.kind not in "iu":
        raise ImageError(f"lags: {lags!r} given, allowed: one or more whole numbers of pixels")
    for lag in distances:
        if not 1 <= lag <= longest:
            raise ImageError(
                f"lags: {lag} given, allowed: 1 to {longest}; closest is {min(max(1, int(lag)), longest)}"
            )
    valid = None if mask is None else checked_mask("mask", mask, pixels.shape)
    sums, pairs = _sums(pixels, distances, valid)
    if not np.all(np.isfinite(sums)) or np.any((sums < 1e-280) & (pairs > 0)):
        # Not finite, constant, or so large or small that squares leave the range of double precision.
        counted = (pixels if valid is None else pixels[valid]).astype(np.float64)
        if not np.all(np.isfinite(counted)):
            raise ImageError("image: a pixel is not finite, allowed: finite numbers wherever the mask is true")
        largest = float(np.abs(counted).max()) if counted.size else 0.0
        if largest > 0.0:
            unit = float(2.0 ** np.frexp(largest)[1])
            scaled = np.where(True if valid is None else valid, pixels, 0.0) / unit
            sums, pairs = _sums(scaled, distances, valid)
            with np.errstate(over="ignore", under="ignore"):
                sums = sums * unit * unit
    halves = 0.5 * sums
    return Semivariances(
        distances.astype(np.int64),
        _mean(halves[0], pairs[0]),
        _mean(halves[1], pairs[1]),
        pairs[0],
        pairs[1],
    )


def _sums(
    pixels: NDArray[Any], lags: NDArray[np.int64], valid: NDArray[np.bool_] | None
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return sums of squares and numbers of pairs, both (x then y, lags)."""
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


# Four partial sums: without reassociation a single one is bound by the latency of the addition.
@njit(cache=True, nogil=True)  # type: ignore[untyped-decorator]
def _row_squares(here: Any, there: Any) -> float:
    a = b = c = d = 0.0
    size = here.size
    whole = size - size % 4
    for j in range(0, whole, 4):
        p = np.float64(there[j]) - np.float64(here[j])
        q = np.float64(there[j + 1]) - np.float64(here[j + 1])
        r = np.float64(there[j + 2]) - np.float64(here[j + 2])
        s = np.float64(there[j + 3]) - np.float64(here[j + 3])
        a += p * p
        b += q * q
        c += r * r
        d += s * s
    for j in range(whole, size):
        p = np.float64(there[j]) - np.float64(here[j])
        a += p * p
    return (a + b) + (c + d)


@njit(cache=True, nogil=True)  # type: ignore[untyped-decorator]
def _squares(image: Any, lag: int) -> tuple[float, float]:
    rows, columns = image.shape
    x = y = 0.0
    for i in range(rows):
        if columns > lag:
            x += _row_squares(image[i, : columns - lag], image[i, lag:])
        if i + lag < rows:
            y += _row_squares(image[i], image[i + lag])
    return x, y


@njit(cache=True, nogil=True)  # type: ignore[untyped-decorator]
def _masked_squares(image: Any, valid: Any, lag: int) -> tuple[float, float, int, int]:
    rows, columns = image.shape
    x = y = 0.0
    pairs_x = pairs_y = 0
    for i in range(rows):
        for j in range(columns):
            if not valid[i, j]:
                continue
            here = np.float64(image[i, j])
            if j + lag < columns and valid[i, j + lag]:
                step = np.float64(image[i, j + lag]) - here
                x += step * step
                pairs_x += 1
            if i + lag < rows and valid[i + lag, j]:
                step = np.float64(image[i + lag, j]) - here
                y += step * step
                pairs_y += 1
    return x, y, pairs_x, pairs_y
