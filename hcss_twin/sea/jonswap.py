"""The JONSWAP spectrum of a sea that grows over a limited fetch.

K. Hasselmann et al., Measurements of wind-wave growth and swell decay during the Joint North Sea Wave
Project (JONSWAP), Ergaenzungsheft zur Deutschen Hydrographischen Zeitschrift A8, no. 12 (1973), with winds
at 10 m: the spectrum of Pierson and Moskowitz with a peak that is higher by gamma = 3.3, and a level and a
peak frequency that depend on the dimensionless fetch g F / U^2.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hcss_twin.sea.pierson_moskowitz import GRAVITY_M_S2

GAMMA = 3.3
_WIDTH_BELOW, _WIDTH_ABOVE = 0.07, 0.09


def peak_frequency_rad_s(wind_speed_m_s: float, fetch_m: float) -> float:
    """Return 22 (g^2 / (U F))^(1/3), in rad/s.

    Raises
    ------
    ValueError
        If wind speed or fetch are not above 0 or not finite.
    """
    wind, fetch = _checked(wind_speed_m_s, fetch_m)
    if wind == 0.0:
        raise ValueError("wind_speed_m_s 0: a calm sea has no peak; allowed above 0")
    return 22.0 * float((GRAVITY_M_S2**2 / (wind * fetch)) ** (1.0 / 3.0))


def spectrum_m2_s(
    omega_rad_s: NDArray[np.float64], wind_speed_m_s: float, fetch_m: float
) -> NDArray[np.float64]:
    """Return alpha g^2 / omega^5 exp(-5/4 (omega_p / omega)^4) gamma^r, m^2 per rad/s.

    Parameters
    ----------
    omega_rad_s : ndarray
        Angular frequencies, not negative; any shape.
    wind_speed_m_s : float
        Wind at 10 m; 0 gives a spectrum of 0.
    fetch_m : float
        Distance over which the wind has blown, above 0.

    Raises
    ------
    ValueError
        If a frequency or the wind speed is negative, the fetch not above 0, or one is not finite.

    Notes
    -----
    alpha = 0.076 (U^2 / (g F))^0.22, r = exp(-(omega / omega_p - 1)^2 / (2 s^2)), s = 0.07 below the peak and
    0.09 above.
    """
    wind, fetch = _checked(wind_speed_m_s, fetch_m)
    omega = np.asarray(omega_rad_s, dtype=np.float64)
    if not np.all(np.isfinite(omega) & (omega >= 0.0)):
        raise ValueError(f"omega_rad_s {np.min(omega)} to {np.max(omega)}: allowed finite, not negative")
    result = np.zeros_like(omega)
    if wind == 0.0:
        return result
    peak = peak_frequency_rad_s(wind, fetch)
    # Where the exponent passes 700 the value is below the smallest double, and omega^-5 may overflow.
    live = omega > (1.25 / 700.0) ** 0.25 * peak
    above = omega[live]
    width = np.where(above <= peak, _WIDTH_BELOW, _WIDTH_ABOVE)
    raised = GAMMA ** np.exp(-0.5 * ((above / peak - 1.0) / width) ** 2)
    alpha = 0.076 * (wind**2 / (GRAVITY_M_S2 * fetch)) ** 0.22
    result[live] = alpha * GRAVITY_M_S2**2 / above**5 * np.exp(-1.25 * (peak / above) ** 4) * raised
    return result


def _checked(wind_speed_m_s: float, fetch_m: float) -> tuple[float, float]:
    if not (math.isfinite(wind_speed_m_s) and wind_speed_m_s >= 0.0):
        raise ValueError(f"wind_speed_m_s {wind_speed_m_s}: allowed finite, at least 0")
    if not (math.isfinite(fetch_m) and fetch_m > 0.0):
        raise ValueError(f"fetch_m {fetch_m}: allowed finite, above 0")
    return float(wind_speed_m_s), float(fetch_m)
