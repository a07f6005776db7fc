"""Fractal dimension from the slope of the variogram."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.errors import ImageError
from hcss_twin.evaluation.checks import checked_image
from hcss_twin.evaluation.fractal_dimension.estimate import DimensionEstimate
from hcss_twin.evaluation.fractal_dimension.measured import Measured
from hcss_twin.evaluation.semivariance import semivariances

# Fewer pairs say nothing about a slope.
_FEWEST_PAIRS = 100


def variogram_dimension(
    image: NDArray[Any], lags: Sequence[int] = (1, 2), mask: NDArray[np.bool_] | None = None
) -> DimensionEstimate:
    """Estimate D = 3 - slope / 2, the slope that of log semivariance against log lag.

    A self-affine surface with Hurst exponent H has the variogram |h|^(2 H) and D = 3 - H. The
    semivariances of both axes are averaged, the slope is that of least squares.

    Parameters
    ----------
    image : ndarray of float32, float64 or integers (rows, columns)
        At least 32 x 32 pixels, any unit.
    lags : sequence of int
        Two or more different distances in pixels.
    mask : ndarray of bool (rows, columns), optional
        Only pairs with both pixels in it count; all, by default. Other pixels may be NaN.

    Returns
    -------
    DimensionEstimate
        Not confined to 2 to 3: white noise is near 3, a smooth image near 2. Its error is that of full
        images of floating-point numbers with lags 1 and 2, for the number of pairs that counted; NaN for
        other lags.

    Raises
    ------
    ImageError
        If the image is too small, constant over the pairs, or not finite where it counts, if there are
        fewer than 100 pairs at a lag, or if the lags do not differ.
    """
    pixels = checked_image("image", image)
    found = semivariances(pixels, lags, mask)
    if np.unique(found.lags).size < 2:
        raise ImageError(f"lags: {tuple(lags)} given, allowed: two or more different ones; closest is (1, 2)")
    pairs = found.pairs_x + found.pairs_y
    if pairs.min() < _FEWEST_PAIRS:
        lag = found.lags[pairs.argmin()]
        raise ImageError(
            f"mask: {pairs.min()} pairs of pixels at lag {lag}, allowed: {_FEWEST_PAIRS} or more"
        )
    pooled = found.pooled
    if not np.all(pooled > 0.0):
        lag = found.lags[np.argmin(pooled > 0.0)]
        raise ImageError(f"image: semivariance 0 at lag {lag}, allowed: values that vary")
    slope = np.polyfit(np.log(found.lags.astype(np.float64)), np.log(pooled), 1)[0]
    listed = ", ".join(str(lag) for lag in found.lags)
    dimension = float(3.0 - slope / 2.0)
    if tuple(found.lags) == (1, 2):
        error = Measured.load().standard_error("variogram", dimension, math.sqrt(float(pairs.min()) / 2.0))
    else:
        error = math.nan
    return DimensionEstimate(dimension, error, f"variogram, lags {listed}")
