"""Noise of electrons that come one by one, and of reading them.

Differences between detectors, the same in all frames.
"""

from __future__ import annotations

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import ProviderError
from hcss_twin.models.sensor.random_numbers import key_of, poisson, standard_normal

MAX_COUNTED = 1e12
"""Expected electrons up to which numbers are drawn; beyond, rounding would show in their distribution."""


def shot_noise(expected: Array, key: int, corner: tuple[int, int]) -> Array:
    """Draw numbers of electrons from Poisson's distribution, whose variance is its mean.

    Parameters
    ----------
    expected : ndarray
        Mean numbers. Where blur of a sharp edge has undershot below 0 nothing is drawn and the negative number
        stays, so that the mean of a frame is kept.
    key : int
        Of the random numbers, 64 bits.
    corner : (int, int)
        Row and column of the first pixel in the image.

    Raises
    ------
    ProviderError
        If more than 1e12 electrons are expected in a pixel.
    """
    most = float(expected.max(initial=0.0))
    if most > MAX_COUNTED:
        raise ProviderError(
            f"{most:.3g} electrons are expected in a pixel; allowed: up to {MAX_COUNTED:g} (aperture_diameter, "
            "pixel_angle, integration_time)"
        )
    result: Array = poisson(np.maximum(expected, 0.0), key, corner) + np.minimum(expected, 0.0)
    return result


def gaussian_noise(signal: Array, deviation: float, key: int, corner: tuple[int, int]) -> Array:
    """Add noise of one standard deviation, in the unit of the signal: that of reading, or an NER."""
    rows, columns = signal.shape
    result: Array = signal + deviation * standard_normal(key, (rows, columns), corner)
    return result


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
