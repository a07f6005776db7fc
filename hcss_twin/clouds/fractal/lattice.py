"""An infinite lattice of independent N(0, 1) numbers, the A_n of eqs 2-4 of the HCSS paper.

A node's value is a function of its indices alone: a counter-based generator, in the sense of
Salmon et al. (2011, "Parallel random numbers: as easy as 1, 2, 3"). Nothing need be stored, so any
window of any frame can be asked for in any order and always has the same values.

Every row (plane, y) owns a 64-bit key, whose halves enter the mixing of the column index x at two
places. With one 32-bit key two rows with the same key would be equal, and in an image of some thousand
rows and planes that happens.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from hcss_twin.clouds.fractal.normal_quantile import normals_from_bits

_MASK = (1 << 64) - 1

# Weyl increment and multipliers of SplitMix64 (Steele, Lea and Flood 2014, "Fast splittable
# pseudorandom number generators", section 5).
_INCREMENT = 0x9E3779B97F4A7C15
_MULTIPLIER_1 = 0xBF58476D1CE4E5B9
_MULTIPLIER_2 = 0x94D049BB133111EB
_OFFSET_KEY = 0x6A09E667F3BCC909  # the fraction of sqrt(2): keeps offsets apart from planes

_u4, _u8, _i8 = np.uint32, np.uint64, np.int64


def _mix(word: int) -> int:
    """Scatter one 64-bit integer (bijective)."""
    word = ((word ^ (word >> 30)) * _MULTIPLIER_1) & _MASK
    word = ((word ^ (word >> 27)) * _MULTIPLIER_2) & _MASK
    return word ^ (word >> 31)


def fold(start: int, *indices: int) -> int:
    """Fold integers of any sign, taken modulo 2**64, into one 64-bit key; their order matters."""
    word = start
    for index in indices:
        word = _mix((word + _INCREMENT + (index & _MASK)) & _MASK)
    return word


def plane_key(seed: int, octave: int, t: int, phase_y: int = 0, phase_x: int = 0) -> int:
    """Return the key of one time plane of one octave's lattice; phases tell sub-lattices apart."""
    return fold(_INCREMENT, seed, octave, t, phase_y, phase_x)


def unit_offset(seed: int, octave: int, axis: int) -> float:
    """Return a number in [0, 1) for one axis of one octave, by which its lattice is displaced.

    Without it all octaves would share a node at the origin, and the field would be smoother there.
    Whole cells need no offset, because octaves have different keys.
    """
    return (fold(_OFFSET_KEY, seed, octave, axis) >> 11) * 2.0**-53


@njit(cache=True, nogil=True, error_model="numpy")
def _row_key(plane: np.uint64, y: np.int64, x_high: np.int64) -> np.uint64:
    """Key of the columns of one row that share the upper 32 bits of their index."""
    word = plane
    for index in (y, x_high):
        word = _u8(word + _u8(_INCREMENT) + _u8(index))
        word = _u8(_u8(word ^ _u8(word >> _u8(30))) * _u8(_MULTIPLIER_1))
        word = _u8(_u8(word ^ _u8(word >> _u8(27))) * _u8(_MULTIPLIER_2))
        word = _u8(word ^ _u8(word >> _u8(31)))
    return word


@njit(cache=True, nogil=True, inline="always")
def _scatter(x: np.uint32, first: np.uint32, second: np.uint32) -> np.uint32:
    """Mix a column index between two keys.

    Multiply and xor-shift rounds; the multipliers are those of the 32-bit mixer "lowbias32" that C. Wellons
    found by search (public domain). Bare counters would leave correlations of .001 between next but one
    neighbours; the golden-ratio multiplier in front spreads them first.
    """
    h = _u4(_u4(x * _u4(0x9E3779B9)) ^ first)
    h = _u4(h ^ _u4(h >> _u4(16)))
    h = _u4(h * _u4(0x7FEB352D))
    h = _u4(h ^ _u4(h >> _u4(15)))
    h = _u4(h + second)
    h = _u4(h * _u4(0x846CA68B))
    return _u4(h ^ _u4(h >> _u4(16)))


@njit(cache=True, nogil=True, error_model="numpy")
def fill_row(
    plane: np.uint64,
    y: np.int64,
    x0: np.int64,
    values: NDArray[np.float32],
    bits: NDArray[np.uint32],
    work: NDArray[np.float32],
) -> None:
    """Write the normals of nodes x0, x0 + 1, ... of row y into ``values`` (N,); the rest is scratch (N,).

    The nodes must share the upper 32 bits of their index: true of any aligned block.
    """
    key = _row_key(plane, y, x0 >> 32)
    first, second = _u4(key), _u4(key >> _u8(32))
    low = _u4(x0)
    for i in range(values.size):
        bits[i] = _scatter(_u4(low + _u4(i)), first, second)
    normals_from_bits(bits, values, work)


@njit(cache=True, nogil=True, error_model="numpy")
def fill_scattered(
    plane: np.uint64,
    y: np.int64,
    x: NDArray[np.int64],
    values: NDArray[np.float32],
    bits: NDArray[np.uint32],
    work: NDArray[np.float32],
) -> None:
    """Write the normals of any nodes ``x`` (N,) of row y; fastest where they ascend."""
    start = 0
    while start < x.size:
        high = x[start] >> 32
        stop = x.size if (x[x.size - 1] >> 32) == high else start + 1
        while stop < x.size and (x[stop] >> 32) == high:
            stop += 1
        key = _row_key(plane, y, high)
        first, second = _u4(key), _u4(key >> _u8(32))
        for i in range(start, stop):
            bits[i] = _scatter(_u4(x[i]), first, second)
        start = stop
    normals_from_bits(bits, values, work)


@njit(cache=True, nogil=True)
def _nodes(plane: np.uint64, y: NDArray[np.int64], x: NDArray[np.int64], values: NDArray[np.float32]) -> None:
    bits = np.empty(x.size, dtype=np.uint32)
    work = np.empty(x.size, dtype=np.float32)
    for row in range(y.size):
        fill_scattered(plane, y[row], x, values[row], bits, work)


def lattice_normals(
    seed: int, octave: int, t: int, y: NDArray[np.int64], x: NDArray[np.int64]
) -> NDArray[np.float32]:
    """Return independent standard normal numbers on nodes ``y`` x ``x`` of one octave and one time plane.

    Parameters
    ----------
    seed : int
        Seed of the realisation, of any sign, modulo 2**64.
    octave : int
        Octave number k.
    t : int
        Index of the time plane.
    y : ndarray of int64 (M,)
        Row indices of nodes, of any sign, in any order.
    x : ndarray of int64 (N,)
        Column indices of nodes, of any sign, in ascending order.

    Returns
    -------
    ndarray of float32 (M, N)
        Values in [-6.4, 6.4].
    """
    values = np.empty((y.size, x.size), dtype=np.float32)
    key: Any = np.uint64(plane_key(seed, octave, t))
    _nodes(key, np.asarray(y, dtype=np.int64), np.asarray(x, dtype=np.int64), values)
    return values
