"""Poisson numbers of which each depends on its own pixel alone.

The generators of numpy draw as many random numbers as they happen to need, so that one brighter pixel changes all that
come after it.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from hcss_twin.sensor.random_numbers import pixel_key, row_key, uniform

Array = NDArray[np.float64]

_SMALL = 10.0
"""Mean from which transformed rejection holds; below, uniform numbers are multiplied."""


def poisson(mean: Array, key: int, corner: tuple[int, int] = (0, 0)) -> Array:
    """Return Poisson numbers with means ``mean`` (Y, X), 0 to 1e12, as float64, of the same shape.

    Means from 10 on by transformed rejection (W. Hoermann, Insurance: Mathematics and Economics 12, 39 (1993),
    algorithm PTRS), smaller ones by multiplying uniform numbers until the product falls below exp(-mean). Uniform
    numbers are hashes of key, row, column and number of the draw.

    Parameters
    ----------
    corner : (int, int)
        Row and column of the first pixel in the image.
    """
    drawn: Array = np.empty(mean.shape)
    _fill(
        drawn,
        np.ascontiguousarray(mean, dtype=np.float64),
        np.uint64(key),
        np.int64(corner[0]),
        np.int64(corner[1]),
    )
    return drawn


@njit(cache=True, nogil=True)
def _fill(drawn: Array, mean: Array, key: Any, first_row: Any, first_column: Any) -> None:
    for y in range(mean.shape[0]):
        of_row = row_key(key, np.int64(first_row + y))
        for x in range(mean.shape[1]):
            of_pixel = pixel_key(of_row, np.int64(first_column + x))
            if mean[y, x] <= 0.0:
                drawn[y, x] = 0.0
            elif mean[y, x] < _SMALL:
                drawn[y, x] = _multiplied(mean[y, x], of_pixel)
            else:
                drawn[y, x] = _rejected(mean[y, x], of_pixel)


@njit(cache=True, nogil=True)
def _multiplied(mean: float, key: Any) -> float:
    least, product, count = math.exp(-mean), 1.0, -1
    while product > least or count < 0:
        count += 1
        product *= uniform(key, count)
    return float(count)


@njit(cache=True, nogil=True)
def _rejected(mean: float, key: Any) -> float:
    log_mean = math.log(mean)
    b = 0.931 + 2.53 * math.sqrt(mean)
    a = -0.059 + 0.02483 * b
    inverse_alpha = 1.1239 + 1.1328 / (b - 3.4)
    squeeze = 0.9277 - 3.6224 / (b - 2.0)
    draw = 0
    while True:
        u, v = uniform(key, draw) - 0.5, uniform(key, draw + 1)
        draw += 2
        us = 0.5 - abs(u)
        k = math.floor((2.0 * a / us + b) * u + mean + 0.43)
        if us >= 0.07 and v <= squeeze:
            return float(k)
        if k < 0 or (us < 0.013 and v > us):
            continue
        log_accepted = math.log(v * inverse_alpha / (a / (us * us) + b))
        if log_accepted <= k * log_mean - mean - math.lgamma(k + 1.0):
            return float(k)
