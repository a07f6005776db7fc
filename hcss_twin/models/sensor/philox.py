"""Standard normal numbers of pixels: a counter-based generator, so that any window has those of the whole image.

A block of 64 columns of a row needs 16 calls of the generator Philox4x32 with 7 rounds, which passes the tests of
BigCrush (J. K. Salmon et al., Parallel random numbers: as easy as 1, 2, 3, SC 2011). Its counter is made of block and
row, its key of seed, band and frame. Each pair of 32-bit numbers gives two normal ones (G. E. P. Box and M. E. Muller,
Ann. Math. Stat. 29, 610 (1958)), at most 6.7 standard deviations from 0. All operations are those of IEEE arithmetic in
a fixed order, so that the numbers are the same on every machine.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from hcss_twin.core.kernels import kernel

BLOCK, LANE = 64, 16
"""Columns of a block, and of each of its four parts, which the four numbers of a call belong to."""

_LOW, _32 = np.uint64(0xFFFFFFFF), np.uint64(32)
_FACTOR_0, _FACTOR_1 = np.uint64(0xD2511F53), np.uint64(0xCD9E8D57)
_STEP_0, _STEP_1 = np.uint64(0x9E3779B9), np.uint64(0xBB67AE85)
_ROOT_OF_HALF = np.int32(0x3F3504F3)
"""Bits of the square root of 1/2 in single precision."""

_HALF_PI = np.float32(0.5 * np.pi * 2.0**-31)
_TWO_LN_2 = np.float32(2.0 * np.log(2.0))


@kernel()
def _round(a: Any, b: Any, c: Any, d: Any, low: Any, high: Any) -> Any:
    first, second = a * _FACTOR_0, c * _FACTOR_1
    return (second >> _32) ^ b ^ low, second & _LOW, (first >> _32) ^ d ^ high, first & _LOW


@kernel()
def philox(a: Any, b: Any, c: Any, d: Any, low: Any, high: Any) -> Any:
    """Return four numbers of 32 bits for a counter of four and a key of two such numbers, all as uint64."""
    # no loop, which would prevent that several blocks are computed at once
    a, b, c, d = _round(a, b, c, d, low, high)
    low, high = (low + _STEP_0) & _LOW, (high + _STEP_1) & _LOW
    a, b, c, d = _round(a, b, c, d, low, high)
    low, high = (low + _STEP_0) & _LOW, (high + _STEP_1) & _LOW
    a, b, c, d = _round(a, b, c, d, low, high)
    low, high = (low + _STEP_0) & _LOW, (high + _STEP_1) & _LOW
    a, b, c, d = _round(a, b, c, d, low, high)
    low, high = (low + _STEP_0) & _LOW, (high + _STEP_1) & _LOW
    a, b, c, d = _round(a, b, c, d, low, high)
    low, high = (low + _STEP_0) & _LOW, (high + _STEP_1) & _LOW
    a, b, c, d = _round(a, b, c, d, low, high)
    low, high = (low + _STEP_0) & _LOW, (high + _STEP_1) & _LOW
    return _round(a, b, c, d, low, high)


@kernel()
def _normal_pair(one: Any, other: Any) -> Any:
    """Return sqrt(-2 ln u) times sine and cosine of 2 pi v, for u and v of 31 and 32 bits; errors below 2e-6.

    Minimax polynomials: -2 ln(1 + m) / m for m from sqrt(1/2) - 1 to sqrt(2) - 1, sine and cosine of half the angle.
    """
    f = np.float32
    bits = np.int32(np.float32(f(np.int32(one >> np.uint64(1))) + f(0.5)).view(np.int32) - _ROOT_OF_HALF)
    exponent = f(bits >> np.int32(23)) - f(31.0)
    m = np.int32((bits & np.int32(0x7FFFFF)) + _ROOT_OF_HALF).view(np.float32) - f(1.0)
    log = f(-1.99999984) + m * (
        f(1.00000689)
        + m
        * (
            f(-0.666712158)
            + m
            * (
                f(0.499431206)
                + m * (f(-0.397684706) + m * (f(0.344248514) + m * (f(-0.326762939) + m * (f(0.207574377)))))
            )
        )
    )
    radius = np.sqrt(log * m - exponent * _TWO_LN_2)
    half = f(np.int32(other)) * _HALF_PI
    g = half * half
    sine = f(0.999999246) + g * (f(-0.166656827) + g * (f(0.00831325871) + g * (f(-0.000185243573))))
    cosine = f(0.999999953) + g * (
        f(-0.499999053) + g * (f(0.0416635847) + g * (f(-0.00138537043) + g * (f(2.31539317e-05))))
    )
    sine = sine * half
    share = f(2.0) * radius * sine
    return share * cosine, radius - share * sine


@kernel()
def fill_normals(numbers: Any, row: Any, block: Any, key: Any) -> None:
    """Fill ``numbers`` (N,) of float32, N a multiple of 64, for the pixels of a row from a block of columns on."""
    low, high, own_row, none = key & _LOW, key >> _32, np.uint64(row) & _LOW, np.uint64(0)
    for index in range(numbers.size // BLOCK):
        first = index * BLOCK
        for i in range(LANE):
            counter = np.uint64((block + index) * LANE + i) & _LOW
            a, b, c, d = philox(counter, own_row, none, none, low, high)
            numbers[first + i], numbers[first + LANE + i] = _normal_pair(a, b)
            numbers[first + 2 * LANE + i], numbers[first + 3 * LANE + i] = _normal_pair(c, d)
