"""Noise of electrons that come one by one, and of reading them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcss_twin.errors import ProviderError
from hcss_twin.sensor.poisson import poisson
from hcss_twin.sensor.random_numbers import standard_normal

Array = NDArray[np.float64]

MOST_COUNTED = 1e12
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
    if most > MOST_COUNTED:
        raise ProviderError(
            f"{most:.3g} electrons are expected in a pixel; allowed: up to {MOST_COUNTED:g} (aperture_diameter, "
            "pixel_angle, integration_time)"
        )
    result: Array = poisson(np.maximum(expected, 0.0), key, corner) + np.minimum(expected, 0.0)
    return result


def gaussian_noise(signal: Array, deviation: float, key: int, corner: tuple[int, int]) -> Array:
    """Add noise of one standard deviation, in the unit of the signal: that of reading, or an NER."""
    rows, columns = signal.shape
    result: Array = signal + deviation * standard_normal(key, (rows, columns), corner)
    return result
