"""Box counting of the body under a grey-level surface: what the FD of the HCSS paper is compared with."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from hcss_twin.errors import ImageError
from hcss_twin.evaluation.checks import checked_image, checked_levels
from hcss_twin.evaluation.fractal_dimension.box_maxima import box_extremes
from hcss_twin.evaluation.fractal_dimension.estimate import DimensionEstimate


def body_dimension(grey: NDArray[np.uint8], levels: int = 256) -> DimensionEstimate:
    """Count the boxes that cover the body between level 0 and the grey-level surface.

    Columns of s x s pixels are cut into boxes that are h = s levels / M high, with M the shorter
    side; the body takes ceil(max / h) of them, none where all is clear (level 0). The dimension is
    the slope of the logarithm of their number per area against log(1 / s), s = 2, 4, 8, ... up to
    M / 2.

    This is eq 6 of the HCSS paper with the cloud itself as the measured object. The dimension of a
    solid is 3 and that of a thin sheet 2, so that this measures how cloud fills the image: it grows
    with coverage, and says little about the roughness of the cloud tops, for which there is
    ``variogram_dimension``. Of the countings tried it is the one that gives the printed FD
    (docs/fractal-dimension.md).

    Parameters
    ----------
    grey : ndarray of uint8 (rows, columns)
        At least 32 x 32 pixels, levels below ``levels``, 0 where clear.
    levels : int
        Grey levels, 2 to 256.

    Returns
    -------
    DimensionEstimate
        The error is NaN: no surface has a known dimension of this kind.

    Raises
    ------
    ImageError
        If the image is too small, of another type, or clear throughout, or a level is too high.
    """
    image = checked_image("grey", grey)
    if image.dtype != np.uint8:
        raise ImageError(f"grey: {image.dtype} given, allowed: uint8, see to_grey_levels")
    checked_levels(levels, 2, image)
    side = min(image.shape)
    log_side, log_count = [], []
    for s, greatest, _ in box_extremes(image, least_too=False):
        if s == 1:
            continue
        if s > side // 2:
            break
        boxes = np.ceil(np.arange(levels) * (side / (s * levels))).astype(np.int64)
        total = _sum(boxes, greatest)
        if total == 0:
            raise ImageError(
                f"grey: clear in all whole boxes of {s} x {s} pixels, allowed: cloud (a level above 0) there"
            )
        log_side.append(math.log(s))
        log_count.append(math.log(total / greatest.size) - 2.0 * math.log(s))
    slope = float(np.polyfit(log_side, log_count, 1)[0])
    return DimensionEstimate(-slope, math.nan, f"box counting of the body, {levels} levels")


@njit(cache=True, nogil=True)
def _sum(boxes: Any, greatest: Any) -> int:
    total = 0
    for i in range(greatest.shape[0]):
        for j in range(greatest.shape[1]):
            total += boxes[greatest[i, j]]
    return total
