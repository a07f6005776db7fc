"""Motion of the image over the ground while the detector integrates."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def smear_pixels(platform_speed_m_s: float, integration_time_s: float, pixel_size_m: float) -> float:
    """Distance in pixels that the footprint travels along x during one integration, 0 or more."""
    return abs(platform_speed_m_s) * integration_time_s / pixel_size_m


def smear_mtf(frequency_x: Array, pixels: float) -> Array:
    """Modulation transfer of uniform motion along x, sin(pi f d) / (pi f d), centred on the time of the frame.

    Parameters
    ----------
    frequency_x : ndarray
        Cycles per pixel.
    pixels : float
        Distance d travelled during the integration.
    """
    result: Array = np.sinc(frequency_x * pixels)
    return result
