"""Greatest and least grey level in boxes of 2, 4, 8, ... pixels."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray


def box_extremes(
    grey: NDArray[np.uint8], least_too: bool = True
) -> Iterator[tuple[int, NDArray[np.uint8], NDArray[np.uint8]]]:
    """Yield (side, greatest, least) for boxes of side 1, 2, 4, ... up to the shorter side of the image.

    Boxes start at the first pixel; those that would reach over the last are left out.

    Parameters
    ----------
    grey : ndarray of uint8 (rows, columns)
    least_too : bool
        False saves half the work and yields the greatest twice.
    """
    side, greatest, least = 1, grey, grey
    while True:
        yield side, greatest, least
        if min(greatest.shape) < 2:
            return
        side *= 2
        greatest = greatest_of_four(greatest)
        least = least_of_four(least) if least_too else greatest


@njit(cache=True, nogil=True)
def greatest_of_four(values: Any) -> Any:
    """Return the greatest value in boxes of 2 x 2, (rows // 2, columns // 2)."""
    rows, columns = values.shape[0] // 2, values.shape[1] // 2
    result = np.empty((rows, columns), values.dtype)
    for i in range(rows):
        for j in range(columns):
            upper = max(values[2 * i, 2 * j], values[2 * i, 2 * j + 1])
            lower = max(values[2 * i + 1, 2 * j], values[2 * i + 1, 2 * j + 1])
            result[i, j] = max(upper, lower)
    return result


@njit(cache=True, nogil=True)
def least_of_four(values: Any) -> Any:
    """Return the least value in boxes of 2 x 2, (rows // 2, columns // 2)."""
    rows, columns = values.shape[0] // 2, values.shape[1] // 2
    result = np.empty((rows, columns), values.dtype)
    for i in range(rows):
        for j in range(columns):
            upper = min(values[2 * i, 2 * j], values[2 * i, 2 * j + 1])
            lower = min(values[2 * i + 1, 2 * j], values[2 * i + 1, 2 * j + 1])
            result[i, j] = min(upper, lower)
    return result
