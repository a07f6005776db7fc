"""An infinite lattice of independent N(0, 1) numbers: the A_n of eqs 2-4 of the HCSS paper.

The value of a node is a function of its indices alone: a counter-based generator (Salmon et al. 2011, "Parallel random
numbers: as easy as 1, 2, 3"). Nothing needs to be stored: any window of any frame can be computed in any order and
always has the same values. Every row (plane, y) has a 64-bit key, whose halves enter the mixing of the column index x
at two points. With a 32-bit key, some of the many thousand rows of an image sequence would have equal keys and thus
equal values.

A rational function of w = -log2(q (2 - q)), with q the two-sided tail probability, converts 32 random bits to a normal
number. It uses w because q (2 - q) follows from an integer without cancellation. The coefficients are our own minimax
fit to scipy's ``ndtri``; the error, including single precision, is below 4e-6 out to 6.3 sigma, the largest value for
32 bits. Only integer arithmetic and single-precision additions, multiplications and divisions are used, no library
functions, so that results are bit-identical on every machine with IEEE arithmetic.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.kernels import inner, kernel

_f4, _u4, _u8, _i4 = np.float32, np.uint32, np.uint64, np.int32

_MASK = (1 << 64) - 1

# Weyl increment and multipliers of SplitMix64 (Steele, Lea and Flood 2014, "Fast splittable
# pseudorandom number generators", section 5).
_INCREMENT = 0x9E3779B97F4A7C15
_MULTIPLIER_1 = 0xBF58476D1CE4E5B9
_MULTIPLIER_2 = 0x94D049BB133111EB
_OFFSET_KEY = 0x6A09E667F3BCC909  # the fraction of sqrt(2): gives different random numbers than for planes


@kernel(error_model="numpy")
def normals_from_bits(bits: NDArray[np.uint32], values: NDArray[np.float32], work: NDArray[np.float32]) -> None:
    """Convert ``bits`` (N,) to normals in ``values`` (N,): the top bit is the sign, the others the tail.

    ``bits`` is overwritten, ``work`` (N,) is scratch. Each of the three passes is a loop without branches, which the
    compiler vectorises.
    """
    word = bits.view(np.int32)
    mantissa = bits.view(np.float32)
    for i in range(values.size):
        b = bits[i]
        tail = (_f4(_i4(b & _u4(0x7FFFFFFF))) + _f4(0.5)) * _f4(2.0**-31)
        centre = _f4(1.0) - tail
        values[i] = centre if (b >> _u4(31)) else -centre
        mantissa[i] = tail * (_f4(2.0) - tail)
    for i in range(values.size):
        b = word[i]
        work[i] = _f4(_i4(b >> _i4(23)) - _i4(127))
        word[i] = _i4(_i4(b & _i4(0x007FFFFF)) | _i4(0x3F800000))
    for i in range(values.size):
        f = mantissa[i] - _f4(1.0)
        log2 = f * (
            _f4(1.4426678304088603)
            + f
            * (
                _f4(-0.7205855071753365)
                + f
                * (
                    _f4(0.47355374719923404)
                    + f
                    * (
                        _f4(-0.32590321959526836)
                        + f
                        * (_f4(0.19429655035741816) + f * (_f4(-0.07955963174421746) + f * _f4(0.01553053798143947)))
                    )
                )
            )
        )
        w = -(work[i] + log2)
        numerator = _f4(1.2533166532967277) + w * (
            _f4(0.32257528383021544)
            + w
            * (
                _f4(0.04525483196036601)
                + w * (_f4(0.004227794041041876) + w * (_f4(0.00025916224221735767) + w * _f4(4.730195932861998e-06)))
            )
        )
        denominator = _f4(1.0) + w * (
            _f4(0.07592430388009565)
            + w
            * (
                _f4(0.016049161088968332)
                + w * (_f4(0.0008777230899449003) + w * (_f4(4.136659648561449e-05) + w * _f4(1.5758790341659842e-07)))
            )
        )
        values[i] = values[i] * numerator / denominator


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


@lru_cache(maxsize=4096)  # a frame has up to 80 planes, most of which the next frames share
def plane_key(seed: int, octave: int, t: int, phase_y: int = 0, phase_x: int = 0) -> int:
    """Return the key of one time plane of one octave's lattice; phases number sub-lattices."""
    return fold(_INCREMENT, seed, octave, t, phase_y, phase_x)


