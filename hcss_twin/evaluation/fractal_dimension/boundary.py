"""Fractal dimension of the boundary of a mask by box counting."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.errors import ImageError
from hcss_twin.evaluation.checks import SMALLEST_SIDE, checked_mask
from hcss_twin.evaluation.fractal_dimension.estimate import DimensionEstimate
from hcss_twin.evaluation.fractal_dimension.measured import Measured

# The largest box is at most this part of the shorter side.
_LARGEST_BOX = 4


def boundary_dimension(mask: NDArray[np.bool_]) -> DimensionEstimate:
    """Count the boxes that the boundary between cloudy and clear pixels passes through.

    The boundary is the set of pixel corners where the four pixels are not all alike; the edge of
    the image is not part of it, and a mask and its complement have the same. The dimension is the
    slope of log N(s) against log(1 / s), s about 2, 4, 8, ... up to a quarter of the shorter side;
    the boxes of each size tile the image evenly. The level sets of a self-affine surface with
    Hurst exponent H have 2 - H, which is approached slowly: docs/fractal-dimension.md has the bias.

    Parameters
    ----------
    mask : ndarray of bool (rows, columns)
        At least 32 x 32 pixels, cloudy ones true.

    Returns
    -------
    DimensionEstimate
        The error is that of masks that are half cloudy, of fractional Brownian surfaces.

    Raises
    ------
    ImageError
        If the mask is too small, of another type, or the same everywhere.
    """
    cloudy = _checked(mask)
    rows, columns = cloudy.shape[0] - 1, cloudy.shape[1] - 1
    first = cloudy[:-1, :-1]
    corners = (first != cloudy[:-1, 1:]) | (first != cloudy[1:, :-1]) | (first != cloudy[1:, 1:])
    row, column = np.nonzero(corners)
    if row.size == 0:
        raise ImageError(
            f"mask: {'cloudy' if cloudy[0, 0] else 'clear'} everywhere, allowed: both, for a boundary"
        )
    log_side, log_count = [], []
    s = 2
    while s <= min(cloudy.shape) // _LARGEST_BOX:
        down, across = round(rows / s), round(columns / s)
        box = np.zeros(down * across, dtype=np.bool_)
        box[(row * down // rows) * across + column * across // columns] = True
        log_side.append(0.5 * math.log(rows / down * columns / across))
        log_count.append(math.log(np.count_nonzero(box)))
        s *= 2
    dimension = -float(np.polyfit(log_side, log_count, 1)[0])
    # The table is kept by the dimension of the surface, which is one greater.
    error = Measured.load().standard_error("boundary", dimension + 1.0, min(cloudy.shape))
    return DimensionEstimate(dimension, error, "box counting of the boundary")


def _checked(mask: Any) -> NDArray[np.bool_]:
    array = np.asarray(mask)
    cloudy = checked_mask("mask", array, array.shape)
    if cloudy.ndim != 2 or min(cloudy.shape) < SMALLEST_SIDE:
        raise ImageError(
            f"mask: shape {cloudy.shape} given, allowed: (rows, columns) of {SMALLEST_SIDE} or more each"
        )
    return cloudy
