"""Checks of images that measures need: shape and type."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.providers import ImageError

# Images with shorter sides have too few scales for the estimators.
SMALLEST_SIDE = 32


def checked_image(name: str, image: NDArray[Any], smallest: int = SMALLEST_SIDE) -> NDArray[Any]:
    """Return ``image`` as a contiguous array (rows, columns) of float32, float64 or uint8.

    Other integers, but not booleans, become float64; values are not checked.

    Raises ImageError if it is not two-dimensional, has a side shorter than ``smallest``, or holds no real numbers.
    """
    array = np.asarray(image)
    if array.ndim != 2:
        raise ImageError(f"{name}: {array.ndim} axes given, allowed: 2 (rows, columns)")
    if min(array.shape) < smallest:
        rows, columns = array.shape
        raise ImageError(
            f"{name}: {rows} x {columns} pixels given, allowed: {smallest} or more along each axis; "
            f"closest is {max(rows, smallest)} x {max(columns, smallest)}"
        )
    if array.dtype.kind not in "fiu" or array.dtype.itemsize > 8:
        raise ImageError(f"{name}: {array.dtype} given, allowed: float32, float64 or integers")
    if array.dtype not in (np.float32, np.float64, np.uint8):
        array = array.astype(np.float64)
    return np.ascontiguousarray(array)
