"""Point-spread functions of the optics, by their modulation transfer functions."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def gaussian_mtf(frequency: Array, sigma_pixels: float) -> Array:
    """Modulation transfer of a Gaussian spread function, exp(-2 (pi sigma f)^2).

    Parameters
    ----------
    frequency : ndarray
        Cycles per pixel.
    sigma_pixels : float
        Standard deviation of the spread along either axis.
    """
    result: Array = np.exp(-2.0 * (np.pi * sigma_pixels * frequency) ** 2)
    return result


def airy_mtf(frequency: Array, cutoff: float) -> Array:
    """Modulation transfer of diffraction at a circular aperture without obscuration.

    (2 / pi) (arccos u - u sqrt(1 - u^2)) with u = f / cutoff, 0 from the cut-off on: the overlap of two displaced
    circles (Goodman, Introduction to Fourier Optics, section 6.3).

    Parameters
    ----------
    frequency, cutoff : ndarray, float
        In the same unit.
    """
    u = np.minimum(frequency / cutoff, 1.0)
    result: Array = (2.0 / np.pi) * (np.arccos(u) - u * np.sqrt(1.0 - u * u))
    return result


def airy_cutoff(aperture_diameter_m: float, pixel_angle_rad: float, wavelength_um: float) -> float:
    """Frequency from which an aperture passes nothing, in cycles per pixel: diameter times angle over wavelength."""
    return aperture_diameter_m * pixel_angle_rad / (wavelength_um * 1e-6)
