"""Saturation and quantisation of a signal."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

UPPER, LOWER = 1, 2
"""Flags of values that were cut at the upper and at the lower end."""


@dataclass(frozen=True)
class Readout:
    """What a detector and its converter can hold, in the unit of the signal (electrons or radiance).

    Attributes
    ----------
    full : float or None
        Signal at which the detector is full.
    bits : int or None
        Of the converter; None leaves the signal analogue.
    step : float
        Signal of one digital number, above 0.
    offset : int
        Digital number of no signal, which keeps noise about 0 from being cut.
    """

    full: float | None = None
    bits: int | None = None
    step: float = 1.0
    offset: int = 0

    def read(self, signal: Array) -> tuple[Array, NDArray[np.int32] | None, NDArray[np.uint8]]:
        """Read a frame.

        Returns
        -------
        signal : ndarray (Y, X)
            As known after it was read: that of the digital number where there is one.
        digital_number : ndarray (Y, X) or None
            The nearest whole number to signal / step + offset, halves up, within 0 and 2^bits - 1.
        flags : ndarray (Y, X)
            0, or where a value was cut 1 (upper end) or 2 (lower end).
        """
        flags = np.zeros(signal.shape, dtype=np.uint8)
        if self.full is not None:
            flags[signal > self.full] = UPPER
            signal = np.minimum(signal, self.full)
        if self.bits is None:
            return signal, None, flags
        number = np.floor(signal / self.step + 0.5) + self.offset
        most = float(2**self.bits - 1)
        flags[number > most] = UPPER
        flags[number < 0.0] = LOWER
        number = np.clip(number, 0.0, most)
        return (number - self.offset) * self.step, number.astype(np.int32), flags
