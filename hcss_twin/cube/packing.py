"""Packing of single-precision variables into 16-bit integers with CF's scale_factor and add_offset.

Writing takes most of the time of large cubes, and half of the bytes hold digits below the accuracy. Steps are powers of
two and offsets multiples of them, so that unpacking is exact in single precision and every reader gets the same number.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.errors import CubeError
from hcss_twin.core.kernels import kernel

LARGEST = 32767
"""Largest packed number; the smallest is its negative."""

FILL = -32768
"""Packed number reserved for missing values."""


@dataclass(frozen=True)
class Packing:
    """Steps of a packed variable, and the errors of rounding to them.

    Attributes
    ----------
    scale_factor, add_offset : float
        Value of one step, and of 0.
    relative : tuple of float (B,)
        Largest error relative to the darkest radiance of each band; empty if the variable has no bands.
    kelvin : tuple of float (B,)
        The same as brightness temperature.
    """

    scale_factor: float
    add_offset: float
    relative: tuple[float, ...] = ()
    kelvin: tuple[float, ...] = ()

    @property
    def error(self) -> float:
        """Largest rounding error, in the units of the variable: half a step."""
        return 0.5 * self.scale_factor

    @property
    def limits(self) -> tuple[float, float]:
        """Smallest and largest value that can be stored."""
        return self.add_offset - LARGEST * self.scale_factor, self.add_offset + LARGEST * self.scale_factor


def packing_of(lowest: float, highest: float) -> Packing:
    """Return the finest packing of a range of values, whose smallest value is the lowest one or just below."""
    step = 2.0 ** math.ceil(math.log2((highest - lowest) / (2 * LARGEST)))
    if highest > math.floor(lowest / step) * step + 2 * LARGEST * step:
        step *= 2.0
    return Packing(step, (math.floor(lowest / step) + LARGEST) * step)


def round_to_steps(values: NDArray[np.float32], packing: Packing, where: str) -> None:
    """Round values in place to those that can be stored.

    Raises
    ------
    CubeError
        If a value is beyond the limits; the message starts with ``where``.
    """
    flat = values.reshape(-1)
    assert np.shares_memory(flat, values)
    if _round(flat, packing.scale_factor, packing.add_offset):
        low, high = packing.limits
        raise CubeError(
            f"{where}: values from {np.min(values):g} to {np.max(values):g} do not fit into 16 bits; allowed: {low:g} "
            f"to {high:g}, which the plan expected, or output.packing left out"
        )


def packed(values: NDArray[np.float32], packing: Packing) -> NDArray[np.int16]:
    """Return values that lie on steps as packed numbers."""
    numbers: NDArray[np.int16] = _pack(values, packing.scale_factor, packing.add_offset)
    return numbers


@kernel()
def _round(values, scale, offset):  # type: ignore[no-untyped-def]
    """Round to steps; return the number of values beyond the limits, or not a number."""
    beyond, per_step = 0, 1.0 / scale
    for n in range(values.size):
        number = np.rint((values[n] - offset) * per_step)
        beyond += not abs(number) <= LARGEST
        values[n] = number * scale + offset
    return beyond


@kernel()
def _pack(values, scale, offset):  # type: ignore[no-untyped-def]
    numbers = np.empty(values.shape, np.int16)
    flat, into = values.ravel(), numbers.ravel()
    per_step = 1.0 / scale
    for n in range(flat.size):
        into[n] = np.int16((flat[n] - offset) * per_step)
    return numbers
