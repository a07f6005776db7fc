"""Fractal dimension by box counting of a grey-level surface, of the body below it, and of a mask boundary."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_evaluate.measures.checks import checked_levels, checked_mask
from hcss_evaluate.measures.fractal_dimension import DimensionEstimate, estimator_calibration
from hcss_evaluate.measures.images import SMALLEST_SIDE, checked_image
from hcss_twin.providers import ImageError
from hcss_twin.reports.power_spectrum import Rings


def box_extremes(
    grey: NDArray[np.uint8], least_too: bool = True
) -> Iterator[tuple[int, NDArray[np.uint8], NDArray[np.uint8]]]:
    """Yield (side, maxima, minima) for boxes of side 1, 2, 4, ... up to the shorter side of an image (rows, columns).

    Boxes start at the first pixel; incomplete boxes at the end are excluded. Without ``least_too`` the maxima replace
    the minima, which halves the work.
    """
    side, greatest, least = 1, grey, grey
    while True:
        yield side, greatest, least
        if min(greatest.shape) < 2:
            return
        side *= 2
        greatest = _of_four(np.maximum, greatest)
        least = _of_four(np.minimum, least) if least_too else greatest


def _of_four(extreme: np.ufunc, values: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return the extreme value of each 2 x 2 box, (rows // 2, columns // 2)."""
    rows, columns = (size - size % 2 for size in values.shape)
    upper = extreme(values[:rows:2, :columns:2], values[:rows:2, 1:columns:2])
    lower = extreme(values[1:rows:2, :columns:2], values[1:rows:2, 1:columns:2])
    return np.asarray(extreme(upper, lower))