@lru_cache(maxsize=4096)
def unit_offset(seed: int, octave: int, axis: int) -> float:
    """Return the offset in [0, 1) cells of one octave's lattice along one axis.

    Without offsets all octaves would share a node at the origin, and the field would be smoother there. Offsets by
    whole cells are unnecessary, because octaves have different keys.
    """
    return (fold(_OFFSET_KEY, seed, octave, axis) >> 11) * 2.0**-53


@inner(error_model="numpy")
def _row_key(plane: np.uint64, y: np.int64, x_high: np.int64) -> np.uint64:
    """Return the key of the columns of one row that share the upper 32 bits of their index."""
    word = plane
    for index in (y, x_high):
        word = _u8(word + _u8(_INCREMENT) + _u8(index))
        word = _u8(_u8(word ^ _u8(word >> _u8(30))) * _u8(_MULTIPLIER_1))
        word = _u8(_u8(word ^ _u8(word >> _u8(27))) * _u8(_MULTIPLIER_2))
        word = _u8(word ^ _u8(word >> _u8(31)))
    return word


@inner(inline="always")
def _scatter(x: np.uint32, first: np.uint32, second: np.uint32) -> np.uint32:
    """Mix a column index between two keys, by multiply and xor-shift rounds.

    The multipliers are those of the 32-bit mixer "lowbias32" of C. Wellons (public domain). Plain counters would leave
    correlations of 0.001 between second neighbours; the initial golden-ratio multiplier spreads them.
    """
    h = _u4(_u4(x * _u4(0x9E3779B9)) ^ first)
    h = _u4(h ^ _u4(h >> _u4(16)))
    h = _u4(h * _u4(0x7FEB352D))
    h = _u4(h ^ _u4(h >> _u4(15)))
    h = _u4(h + second)
    h = _u4(h * _u4(0x846CA68B))
    return _u4(h ^ _u4(h >> _u4(16)))


@kernel(error_model="numpy")
def fill_row(
    plane: np.uint64,
    y: np.int64,
    x0: np.int64,
    values: NDArray[np.float32],
    bits: NDArray[np.uint32],
    work: NDArray[np.float32],
) -> None:
    """Write the normals of nodes x0, x0 + 1, ... of row y into ``values`` (N,); other arrays are scratch (N,).

    The nodes must share the upper 32 bits of their index, as in an aligned block.
    """
    key = _row_key(plane, y, x0 >> 32)
    first, second = _u4(key), _u4(key >> _u8(32))
    low = _u4(x0)
    for i in range(values.size):
        bits[i] = _scatter(_u4(low + _u4(i)), first, second)
    normals_from_bits(bits, values, work)


@inner(error_model="numpy")
def fill_scattered(
    plane: np.uint64,
    y: np.int64,
    x: NDArray[np.int64],
    values: NDArray[np.float32],
    bits: NDArray[np.uint32],
    work: NDArray[np.float32],
) -> None:
    """Write the normals of any nodes ``x`` (N,) of row y; fastest if they ascend. Scratch as in :func:`fill_row`."""
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


@kernel()
def _nodes(plane: np.uint64, y: NDArray[np.int64], x: NDArray[np.int64], values: NDArray[np.float32]) -> None:
    bits = np.empty(x.size, dtype=np.uint32)
    work = np.empty(x.size, dtype=np.float32)
    for row in range(y.size):
        fill_scattered(plane, y[row], x, values[row], bits, work)


def lattice_normals(seed: int, octave: int, t: int, y: NDArray[np.int64], x: NDArray[np.int64]) -> NDArray[np.float32]:
    """Return the normals (M, N), within +-6.4, of one octave and time plane on nodes ``y`` (M,) x ``x`` (N,).

    Indices and seed may have any sign and are taken modulo 2**64; ``x`` ascends.
    """
    values = np.empty((y.size, x.size), dtype=np.float32)
    key: Any = np.uint64(plane_key(seed, octave, t))
    _nodes(key, np.asarray(y, dtype=np.int64), np.asarray(x, dtype=np.int64), values)
    return values
