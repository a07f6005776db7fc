"""How long a sequence of images stays like itself."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.errors import ImageError


@dataclass(frozen=True)
class TemporalAutocorrelation:
    """Correlation of images that lie some frames apart.

    Attributes
    ----------
    lag : ndarray of int64 (L,)
        Frames: 0, 1, 2, ...
    lag_s : ndarray (L,)
        Mean time between them, seconds; NaN where times are not known.
    correlation : ndarray (L,)
        Mean correlation over all pairs of images this far apart.
    pairs : ndarray of int64 (L,)
        Number of these pairs: one image is one sample, so that long lags say little.
    pixels : int
        Pixels that were followed.
    """

    lag: NDArray[np.int64]
    lag_s: NDArray[np.float64]
    correlation: NDArray[np.float64]
    pairs: NDArray[np.int64]
    pixels: int

    @property
    def decorrelation_s(self) -> float:
        """Time after which the correlation falls below 1/e, linear between lags.

        NaN where it never does, and where it has by the second image: then it is shorter than the images can tell.
        """
        after = self._first_below
        if after < 2 or np.isnan(self.lag_s).any():
            return math.nan
        ends = slice(after - 1, after + 1)
        return float(np.interp(-1.0 / math.e, -self.correlation[ends], self.lag_s[ends]))

    @property
    def is_unresolved(self) -> bool:
        """Whether the correlation has fallen below 1/e by the second image."""
        return self._first_below == 1

    @property
    def _first_below(self) -> int:
        below = np.flatnonzero(self.correlation < 1.0 / math.e)
        return int(below[0]) if below.size else 0


def temporal_autocorrelation(
    frames: NDArray[Any], seconds: NDArray[np.float64] | None = None
) -> TemporalAutocorrelation:
    """Correlate images with later ones at fixed pixels.

    The correlation of two images is that of their pixels, each image less its own mean. Whatever moves through the
    field of view (wind, platform) takes correlation away as change does.

    Parameters
    ----------
    frames : ndarray of real numbers (T, rows, columns)
        Two or more images; pixels that are NaN in one of them do not count.
    seconds : ndarray (T,), optional
        Times, ascending.

    Raises
    ------
    ImageError
        If there are fewer than two images, no pixel has values in all, or an image is constant.
    """
    count = frames.shape[0]
    if frames.ndim != 3 or count < 2:
        raise ImageError(f"frames: shape {frames.shape} given, allowed: (T, rows, columns) with T of 2 or more")
    flat = frames.reshape(count, -1).astype(np.float64)
    flat = flat[:, ~np.isnan(flat).any(axis=0)]
    if flat.shape[1] < 2:
        raise ImageError("frames: no two pixels have values in all images, allowed: some")
    flat -= flat.mean(axis=1, keepdims=True)
    length = np.sqrt(np.einsum("ij,ij->i", flat, flat))
    if length.min() == 0.0:
        raise ImageError(f"frames: image {int(length.argmin())} is constant, allowed: values that vary")
    flat /= length[:, None]
    # Rounding must not make an image more like itself than it is.
    matrix = np.clip(flat @ flat.T, -1.0, 1.0)
    lag = np.arange(count)
    correlation = np.array([1.0, *(float(np.mean(np.diagonal(matrix, n))) for n in lag[1:])])
    times = np.full(count, np.nan) if seconds is None else np.asarray(seconds, dtype=np.float64)
    lag_s = np.array([float(np.mean(times[n:] - times[: count - n])) for n in lag])
    return TemporalAutocorrelation(lag, lag_s, correlation, count - lag, flat.shape[1])