def body_dimension(grey: NDArray[np.uint8], levels: int = 256) -> DimensionEstimate:
    """Count the boxes that cover the body between level 0 and the grey-level surface.

    Columns of s x s pixels are divided into boxes of height h = s levels / M, where M is the shorter side; the body
    occupies ceil(max / h) of them, none if all pixels are clear (level 0). The dimension is the slope of the logarithm
    of their number per area against log(1 / s), s = 2, 4, 8, ... up to M / 2.

    This is eq 6 of the HCSS paper applied to the cloud body. A solid has dimension 3 and a thin sheet 2, so the result
    measures how much of the image the cloud fills: it grows with coverage and depends little on the roughness of the
    cloud tops, which ``variogram_dimension`` measures. Of the variants tested, this one reproduces the printed FD
    (docs/development/fractal-dimension.md). The error is NaN, because no test surface has a known body dimension.

    ``grey`` (rows, columns), at least 32 x 32, has levels below ``levels``, 2 to 256, and 0 where clear. Raises
    ImageError if the image is too small, of another type, or clear throughout, or a level is too high.
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
        total = int(boxes[greatest].sum())
        if total == 0:
            raise ImageError(
                f"grey: clear in all whole boxes of {s} x {s} pixels, allowed: cloud (a level above 0) there"
            )
        log_side.append(math.log(s))
        log_count.append(math.log(total / greatest.size) - 2.0 * math.log(s))
    slope = float(np.polyfit(log_side, log_count, 1)[0])
    return DimensionEstimate(-slope, math.nan, f"box counting of the body, {levels} levels")


# Ratio of the shorter side to the largest box.
_LARGEST_BOUNDARY_BOX = 4


def boundary_boxes(mask: NDArray[np.bool_]) -> list[tuple[float, int]]:
    """Return mean side and number of the boxes that contain part of the boundary of a mask (rows, columns).

    Boxes of about 2, 4, 8, ... pixels, up to a quarter of the shorter side, tile the image evenly.
    """
    rows, columns = mask.shape[0] - 1, mask.shape[1] - 1
    first = mask[:-1, :-1]
    corners = (first != mask[:-1, 1:]) | (first != mask[1:, :-1]) | (first != mask[1:, 1:])
    row, column = np.nonzero(corners)
    found: list[tuple[float, int]] = []
    s = 2
    while s <= min(mask.shape) // _LARGEST_BOUNDARY_BOX:
        down, across = round(rows / s), round(columns / s)
        box = np.zeros(down * across, dtype=np.bool_)
        box[(row * down // rows) * across + column * across // columns] = True
        found.append((math.sqrt(rows / down * columns / across), int(np.count_nonzero(box))))
        s *= 2
    return found


def boundary_dimension(mask: NDArray[np.bool_]) -> DimensionEstimate:
    """Count the boxes that contain part of the boundary between cloudy and clear pixels.

    The boundary is the set of pixel corners where the four adjacent pixels are not all equal; it excludes the image
    edge, and a mask and its complement have the same boundary. The dimension is the slope of log N(s) against log(1 /
    s), s about 2, 4, 8, ... up to a quarter of the shorter side; the boxes of each size tile the image evenly. The
    level sets of a self-affine surface with Hurst exponent H have dimension 2 - H, to which the estimate converges
    slowly (for the bias see docs/development/fractal-dimension.md). The error applies to half-cloudy masks of
    fractional Brownian surfaces.

    The mask (rows, columns) has at least 32 x 32 pixels and is true where cloudy. Raises ImageError if it is too small,
    of another type, or uniform.
    """
    cloudy = _checked(mask)
    found = boundary_boxes(cloudy)
    if not found[0][1]:
        raise ImageError(f"mask: {'cloudy' if cloudy[0, 0] else 'clear'} everywhere, allowed: both, for a boundary")
    log_side, log_count = np.log(found).T
    dimension = -float(np.polyfit(log_side, log_count, 1)[0])
    # The table uses the dimension of the surface, which is greater by one.
    error = estimator_calibration().standard_error("boundary", dimension + 1.0, min(cloudy.shape))
    return DimensionEstimate(dimension, error, "box counting of the boundary")


def _checked(mask: Any) -> NDArray[np.bool_]:
    array = np.asarray(mask)
    cloudy = checked_mask("mask", array, array.shape)
    if cloudy.ndim != 2 or min(cloudy.shape) < SMALLEST_SIDE:
        raise ImageError(f"mask: shape {cloudy.shape} given, allowed: (rows, columns) of {SMALLEST_SIDE} or more each")
    return cloudy


# Ratio of the shorter side to the largest box; larger boxes are few and only add scatter.
_LARGEST_SURFACE_BOX = 8

# Smaller images have only two box sizes.
_SMALLEST_SURE = 64


def box_counting_dimension(image: NDArray[Any], levels: int = 256, calibrated: bool = True) -> DimensionEstimate:
    """Count the boxes that contain part of the grey-level surface.

    The image is stretched to ``levels`` grey levels. Columns of s x s pixels are divided into boxes of height h = s
    levels / M, where M is the shorter side; in each column the surface occupies floor(max / h) - floor(min / h) + 1
    boxes. The raw dimension is the slope of the logarithm of their number per area against log(1 / s), s = 2, 4, 8, ...
    up to M / 8 (N. Sarkar and B. B. Chaudhuri, "An efficient differential box-counting approach to compute fractal
    dimension of image", IEEE Trans. Syst. Man Cybern. 24, 115-120, 1994, who let s run to M / 2).

    The raw value is too small by .1 to .9, because neighbouring columns share no pixel and rough surfaces fill all
    boxes. The calibrated value is the D of exact fractional Brownian surfaces of this size with the same mean raw value
    (docs/development/fractal-dimension.md); it exists for 256 levels only. The error is NaN for raw values, for images
    larger than those of the calibration, and below 64 pixels, where only two box sizes exist and the calibration is
    nearly flat.

    The image (rows, columns) has at least 32 x 32 pixels of float32, float64 or integers, any unit. Raises ImageError
    if it is too small, constant or not finite, or if ``levels`` is not 2 to 256, or not 256 for a calibrated value.
    """
    pixels = checked_image("image", image)
    checked_levels(levels, 2)
    if calibrated and levels != 256:
        raise ImageError(f"levels: {levels} given, allowed: 256 for a calibrated value, or any with calibrated=False")
    pixels, low, high = Rings.finite_range("image", pixels)
    steps = ((pixels.astype(np.float64) - low) * (levels / (high - low))).astype(np.int32)
    grey = np.minimum(steps, levels - 1).astype(np.uint8)
    side = min(grey.shape)
    log_side, log_count = [], []
    for s, greatest, least in box_extremes(grey):
        if s == 1:
            continue
        if s > side // _LARGEST_SURFACE_BOX:
            break
        box = np.floor(np.arange(levels) * (side / (s * levels))).astype(np.int64)
        columns = greatest.size
        count = int((box[greatest] - box[least]).sum()) / columns + 1.0
        log_side.append(math.log(s))
        log_count.append(math.log(count) - 2.0 * math.log(s))
    raw = -float(np.polyfit(log_side, log_count, 1)[0])
    if not calibrated:
        return DimensionEstimate(raw, math.nan, f"differential box counting, {levels} levels, raw")
    measured = estimator_calibration()
    dimension = measured.calibrated("box counting, raw", raw, side)
    error = math.nan
    if side >= _SMALLEST_SURE:
        error = measured.standard_error("box counting, calibrated", dimension, side, larger=False)
    return DimensionEstimate(dimension, error, "differential box counting, 256 levels, calibrated")
