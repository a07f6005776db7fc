"""Conversion of band radiance to photons on a pixel.

An extended source of radiance L fills the solid angle that a pixel sees; of the power L A Omega that enters the
aperture the transmission arrives, in photons of h c / lambda (for instance G. H. Rieke, "Detection of Light", 2nd
edition, 2003, section 1.3).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy import constants

from hcss_twin.providers import planck, wavenumber_from_um

Array = NDArray[np.float64]

_TEMPERATURES_K = np.linspace(100.0, 1000.0, 901)
"""Of the black bodies between which the mean wavelength is interpolated."""

_POINTS = 64
"""Of the Gauss-Legendre rule over a band."""


def etendue_m2_sr(pixel_area_m2: float, f_number: float) -> float:
    """Return A Omega of a pixel: aperture pi D^2 / 4 times pixel area / f^2, with D / f = 1 / f_number.

    Valid for distant scenes and pixels near the axis; the fall of light toward the edge of the field is left out.
    """
    return pixel_area_m2 * math.pi / (4.0 * f_number**2)


def photons(radiance: Array, etendue_m2_sr: float, seconds: float, wavelength_um: Array | float) -> Array:
    """Return photons: L A Omega t lambda / (h c).

    Parameters
    ----------
    radiance : ndarray
        Of the band, W m-2 sr-1.
    etendue_m2_sr : float
        Times the transmission.
    seconds : float
        Length of the exposure.
    wavelength_um : ndarray or float
        Mean wavelength of the radiance (not of the photons), in which the number of photons is exact.
    """
    result: Array = (
        radiance
        * (etendue_m2_sr * seconds)
        * (np.asarray(wavelength_um, dtype=np.float64) * 1e-6 / (constants.h * constants.c))
    )
    return result


def black_body_wavelength_um(radiance: Array, lower_um: float, upper_um: float) -> Array:
    """Return the mean wavelength of black bodies that have these radiances between the limits of a band.

    It is the integral of lambda L over that of L, so that ``photons`` counts those of such a body exactly. Radiance
    below that of 100 K, which is no one's count, gets the wavelength of 100 K.

    Parameters
    ----------
    radiance : ndarray
        W m-2 sr-1.
    lower_um, upper_um : float
        Limits of the band; its response between them is taken for constant.

    Raises
    ------
    ValueError
        If a radiance is above that of 1000 K.
    """
    nodes, weights = np.polynomial.legendre.leggauss(_POINTS)
    first, last = 1e4 / upper_um, 1e4 / lower_um
    wavenumber = 0.5 * (first + last) + 0.5 * (last - first) * nodes
    spectra = planck(wavenumber, _TEMPERATURES_K[:, None]) * (0.5 * (last - first) * weights)
    total = spectra.sum(axis=1)
    mean = spectra @ wavenumber_from_um(wavenumber) / total
    if np.max(radiance, initial=0.0) > total[-1]:
        raise ValueError(
            f"radiance {np.max(radiance):g} W m-2 sr-1 is above that of a black body of "
            f"{_TEMPERATURES_K[-1]:g} K ({total[-1]:g}); give the mean wavelength of its light as wavelength_um"
        )
    with np.errstate(divide="ignore"):
        result: Array = np.interp(np.log(radiance), np.log(total), mean)
    return result
