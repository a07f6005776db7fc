"""Differences between detectors, the same in all frames."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcss_twin.sensor.random_numbers import key_of, standard_normal

Array = NDArray[np.float64]


class FixedPattern:
    """Gain and offset of each detector of one band.

    Parameters
    ----------
    shape : (int, int)
        Rows and columns of the frames.
    corner : (int, int)
        Row and column of their first pixel in the image.
    gain_deviation : float
        Standard deviation of the gain, whose mean is 1.
    offset_deviation : float
        Standard deviation of the offset, whose mean is 0, in the unit of the signal.
    line : bool
        One detector for each row, which makes stripes along the direction of flight (x), instead of one for each pixel.
    seed, band : int, str
        What the detectors follow from.
    """

    def __init__(
        self,
        shape: tuple[int, int],
        corner: tuple[int, int],
        gain_deviation: float,
        offset_deviation: float,
        line: bool,
        seed: int,
        band: str,
    ) -> None:
        detectors, first = ((shape[0], 1), (corner[0], 0)) if line else (shape, corner)
        self._gain = _drawn(detectors, first, gain_deviation, key_of(seed, "gain", band))
        self._offset = _drawn(detectors, first, offset_deviation, key_of(seed, "offset", band))

    def __call__(self, signal: Array) -> Array:
        """Return (1 + gain difference) signal + offset for a frame (Y, X)."""
        if self._gain is not None:
            signal = signal * (1.0 + self._gain)
        return signal if self._offset is None else signal + self._offset


def _drawn(shape: tuple[int, int], corner: tuple[int, int], deviation: float, key: int) -> Array | None:
    return None if deviation == 0.0 else deviation * standard_normal(key, shape, corner)
