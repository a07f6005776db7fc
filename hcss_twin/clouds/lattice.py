"""An infinite lattice of independent N(0, 1) numbers, the A_n of eqs 2-4 of the HCSS paper.

A node's value is a function of its indices alone: a counter-based generator, in the sense of
Salmon et al. (2011, "Parallel random numbers: as easy as 1, 2, 3"). Nothing is stored, so any
window of any frame can be asked for in any order and always has the same values.

Every row (seed, octave, t, y) owns two 64-bit keys, which enter the mixing of the column
index x at two places. With a single key, two rows whose keys coincide would be equal, and two
whose keys lie close would be shifted copies of each other; both are ruled out in practice here.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

_MASK = (1 << 64) - 1

# Weyl increment and multipliers of SplitMix64 (Steele, Lea and Flood 2014, "Fast splittable
# pseudorandom number generators", section 5); the second increment is the fraction of sqrt(2).
_INCREMENT = 0x9E3779B97F4A7C15
_SECOND_INCREMENT = 0x6A09E667F3BCC909
_MULTIPLIER_1 = 0xBF58476D1CE4E5B9
_MULTIPLIER_2 = 0x94D049BB133111EB

# Nodes mixed at a time: two work arrays of this size stay in the second-level cache.
_BLOCK = 1 << 14

_Words = NDArray[np.uint64]


def _mix(word: int) -> int:
    """Scatter one 64-bit integer (bijective)."""
    word = ((word ^ (word >> 30)) * _MULTIPLIER_1) & _MASK
    word = ((word ^ (word >> 27)) * _MULTIPLIER_2) & _MASK
    return word ^ (word >> 31)


def _mix_array(words: _Words) -> _Words:
    """Scatter 64-bit integers, element by element; array products wrap around silently."""
    words = (words ^ (words >> np.uint64(30))) * np.uint64(_MULTIPLIER_1)
    words = (words ^ (words >> np.uint64(27))) * np.uint64(_MULTIPLIER_2)
    return words ^ (words >> np.uint64(31))


def _key(increment: int, *indices: int) -> int:
    """Fold integers of any sign, taken modulo 2**64, into one 64-bit key; their order matters."""
    word = increment
    for index in indices:
        word = _mix((word + increment + (index & _MASK)) & _MASK)
    return word


def _as_words(indices: NDArray[np.int64], increment: int) -> _Words:
    return np.ascontiguousarray(indices, dtype=np.int64).view(np.uint64) * np.uint64(increment)


def unit_offset(seed: int, octave: int, axis: int) -> float:
    """Return a number in [0, 1) for one axis of one octave, by which its lattice is displaced.

    Without it all octaves would share a node at the origin, and the field would be smoother there.
    Whole cells need no offset, because octaves have different keys.
    """
    return (_key(_SECOND_INCREMENT, seed, octave, axis, -1) >> 11) * 2.0**-53


def lattice_normals(
    seed: int, octave: int, t: int, y: NDArray[np.int64], x: NDArray[np.int64]
) -> NDArray[np.float64]:
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
        Column indices of nodes.

    Returns
    -------
    ndarray of float64 (M, N)
        Values in [-8.3, 8.3]: the normal quantiles of 52-bit uniform numbers in the open unit interval.
    """
    rows = _as_words(y, _INCREMENT)
    first = _mix_array(rows + np.full(1, _key(_INCREMENT, seed, octave, t), dtype=np.uint64))
    rows = _as_words(y, _SECOND_INCREMENT)
    second = _mix_array(rows + np.full(1, _key(_SECOND_INCREMENT, seed, octave, t), dtype=np.uint64))
    columns = _as_words(x, _INCREMENT)
    values = np.empty((first.size, columns.size))
    step = max(1, _BLOCK // max(1, columns.size))
    for start in range(0, first.size, step):
        block = slice(start, start + step)
        _fill(values[block], first[block, None], second[block, None], columns)
    return values


def _fill(values: NDArray[np.float64], first: _Words, second: _Words, columns: _Words) -> None:
    """Write the normals of a block of rows into ``values`` (M, N)."""
    # The words live in the memory of the result, which saves an array and its traffic.
    words = values.view(np.uint64)
    shifted = np.empty_like(words)
    np.bitwise_xor(first, columns, out=words)
    for shift, multiplier in ((32, _MULTIPLIER_1), (29, _MULTIPLIER_2)):
        np.right_shift(words, np.uint64(shift), out=shifted)
        words ^= shifted
        words *= np.uint64(multiplier)
        if shift == 32:
            words += second
    np.right_shift(words, np.uint64(32), out=shifted)
    words ^= shifted
    # 52 bits as the mantissa of a number in [1, 2); minus 1 - 2**-53 gives the centres of 2**52
    # equal parts of the unit interval exactly, never 0 or 1.
    words >>= np.uint64(12)
    words |= np.uint64(0x3FF0000000000000)
    values -= 1.0 - 2.0**-53
    ndtri(values, out=values)
