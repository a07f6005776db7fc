"""Random numbers that depend on what they are for and on their pixel, and not on what was drawn before."""

from __future__ import annotations

import hashlib
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.special import ndtri

Array = NDArray[np.float64]


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
