"""Random numbers of detectors by their place in the image, so that windows have those of the whole."""

from __future__ import annotations

from typing import Any

import numpy as np

from hcss_twin.core.kernels import kernel
from hcss_twin.providers import Array


@kernel()
def _mixed(state: Any) -> Any:
    """Finaliser of splitmix64 (Steele et al., OOPSLA 2014)."""
    state = np.uint64((state ^ (state >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9))
    state = np.uint64((state ^ (state >> np.uint64(27))) * np.uint64(0x94D049BB133111EB))
    return np.uint64(state ^ (state >> np.uint64(31)))


@kernel()
def row_key(key: Any, row: Any) -> Any:
    """Return the key of a row of the image, which may be negative."""
    return _mixed(np.uint64(key + np.uint64(np.uint64(row) * np.uint64(0xD1B54A32D192ED03))))


@kernel()
def pixel_key(row_key: Any, column: Any) -> Any:
    """Return the key of a pixel of a row."""
    return _mixed(np.uint64(row_key + np.uint64(np.uint64(column) * np.uint64(0xDB4F0B9175AE2165))))


@kernel()
def _fill(numbers: Any, key: Any, first_row: Any, first_column: Any) -> None:
    for y in range(numbers.shape[0]):
        key_of_row = row_key(key, np.int64(first_row + y))
        for x in range(numbers.shape[1]):
            bits = pixel_key(key_of_row, np.int64(first_column + x)) >> np.uint64(12)
            numbers[y, x] = (float(bits) + 0.5) * 2.0**-52


def uniform(key: int, shape: tuple[int, int], corner: tuple[int, int]) -> Array:
    """Return numbers (Y, X) between 0 and 1, both excluded, of the pixels from ``corner`` on."""
    numbers = np.empty(shape)
    _fill(numbers, np.uint64(key), np.int64(corner[0]), np.int64(corner[1]))
    return numbers
