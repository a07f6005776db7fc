"""Random numbers that depend on what they are for and on their pixel, and not on what was drawn before.

Poisson numbers of which each depends on its own pixel alone.

The generators of numpy draw as many random numbers as they happen to need, so that one brighter pixel changes all that
come after it.
"""

from __future__ import annotations

import hashlib
import math
from typing import Any

import numpy as np
from numba import njit
from scipy.special import ndtri

from hcss_twin.core.arrays import Array


def key_of(seed: int, stage: str, band: str, frame: int = 0) -> int:
    """Return the key, 64 bits, of the random numbers of one stage, band and frame.

    Parameters
    ----------
    seed : int
        0 or more.
    stage, band : str
        What draws, and for which band.
    frame : int
        Number of the frame, 0 or more; 0 for what stays the same in all frames.
    """
    digest = hashlib.sha256(f"{stage}/{band}".encode()).digest()
    words = [int.from_bytes(digest[start : start + 4], "little") for start in (0, 4, 8)]
    sequence = np.random.SeedSequence(seed, spawn_key=(*words, frame))
    return int(sequence.generate_state(1, np.uint64)[0])


def standard_normal(key: int, shape: tuple[int, int], corner: tuple[int, int]) -> Array:
    """Return Gaussian numbers (Y, X) of mean 0 and deviation 1.

    Quantiles of uniform numbers, which are hashes of key, row and column: part of an image has those of the whole.

    Parameters
    ----------
    key : int
        As :func:`key_of` returns.
    shape : (int, int)
        Rows and columns.
    corner : (int, int)
        Row and column of the first pixel in the image; may be negative.
    """
    uniform = np.empty(shape)
    _fill(uniform, np.uint64(key), np.int64(corner[0]), np.int64(corner[1]))
    drawn: Array = ndtri(uniform, out=uniform)
    return drawn


@njit(cache=True, nogil=True)
def mixed(state: Any) -> Any:
    """Finaliser of splitmix64 (Steele et al., OOPSLA 2014)."""
    state = np.uint64((state ^ (state >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9))
    state = np.uint64((state ^ (state >> np.uint64(27))) * np.uint64(0x94D049BB133111EB))
    return np.uint64(state ^ (state >> np.uint64(31)))


@njit(cache=True, nogil=True)
def row_key(key: Any, row: Any) -> Any:
    """Return the key of a row (int64) of the image."""
    return mixed(np.uint64(key + np.uint64(np.uint64(row) * np.uint64(0xD1B54A32D192ED03))))


@njit(cache=True, nogil=True)
def pixel_key(key: Any, column: Any) -> Any:
    """Return the key of the pixel in a column (int64) of the row with this key."""
    return mixed(np.uint64(key + np.uint64(np.uint64(column) * np.uint64(0xDB4F0B9175AE2165))))


@njit(cache=True, nogil=True)
def uniform(key: Any, draw: Any) -> float:
    """Return a number within 0 and 1, both excluded: the draw, from 0, of the pixel with this key."""
    step = np.uint64(np.uint64(draw + 1) * np.uint64(0x9E3779B97F4A7C15))
    # 52 bits: with one more, half a step could be rounded away, and 1 returned
    bits = mixed(np.uint64(key + step)) >> np.uint64(12)
    return (float(bits) + 0.5) * 2.0**-52


@njit(cache=True, nogil=True)
def _fill(drawn: Array, key: Any, first_row: Any, first_column: Any) -> None:
    for y in range(drawn.shape[0]):
        of_row = row_key(key, np.int64(first_row + y))
        for x in range(drawn.shape[1]):
            drawn[y, x] = uniform(pixel_key(of_row, np.int64(first_column + x)), 0)


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
    _fill_of_poisson(
        drawn, np.ascontiguousarray(mean, dtype=np.float64), np.uint64(key), np.int64(corner[0]), np.int64(corner[1])
    )
    return drawn


@njit(cache=True, nogil=True)
def _fill_of_poisson(drawn: Array, mean: Array, key: Any, first_row: Any, first_column: Any) -> None:
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
