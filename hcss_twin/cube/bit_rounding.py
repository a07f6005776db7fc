"""Rounding of numbers to fewer significant bits, so that they compress: the algorithm ``bitround`` of CF-1.12.

The mantissa is rounded to its leading bits and the rest is 0. That is what the netCDF library calls BitRound, to the
bit; it is done here because the library only does it on the way to the disk, and what checks a cube needs the numbers
that the cube has (D. A. Hassell and others, CF Conventions 1.12, section 8.4, *Lossy compression via quantization*).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

MANTISSA_BITS = 23
"""Of single precision, in which cubes are written."""

INFO = "quantization_info"
"""Variable of the cube that names the algorithm."""


def bits_for(error: float) -> int:
    """Return the fewest explicit bits of the mantissa, at most all, whose rounding errs by no more, relatively.

    Parameters
    ----------
    error : float
        Greater than 0 and less than 1.
    """
    return min(MANTISSA_BITS, max(1, math.ceil(-math.log2(error) - 1.0)))


def largest_error(bits: int) -> float:
    """Return the largest relative error of rounding to so many bits: half a step of the smallest mantissa."""
    return 0.0 if bits >= MANTISSA_BITS else 2.0 ** -(bits + 1)


def round_bits(values: NDArray[np.float32], bits: int) -> None:
    """Round in place, halves away from zero. Zeros, infinities and NaN stay as they are.

    Parameters
    ----------
    values : ndarray of float32
    bits : int
        Explicit bits of the mantissa that are kept, 1 to 23.
    """
    dropped = MANTISSA_BITS - bits
    if dropped <= 0:
        return
    numbers = values.view(np.uint32)
    # NaN may have any bits, and would not always survive the sum.
    known = ~np.isnan(values)
    np.add(numbers, np.uint32(1 << (dropped - 1)), out=numbers, where=known)
    np.bitwise_and(numbers, np.uint32(0xFFFFFFFF << dropped & 0xFFFFFFFF), out=numbers, where=known)
