"""Poisson numbers of which each depends on its own pixel alone.

The generators of numpy draw as many random numbers as they happen to need, so that one brighter pixel changes all that
come after it.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]

_SMALL = 10.0
"""Mean from which transformed rejection holds; below, uniform numbers are multiplied."""


def poisson(mean: Array, key: int) -> Array:
    """Return Poisson numbers with means ``mean`` (any shape, 0 to 1e12) as float64, of the same shape.

    Means from 10 on by transformed rejection (W. Hoermann, Insurance: Mathematics and Economics 12, 39 (1993),
    algorithm PTRS), smaller ones by multiplying uniform numbers until the product falls below exp(-mean). Uniform
    numbers are hashes of key, index of the pixel and number of the draw.
    """
    drawn: Array = np.empty(mean.size)
    _fill(drawn, np.ascontiguousarray(mean, dtype=np.float64).ravel(), np.uint64(key))
    return drawn.reshape(mean.shape)


@njit(cache=True, nogil=True)
def _mixed(state: np.uint64) -> np.uint64:
    """Finaliser of splitmix64 (Steele et al., OOPSLA 2014)."""
    state = np.uint64((state ^ (state >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9))
    state = np.uint64((state ^ (state >> np.uint64(27))) * np.uint64(0x94D049BB133111EB))
    return np.uint64(state ^ (state >> np.uint64(31)))


@njit(cache=True, nogil=True)
def _uniform(pixel_key: np.uint64, draw: int) -> float:
    """Return a number within 0 and 1, both excluded."""
    step = np.uint64(np.uint64(draw + 1) * np.uint64(0x9E3779B97F4A7C15))
    bits = _mixed(np.uint64(pixel_key + step)) >> np.uint64(11)
    return (float(bits) + 0.5) * 2.0**-53


@njit(cache=True, nogil=True)
def _fill(drawn: Array, mean: Array, key: np.uint64) -> None:
    for pixel in range(mean.size):
        step = np.uint64(np.uint64(pixel + 1) * np.uint64(0xD1B54A32D192ED03))
        pixel_key = _mixed(np.uint64(key + step))
        if mean[pixel] <= 0.0:
            drawn[pixel] = 0.0
        elif mean[pixel] < _SMALL:
            drawn[pixel] = _multiplied(mean[pixel], pixel_key)
        else:
            drawn[pixel] = _rejected(mean[pixel], pixel_key)


@njit(cache=True, nogil=True)
def _multiplied(mean: float, pixel_key: np.uint64) -> float:
    least, product, count = math.exp(-mean), 1.0, -1
    while product > least or count < 0:
        count += 1
        product *= _uniform(pixel_key, count)
    return float(count)


@njit(cache=True, nogil=True)
def _rejected(mean: float, pixel_key: np.uint64) -> float:
    log_mean = math.log(mean)
    b = 0.931 + 2.53 * math.sqrt(mean)
    a = -0.059 + 0.02483 * b
    inverse_alpha = 1.1239 + 1.1328 / (b - 3.4)
    squeeze = 0.9277 - 3.6224 / (b - 2.0)
    draw = 0
    while True:
        u, v = _uniform(pixel_key, draw) - 0.5, _uniform(pixel_key, draw + 1)
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
