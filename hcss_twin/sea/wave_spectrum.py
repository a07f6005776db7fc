"""Frequency spectra of wave height as one interface: heights, resolved slopes, equal shares of slope."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from hcss_twin.sea import jonswap, pierson_moskowitz

Spectrum = Literal["pierson-moskowitz", "jonswap"]
GRAVITY_M_S2 = pierson_moskowitz.GRAVITY_M_S2
_STEPS = 4000


@dataclass(frozen=True)
class WaveSpectrum:
    """A spectrum at one wind.

    Attributes
    ----------
    name : {"pierson-moskowitz", "jonswap"}
        Fully developed sea, or one that grew over ``fetch_m``.
    wind_speed_m_s : float
        Wind speed (at 19.5 m and 10 m respectively), at least 0; 0 gives a calm sea.
    fetch_m : float
        Used by JONSWAP only.
    """

    name: Spectrum
    wind_speed_m_s: float
    fetch_m: float = 100e3

    def density_m2_s(self, omega_rad_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the spectrum of elevation, m^2 per rad/s, at angular frequencies of any shape."""
        if self.name == "jonswap":
            return jonswap.spectrum_m2_s(omega_rad_s, self.wind_speed_m_s, self.fetch_m)
        return pierson_moskowitz.spectrum_m2_s(omega_rad_s, self.wind_speed_m_s)

    @property
    def peak_frequency_rad_s(self) -> float:
        """Frequency of the maximum; the wind must be above 0."""
        if self.name == "jonswap":
            return jonswap.peak_frequency_rad_s(self.wind_speed_m_s, self.fetch_m)
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
        omega, step = self._frequencies(cutoff_rad_s)
        return float((omega**4 * self.density_m2_s(omega)) @ step) / GRAVITY_M_S2**2

    def slope_frequencies_rad_s(self, count: int, cutoff_rad_s: float) -> NDArray[np.float64]:
        """Return ascending frequencies (count,), medians of equal shares of the resolved mean-square slope."""
        omega, step = self._frequencies(cutoff_rad_s)
        share = np.cumsum(omega**4 * self.density_m2_s(omega) * step)
        middle = (np.arange(count) + 0.5) / count
        return np.asarray(np.interp(middle, share / share[-1], omega * np.exp(0.5 * step / omega)))

    def _frequencies(self, cutoff_rad_s: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return frequencies up to a cut-off, evenly spaced in their logarithm, and their widths."""
        # Both spectra vanish faster than any power below the peak: exp(-1.25 * 0.3^-4) is e^-154.
        low = min(0.3 * self.peak_frequency_rad_s, 0.5 * cutoff_rad_s)
        width = math.log(cutoff_rad_s / low) / _STEPS
        omega = low * np.exp((np.arange(_STEPS) + 0.5) * width)
        return omega, omega * width
