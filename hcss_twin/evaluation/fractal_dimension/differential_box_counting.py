"""Fractal dimension by differential box counting of an 8-bit image."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from hcss_twin.errors import ImageError
from hcss_twin.evaluation.checks import checked_image, checked_levels, finite_range
from hcss_twin.evaluation.fractal_dimension.box_maxima import box_extremes
from hcss_twin.evaluation.fractal_dimension.estimate import DimensionEstimate
from hcss_twin.evaluation.fractal_dimension.measured import Measured

# The largest box is at most this part of the shorter side: larger ones are few and only add scatter.
_LARGEST_BOX = 8


def box_counting_dimension(
    image: NDArray[Any], levels: int = 256, calibrated: bool = True
) -> DimensionEstimate:
    """Count the boxes that the grey-level surface passes through.

    The image is stretched to ``levels`` grey levels. Columns of s x s pixels are cut into boxes
    that are h = s levels / M high, with M the shorter side; in each column the surface takes
    floor(max / h) - floor(min / h) + 1 of them. The raw dimension is the slope of the logarithm of
    their number per area against log(1 / s), s = 2, 4, 8, ... up to M / 8 (N. Sarkar and B. B.
    Chaudhuri, "An efficient differential box-counting approach to compute fractal dimension of
    image", IEEE Trans. Syst. Man Cybern. 24, 115-120, 1994, who let s run to M / 2).

    The raw value is too small, by .1 to .9, because neighbouring columns share no pixel and because
    rough surfaces fill all boxes. The calibrated value is the D of exact fractional Brownian
    surfaces of this size that have this raw value on average (docs/fractal-dimension.md).

    Parameters
    ----------
    image : ndarray of float32, float64 or integers (rows, columns)
        At least 32 x 32 pixels, any unit.
    levels : int
        Grey levels, 2 to 256.
    calibrated : bool
        Whether the calibration is applied; it was measured with 256 levels.

    Returns
    -------
    DimensionEstimate
        The error is NaN of raw values, of dimensions outside 2 to 3, and of images larger than those
        of the calibration.

    Raises
    ------
    ImageError
        If the image is too small, constant or not finite, if ``levels`` is out of range, or if a
        calibrated value is wanted for other than 256 levels.
    """
    pixels = checked_image("image", image)
    checked_levels(levels, 2)
    if calibrated and levels != 256:
        raise ImageError(
            f"levels: {levels} given, allowed: 256 for a calibrated value, or any with calibrated=False"
        )
    pixels, low, high = finite_range("image", pixels)
    grey = _stretched(pixels, low, levels / (high - low), levels)
    side = min(grey.shape)
    log_side, log_count = [], []
    for s, greatest, least in box_extremes(grey):
        if s == 1:
            continue
        if s > side // _LARGEST_BOX:
            break
        box = np.floor(np.arange(levels) * (side / (s * levels))).astype(np.int64)
        columns = greatest.size
        count = _difference(box, greatest, least) / columns + 1.0
        log_side.append(math.log(s))
        log_count.append(math.log(count) - 2.0 * math.log(s))
    raw = -float(np.polyfit(log_side, log_count, 1)[0])
    if not calibrated:
        return DimensionEstimate(raw, math.nan, f"differential box counting, {levels} levels, raw")
    measured = Measured.load()
    dimension = measured.calibrated("box counting, raw", raw, side)
    error = measured.standard_error("box counting, calibrated", dimension, side, larger=False)
    return DimensionEstimate(dimension, error, "differential box counting, 256 levels, calibrated")


@njit(cache=True, nogil=True)
def _stretched(pixels: Any, low: float, steps_per_unit: float, levels: int) -> Any:
    """Return grey levels 0 .. levels - 1 as uint8 (rows, columns)."""
    rows, columns = pixels.shape
    grey = np.empty((rows, columns), np.uint8)
    top = np.int32(levels - 1)
    for i in range(rows):
        for j in range(columns):
            step = np.int32((np.float64(pixels[i, j]) - low) * steps_per_unit)
            grey[i, j] = min(step, top)
    return grey


@njit(cache=True, nogil=True)
def _difference(box: Any, greatest: Any, least: Any) -> int:
    total = 0
    for i in range(greatest.shape[0]):
        for j in range(greatest.shape[1]):
            total += box[greatest[i, j]] - box[least[i, j]]
    return total
