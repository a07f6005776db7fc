"""Black-body radiance and its physical constants.

The constants have defined the SI since 2019 and are exact (BIPM, *The International System of Units*, 9th edition).
"""

from __future__ import annotations

import numpy as np

from hcss_twin.core.arrays import Array

PLANCK_J_S = 6.62607015e-34
SPEED_OF_LIGHT_M_S = 299792458.0
BOLTZMANN_J_K = 1.380649e-23

FIRST_RADIATION = 2.0 * PLANCK_J_S * SPEED_OF_LIGHT_M_S**2 * 1e8
"""2 h c^2 for wavenumbers in cm-1 and radiance per cm-1, W m-2 sr-1 (cm-1)-4."""

SECOND_RADIATION = PLANCK_J_S * SPEED_OF_LIGHT_M_S / BOLTZMANN_J_K * 100.0
"""h c / k for wavenumbers in cm-1, in cm K."""


def planck(wavenumber_cm1: Array, temperature_K: Array | float) -> Array:
    """Spectral radiance of a black body, M(T, lambda) / pi (HCSS paper, eq 15 and eq 17).

    Parameters
    ----------
    wavenumber_cm1 : ndarray (..., V)
        Wavenumbers, above 0.
    temperature_K : ndarray or float
        Temperatures, broadcast against ``wavenumber_cm1``.

    Returns
    -------
    ndarray
        W m-2 sr-1 (cm-1)-1.
    """
    exponent = SECOND_RADIATION * wavenumber_cm1 / temperature_K
    # exp(-x)/(1-exp(-x)) instead of 1/(exp(x)-1): no overflow where the radiance vanishes.
    result: Array = FIRST_RADIATION * wavenumber_cm1**3 * np.exp(-exponent) / -np.expm1(-exponent)
    return result


def wavenumber_from_um(wavelength_um: Array | float) -> Array:
    """Convert wavelength in micrometres to wavenumber in cm-1 (or back: it is its own inverse)."""
    result: Array = 1e4 / np.asarray(wavelength_um, dtype=np.float64)
    return result
