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

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.kernels import kernel

_f4, _u4, _u8, _i4 = np.float32, np.uint32, np.uint64, np.int32

_MASK = (1 << 64) - 1

# Weyl increment and multipliers of SplitMix64 (Steele, Lea and Flood 2014, "Fast splittable
# pseudorandom number generators", section 5).
_INCREMENT = 0x9E3779B97F4A7C15
_MULTIPLIER_1 = 0xBF58476D1CE4E5B9
_MULTIPLIER_2 = 0x94D049BB133111EB
_OFFSET_KEY = 0x6A09E667F3BCC909  # the fraction of sqrt(2): gives different random numbers than for planes


@kernel(inner=True, forceinline=True)
def _normal(bits: np.uint32) -> np.float32:
    """Convert 32 bits to a normal number: the top bit is the sign, the others the tail. No branches, no memory."""
    tail = (_f4(_i4(bits & _u4(0x7FFFFFFF))) + _f4(0.5)) * _f4(2.0**-31)
    centre = _f4(1.0) - tail
    word = _f4(tail * (_f4(2.0) - tail)).view(np.int32)
    f = _i4(_i4(word & _i4(0x007FFFFF)) | _i4(0x3F800000)).view(np.float32) - _f4(1.0)
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
                    + f * (_f4(0.19429655035741816) + f * (_f4(-0.07955963174421746) + f * _f4(0.01553053798143947)))
                )
            )
        )
    )
    w = -(_f4(_i4(word >> _i4(23)) - _i4(127)) + log2)
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
    return (centre if (bits >> _u4(31)) else -centre) * numerator / denominator


@kernel()
def normals_from_bits(bits: NDArray[np.uint32], values: NDArray[np.float32]) -> None:
    """Convert ``bits`` (N,) to normals in ``values`` (N,)."""
    for i in range(values.size):
        values[i] = _normal(bits[i])


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


@kernel(inner=True)
def _row_key(plane: np.uint64, y: np.int64, x_high: np.int64) -> np.uint64:
    """Return the key of the columns of one row that share the upper 32 bits of their index."""
    word = plane
    for index in (y, x_high):
        word = _u8(word + _u8(_INCREMENT) + _u8(index))
        word = _u8(_u8(word ^ _u8(word >> _u8(30))) * _u8(_MULTIPLIER_1))
        word = _u8(_u8(word ^ _u8(word >> _u8(27))) * _u8(_MULTIPLIER_2))
        word = _u8(word ^ _u8(word >> _u8(31)))
    return word


@kernel(inner=True, forceinline=True)
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


@kernel()
def fill_row(
    plane: np.uint64, y: np.int64, x0: np.int64, values: NDArray[np.float32], bits: NDArray[np.uint32]
) -> None:
    """Write the normals of nodes x0, x0 + 1, ... of row y into ``values`` (N,); ``bits`` (N,) is scratch.

    The nodes must share the upper 32 bits of their index, as in an aligned block.
    """
    key = _row_key(plane, y, x0 >> 32)
    first, second = _u4(key), _u4(key >> _u8(32))
    low = _u4(x0)
    for i in range(values.size):
        bits[i] = _scatter(_u4(low + _u4(i)), first, second)
    normals_from_bits(bits, values)


@kernel(inner=True)
def blend_scattered(
    planes: NDArray[np.uint64],
    weights: NDArray[np.float32],
    y: np.int64,
    x: NDArray[np.int64],
    line: NDArray[np.float32],
    scratch: NDArray[np.uint32],
) -> None:
    """Write the weighted sum of 1 or 4 ``planes`` at any ascending nodes ``x`` (N,) of row y into ``line`` (N,)."""
    for i in range(x.size):  # loops over 64-bit indices would take half as many numbers at once
        scratch[i] = _u4(x[i])
    keys = np.empty(planes.size, dtype=np.uint64)
    start = 0
    while start < x.size:
        high = x[start] >> 32
        stop = x.size if (x[x.size - 1] >> 32) == high else start + 1
        while stop < x.size and (x[stop] >> 32) == high:
            stop += 1
        for p in range(planes.size):
            keys[p] = _row_key(planes[p], y, high)
        a0, b0, w0 = _u4(keys[0]), _u4(keys[0] >> _u8(32)), weights[0]
        nodes, part = scratch[start:stop], line[start:stop]
        if planes.size == 4:
            a1, b1, w1 = _u4(keys[1]), _u4(keys[1] >> _u8(32)), weights[1]
            a2, b2, w2 = _u4(keys[2]), _u4(keys[2] >> _u8(32)), weights[2]
            a3, b3, w3 = _u4(keys[3]), _u4(keys[3] >> _u8(32)), weights[3]
            for i in range(part.size):
                node = nodes[i]
                part[i] = (
                    w0 * _normal(_scatter(node, a0, b0))
                    + w1 * _normal(_scatter(node, a1, b1))
                    + w2 * _normal(_scatter(node, a2, b2))
                    + w3 * _normal(_scatter(node, a3, b3))
                )
        else:
            for i in range(part.size):
                part[i] = w0 * _normal(_scatter(nodes[i], a0, b0))
        start = stop


@kernel()
def _nodes(planes: NDArray[np.uint64], y: NDArray[np.int64], x: NDArray[np.int64], values: NDArray[np.float32]) -> None:
    weights, scratch = np.ones(1, dtype=np.float32), np.empty(x.size, dtype=np.uint32)
    for row in range(y.size):
        blend_scattered(planes, weights, y[row], x, values[row], scratch)


def lattice_normals(seed: int, octave: int, t: int, y: NDArray[np.int64], x: NDArray[np.int64]) -> NDArray[np.float32]:
    """Return the normals (M, N), within +-6.4, of one octave and time plane on nodes ``y`` (M,) x ``x`` (N,).

    Indices and seed may have any sign and are taken modulo 2**64; ``x`` ascends.
    """
    values = np.empty((y.size, x.size), dtype=np.float32)
    planes = np.array([plane_key(seed, octave, t)], dtype=np.uint64)
    _nodes(planes, np.asarray(y, dtype=np.int64), np.asarray(x, dtype=np.int64), values)
    return values
