"""Pierson-Moskowitz spectrum of a fully developed sea.

The spectrum is eq 1 of the HCSS paper; the original is W. J. Pierson and L. Moskowitz, A proposed spectral form for
fully developed wind seas, J. Geophys. Res. 69, 5181-5190 (1964), with winds at 19.5 m. It describes wave heights.
Infrared emissivity depends on slopes (:mod:`hcss_twin.models.sea.slope_statistics`), which include short waves that a
height spectrum does not resolve.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

ALPHA, BETA, GRAVITY_M_S2 = 8.1e-3, 0.74, 9.81
"""Constants of eq 1."""


def spectrum_m2_s(omega_rad_s: NDArray[np.float64], wind_speed_m_s: float) -> NDArray[np.float64]:
    """Return the spectrum of elevation, alpha g^2 / omega^5 exp(-beta (g / (U omega))^4) (eq 1).

    Parameters
    ----------
    omega_rad_s : ndarray
        Angular frequencies, not negative; any shape.
    wind_speed_m_s : float
        Wind speed U; 0 gives a calm sea with a spectrum of 0.

    Returns
    -------
    ndarray
        Same shape, m^2 s (per rad/s); its integral over omega is the variance of elevation.

    Raises
    ------
    ValueError
        If a frequency or the wind speed is negative or not finite.
    """
    wind = _checked_wind(wind_speed_m_s)
    omega = np.asarray(omega_rad_s, dtype=np.float64)
    if not np.all(np.isfinite(omega) & (omega >= 0.0)):
        raise ValueError(f"omega_rad_s {np.min(omega)} to {np.max(omega)}: allowed finite, not negative")
    result = np.zeros_like(omega)
    if wind == 0.0:
        return result
    # Where the exponent exceeds 700, the value is below the smallest double, and omega^-5 may overflow.
    live = omega > (BETA / 700.0) ** 0.25 * GRAVITY_M_S2 / wind
    above = omega[live]
    result[live] = ALPHA * GRAVITY_M_S2**2 / above**5 * np.exp(-BETA * (GRAVITY_M_S2 / (wind * above)) ** 4)
    return result


def elevation_variance_m2(wind_speed_m_s: float) -> float:
    """Return m0, the integral of eq 1 over all frequencies: alpha U^4 / (4 beta g^2), in m^2.

    Raises
    ------
    ValueError
        If the wind speed is negative or not finite.
    """
    return ALPHA * _checked_wind(wind_speed_m_s) ** 4 / (4.0 * BETA * GRAVITY_M_S2**2)


def significant_wave_height_m(wind_speed_m_s: float) -> float:
    """Return Hs = 4 sqrt(m0), in metres: 2.13 m at 10 m/s.

    Raises
    ------
    ValueError
        If the wind speed is negative or not finite.
    """
    return 4.0 * math.sqrt(elevation_variance_m2(wind_speed_m_s))


def peak_frequency_rad_s(wind_speed_m_s: float) -> float:
    """Return the frequency of the spectrum's maximum, (4 beta / 5)^(1/4) g / U, in rad/s.

    Raises
    ------
    ValueError
        If the wind speed is not above 0 or not finite: a calm sea has no peak.
    """
    wind = _checked_wind(wind_speed_m_s)
    if wind == 0.0:
        raise ValueError("wind_speed_m_s 0: a calm sea has no peak; allowed above 0")
    return math.sqrt(math.sqrt(0.8 * BETA)) * GRAVITY_M_S2 / wind


def _checked_wind(wind_speed_m_s: float) -> float:
    if not (math.isfinite(wind_speed_m_s) and wind_speed_m_s >= 0.0):
        raise ValueError(f"wind_speed_m_s {wind_speed_m_s}: allowed finite, at least 0")
    return float(wind_speed_m_s)
