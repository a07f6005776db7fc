"""Airy pattern as a pixel kernel."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_POINTS = 16
"""Points along a pixel's side over which the pattern is averaged."""


def airy_kernel(wavelength_um: float, f_number: float, pitch_um: float, radius: int = 7) -> Array:
    """Return the mean of the Airy pattern over each pixel, normalised to a sum of 1.

    (2 J1(v) / v)^2 with v = pi r / (wavelength f_number), r the distance in the focal plane (M. Born and E. Wolf,
    "Principles of Optics", 7th edition, 1999, section 8.5.2). Light beyond the kernel is put into it.

    Parameters
    ----------
    wavelength_um, f_number, pitch_um : float
    radius : int
        Pixels beside the central one.

    Returns
    -------
    ndarray (2 radius + 1, 2 radius + 1)
    """
    from scipy.special import j1

    side = 2 * radius + 1
    places = (np.arange(side * _POINTS) + 0.5) / _POINTS - 0.5 * side
    distance = np.hypot(places[:, None], places[None, :]) * pitch_um
    # no point lies at the centre, where the quotient is undefined
    v = np.pi * distance / (wavelength_um * f_number)
    pattern = (2.0 * j1(v) / v) ** 2
    kernel: Array = pattern.reshape(side, _POINTS, side, _POINTS).mean(axis=(1, 3))
    kernel /= kernel.sum()
    return kernel
