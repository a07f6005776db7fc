"""Checks of masks and grey levels for all measures, and the largest rectangle without missing pixels."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.kernels import kernel
from hcss_twin.providers import ImageError


def checked_mask(name: str, mask: NDArray[Any], shape: tuple[int, ...]) -> NDArray[np.bool_]:
    """Return ``mask`` as a contiguous array of bool with the given shape.

    Raises ImageError if its type or its shape differs.
    """
    array = np.asarray(mask)
    if array.dtype != np.bool_:
        raise ImageError(f"{name}: {array.dtype} given, allowed: bool")
    if array.shape != shape:
        raise ImageError(f"{name}: shape {array.shape} given, allowed: that of the image, {shape}")
    return np.ascontiguousarray(array)


def checked_levels(levels: int, fewest: int, grey: NDArray[np.uint8] | None = None) -> None:
    """Check the number of grey levels, and that all values of ``grey`` are below it.

    Raises ImageError if either check fails.
    """
    if not fewest <= levels <= 256:
        raise ImageError(
            f"levels: {levels} given, allowed: {fewest} to 256; closest is {min(max(fewest, levels), 256)}"
        )
    if grey is not None and levels < 256 and int(grey.max()) >= levels:
        raise ImageError(f"grey: level {int(grey.max())} given, allowed: 0 to {levels - 1} (levels = {levels})")


def range_within(name: str, image: NDArray[Any], mask: NDArray[np.bool_] | None) -> tuple[float, float]:
    """Return the minimum and maximum over the pixels in a mask; None selects all pixels.

    Without pixels the range is empty: (inf, -inf).

    Raises ImageError if one of these pixels is not finite.
    """
    inside = image if mask is None else image[mask]
    low, high = (float(inside.min()), float(inside.max())) if inside.size else (math.inf, -math.inf)
    if math.isnan(low) or low == -math.inf or high == math.inf:
        raise ImageError(f"{name}: a cloudy pixel is not finite, allowed: finite numbers")
    return low, high


def complete_part(valid: NDArray[np.bool_]) -> tuple[slice, slice]:
    """Return the rows and columns of the largest rectangle of valid pixels in a mask (rows, columns).

    Box counts and spectra need complete rectangles, and no missing value is filled in. The rectangle is empty if no
    pixel is valid; of several equally large ones, the first in reading order is returned.
    """
    mask = checked_mask("valid", valid, np.asarray(valid).shape)
    if mask.all():
        return slice(0, mask.shape[0]), slice(0, mask.shape[1])
    top, bottom, left, right = _largest(mask)
    return slice(int(top), int(bottom)), slice(int(left), int(right))


@kernel()
def _largest(valid: Any) -> tuple[int, int, int, int]:
    """Find the largest rectangle in each row's histogram of valid run heights, with a stack of increasing heights."""
    rows, columns = valid.shape
    height = np.zeros(columns + 1, np.int64)
    start = np.zeros(columns + 1, np.int64)
    tall = np.zeros(columns + 1, np.int64)
    best, top, bottom, left, right = 0, 0, 0, 0, 0
    for i in range(rows):
        depth = 0
        for j in range(columns + 1):
            # An extra column of height 0 closes all open rectangles.
            if j < columns:
                height[j] = height[j] + 1 if valid[i, j] else 0
            begin = j
            while depth > 0 and tall[depth - 1] >= height[j]:
                depth -= 1
                begin = start[depth]
                area = tall[depth] * (j - begin)
                if area > best:
                    best = area
                    top, bottom, left, right = i + 1 - tall[depth], i + 1, begin, j
            start[depth], tall[depth] = begin, height[j]
            depth += 1
    return top, bottom, left, right
