"""The largest rectangle of an image that has no missing pixel."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from hcss_twin.evaluation.checks import checked_mask


def complete_part(valid: NDArray[np.bool_]) -> tuple[slice, slice]:
    """Return rows and columns of the largest rectangle in which all pixels are valid.

    Box counts and spectra need full rectangles; this one invents no value.

    Parameters
    ----------
    valid : ndarray of bool (rows, columns)

    Returns
    -------
    tuple of slice
        Empty where no pixel is valid; the first in reading order of those equally large.
    """
    mask = checked_mask("valid", valid, np.asarray(valid).shape)
    if mask.all():
        return slice(0, mask.shape[0]), slice(0, mask.shape[1])
    top, bottom, left, right = _largest(mask)
    return slice(int(top), int(bottom)), slice(int(left), int(right))


@njit(cache=True, nogil=True)
def _largest(valid: Any) -> tuple[int, int, int, int]:
    """Find the largest rectangle below each row's histogram of valid runs, with a stack of rising heights."""
    rows, columns = valid.shape
    height = np.zeros(columns + 1, np.int64)
    start = np.zeros(columns + 1, np.int64)
    tall = np.zeros(columns + 1, np.int64)
    best, top, bottom, left, right = 0, 0, 0, 0, 0
    for i in range(rows):
        depth = 0
        for j in range(columns + 1):
            # The column after the last has height 0 and closes all that is open.
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
