"""Frequency spectra of wave height: JONSWAP, and a common interface for JONSWAP and Pierson-Moskowitz.

JONSWAP describes a sea that grows over a limited fetch: K. Hasselmann et al., Measurements of wind-wave growth and
swell decay during the Joint North Sea Wave Project (JONSWAP), Ergaenzungsheft zur Deutschen Hydrographischen
Zeitschrift A8, no. 12 (1973), with winds at 10 m. It is the Pierson-Moskowitz spectrum with the peak enhanced by gamma
= 3.3, and a level and peak frequency that depend on the dimensionless fetch g F / U^2.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from hcss_twin.models.sea import pierson_moskowitz

GAMMA = 3.3
_WIDTH_BELOW, _WIDTH_ABOVE = 0.07, 0.09


def peak_frequency_rad_s(wind_speed_m_s: float, fetch_m: float) -> float:
    """Return 22 (g^2 / (U F))^(1/3), in rad/s.

    Raises
    ------
    ValueError
        If wind speed or fetch is not above 0 or not finite.
    """
    wind, fetch = _checked(wind_speed_m_s, fetch_m)
    if wind == 0.0:
        raise ValueError("wind_speed_m_s 0: a calm sea has no peak; allowed above 0")
    return 22.0 * float((pierson_moskowitz.GRAVITY_M_S2**2 / (wind * fetch)) ** (1.0 / 3.0))


def spectrum_m2_s(omega_rad_s: NDArray[np.float64], wind_speed_m_s: float, fetch_m: float) -> NDArray[np.float64]:
    """Return alpha g^2 / omega^5 exp(-5/4 (omega_p / omega)^4) gamma^r, m^2 per rad/s.

    Parameters
    ----------
    omega_rad_s : ndarray
        Angular frequencies, not negative; any shape.
    wind_speed_m_s : float
        Wind at 10 m; 0 gives a spectrum of 0.
    fetch_m : float
        Distance over which the wind blows, above 0.

    Raises
    ------
    ValueError
        If a frequency or the wind speed is negative, the fetch not above 0, or one is not finite.

    Notes
    -----
    alpha = 0.076 (U^2 / (g F))^0.22, r = exp(-(omega / omega_p - 1)^2 / (2 s^2)), s = 0.07 below the peak and 0.09
    above.
    """
    wind, fetch = _checked(wind_speed_m_s, fetch_m)
    omega = np.asarray(omega_rad_s, dtype=np.float64)
    if not np.all(np.isfinite(omega) & (omega >= 0.0)):
        raise ValueError(f"omega_rad_s {np.min(omega)} to {np.max(omega)}: allowed finite, not negative")
    result = np.zeros_like(omega)
    if wind == 0.0:
        return result
    peak = peak_frequency_rad_s(wind, fetch)
    # Where the exponent exceeds 700, the value is below the smallest double, and omega^-5 may overflow.
    live = omega > (1.25 / 700.0) ** 0.25 * peak
    above = omega[live]
    width = np.where(above <= peak, _WIDTH_BELOW, _WIDTH_ABOVE)
    raised = GAMMA ** np.exp(-0.5 * ((above / peak - 1.0) / width) ** 2)
    alpha = 0.076 * (wind**2 / (pierson_moskowitz.GRAVITY_M_S2 * fetch)) ** 0.22
    result[live] = alpha * pierson_moskowitz.GRAVITY_M_S2**2 / above**5 * np.exp(-1.25 * (peak / above) ** 4) * raised
    return result


def _checked(wind_speed_m_s: float, fetch_m: float) -> tuple[float, float]:
    if not (math.isfinite(wind_speed_m_s) and wind_speed_m_s >= 0.0):
        raise ValueError(f"wind_speed_m_s {wind_speed_m_s}: allowed finite, at least 0")
    if not (math.isfinite(fetch_m) and fetch_m > 0.0):
        raise ValueError(f"fetch_m {fetch_m}: allowed finite, above 0")
    return float(wind_speed_m_s), float(fetch_m)


SpectrumName = Literal["pierson-moskowitz", "jonswap"]
_STEPS = 4000


@dataclass(frozen=True)
class WaveSpectrum:
    """Wave spectrum at one wind speed.

    Attributes
    ----------
    name : {"pierson-moskowitz", "jonswap"}
        Fully developed sea, or sea limited by the fetch ``fetch_m``.
    wind_speed_m_s : float
        Wind speed (at 19.5 m and 10 m respectively), at least 0; 0 gives a calm sea.
    fetch_m : float
        Used by JONSWAP only.
    """

    name: SpectrumName
    wind_speed_m_s: float
    fetch_m: float = 100e3

    def density_m2_s(self, omega_rad_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the spectrum of elevation, m^2 per rad/s, at angular frequencies of any shape."""
        if self.name == "jonswap":
            return spectrum_m2_s(omega_rad_s, self.wind_speed_m_s, self.fetch_m)
        return pierson_moskowitz.spectrum_m2_s(omega_rad_s, self.wind_speed_m_s)

    @property
    def peak_frequency_rad_s(self) -> float:
        """Frequency of the maximum; the wind speed must be above 0."""
        if self.name == "jonswap":
            return peak_frequency_rad_s(self.wind_speed_m_s, self.fetch_m)
        return pierson_moskowitz.peak_frequency_rad_s(self.wind_speed_m_s)

    @property
    def significant_wave_height_m(self) -> float:
        """Four standard deviations of the elevation."""
        if self.wind_speed_m_s == 0.0:
            return 0.0
        if self.name == "pierson-moskowitz":
            return pierson_moskowitz.significant_wave_height_m(self.wind_speed_m_s)
        omega, step = self._frequencies(50.0 * self.peak_frequency_rad_s)
        return 4.0 * math.sqrt(float(self.density_m2_s(omega) @ step))

    def resolved_mean_square_slope(self, cutoff_rad_s: float) -> float:
        """Return the mean-square slope of the waves below a cut-off frequency (deep water)."""
        if self.wind_speed_m_s == 0.0:
            return 0.0
        _, step, of_slope = _below(self, cutoff_rad_s)
        return float(of_slope @ step) / pierson_moskowitz.GRAVITY_M_S2**2

    def slope_frequencies_rad_s(self, count: int, cutoff_rad_s: float) -> NDArray[np.float64]:
        """Return ascending frequencies (count,), medians of equal shares of the resolved mean-square slope."""
        omega, step, of_slope = _below(self, cutoff_rad_s)
        share = np.cumsum(of_slope * step)
        middle = (np.arange(count) + 0.5) / count
        return np.asarray(np.interp(middle, share / share[-1], omega * np.exp(0.5 * step / omega)))

    def _frequencies(self, cutoff_rad_s: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return frequencies up to a cut-off, evenly spaced in their logarithm, and their widths."""
        # Below the peak both spectra decrease faster than any power: exp(-1.25 * 0.3^-4) is e^-154.
        low = min(0.3 * self.peak_frequency_rad_s, 0.5 * cutoff_rad_s)
        width = math.log(cutoff_rad_s / low) / _STEPS
        omega = low * np.exp((np.arange(_STEPS) + 0.5) * width)
        return omega, omega * width


@lru_cache(maxsize=16)
def _below(spectrum: WaveSpectrum, cutoff_rad_s: float) -> tuple[NDArray[np.float64], ...]:
    """Return frequencies below a cut-off, their widths, and g^2 times the spectrum of slope, which seeds share."""
    omega, step = spectrum._frequencies(cutoff_rad_s)
    of_slope: NDArray[np.float64] = omega**4 * spectrum.density_m2_s(omega)
    return omega, step, of_slope
