"""Slope statistics of the wind-roughened sea, for the whole sea and about the tilt of a resolved wave.

C. Cox and W. Munk, Measurement of the roughness of the sea surface from photographs of the sun's glitter, J. Opt. Soc.
Am. 44, 838-850 (1954), clean surface: sun glitter off Hawaii, winds of 1 to 14 m/s at 12.5 m (41 ft) above the sea.
The first axis of the slope frame points upwind.

A Gaussian sea is a sum of independent waves, whose variances add: resolved slopes with one part of the variance, and
subpixel facets about them with the rest, together have the slope density of the whole sea. The cross-section of a
tilted part depends on the direction; weighted with it, the light of the parts adds up exactly to that of the whole sea.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import Problem, ProviderError, ScenarioError
from hcss_twin.models.sea.wave_field import cutoff_frequency_rad_s
from hcss_twin.models.sea.wave_spectrum import WaveSpectrum

MEASURED_WIND_M_S = (1.0, 14.0)
ALLOWED_WIND_M_S = (0.0, 60.0)


def mean_square_slope(wind_speed_m_s: float) -> float:
    """Return the total mean-square slope, upwind plus crosswind: 0.003 + 0.00512 U.

    Parameters
    ----------
    wind_speed_m_s : float
        Wind speed U at 12.5 m, 0 to 60; measured for 1 to 14 with an uncertainty of 0.004 in the result.

    Returns
    -------
    float
        Dimensionless; the variance of each slope component is half of it.

    Raises
    ------
    ValueError
        If the wind speed is outside 0 to 60 m/s.
    """
    low, high = ALLOWED_WIND_M_S
    if not low <= wind_speed_m_s <= high:
        raise ValueError(f"wind_speed_m_s {wind_speed_m_s}: allowed {low:g} to {high:g} m/s")
    return 0.003 + 0.00512 * wind_speed_m_s


def slope_density(slope_squared: NDArray[np.float64], mean_square_slope: float) -> NDArray[np.float64]:
    """Return the isotropic Gaussian density of slopes, per unit of slope squared.

    Parameters
    ----------
    slope_squared : ndarray
        zx^2 + zy^2, the squared tangent of the facet's tilt; any shape.
    mean_square_slope : float
        Total mean-square slope, above 0.

    Returns
    -------
    ndarray
        exp(-slope_squared / s) / (pi s) with s the mean-square slope; integrates to 1 over (zx, zy).
    """
    density = np.exp(-slope_squared / mean_square_slope) / (np.pi * mean_square_slope)
    return np.asarray(density, dtype=np.float64)


SlopeLaw = Literal["isotropic", "upwind-crosswind", "gram-charlier"]
GRAM_CHARLIER_WIND_M_S = (0.0, 20.0)
_RATIO_FROM_M_S = 1.0
"""Below this wind speed the variance ratio is constant: the upwind law has no offset and would vanish in calm."""
_PEAKEDNESS = (0.40, 0.12, 0.23)
_TAIL_SIGMA = 8.0


@dataclass(frozen=True)
class SlopeStatistics:
    """Density of slopes.

    Attributes
    ----------
    variance_upwind, variance_crosswind : float
        Variances of the two components, above 0.
    skewness : (float, float)
        c21 and c03 of the Gram-Charlier series; 0 for a Gaussian.
    peakedness : (float, float, float)
        c40, c22 and c04; 0 for a Gaussian.
    norm : float
        Integral of the series after negative values were set to 0; the density is divided by it.
    """

    variance_upwind: float
    variance_crosswind: float
    skewness: tuple[float, float] = (0.0, 0.0)
    peakedness: tuple[float, float, float] = (0.0, 0.0, 0.0)
    norm: float = 1.0

    @property
    def mean_square_slope(self) -> float:
        """Sum of the two variances (of the Gaussian part)."""
        return self.variance_upwind + self.variance_crosswind

    @property
    def isotropic(self) -> bool:
        """Whether the density is the same in every direction."""
        return self.gaussian and self.variance_upwind == self.variance_crosswind

    @property
    def gaussian(self) -> bool:
        """Whether the series has no terms beyond the Gaussian."""
        return not any((*self.skewness, *self.peakedness))

    def variance_along(self, wind_azimuth: NDArray[np.float64] | float) -> NDArray[np.float64]:
        """Return the slope variance along a bearing relative to the wind (radians, any shape)."""
        cos2 = np.cos(wind_azimuth) ** 2
        return np.asarray(self.variance_upwind * cos2 + self.variance_crosswind * (1.0 - cos2))

    def density(self, upwind: NDArray[np.float64], crosswind: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the density at slopes (upwind, crosswind), which broadcast; integrates to 1.

        Notes
        -----
        Cox and Munk 1954, eq 18, with xi the crosswind and eta the upwind slope, divided by their standard deviations.
        Where the series is negative, at large slopes, the density is 0.
        """
        eta2 = upwind**2 / self.variance_upwind
        xi2 = crosswind**2 / self.variance_crosswind
        peak = 2.0 * np.pi * np.sqrt(self.variance_upwind * self.variance_crosswind)
        gauss = np.exp(-0.5 * (eta2 + xi2)) / peak
        if self.gaussian:
            return np.asarray(gauss, dtype=np.float64)
        eta = upwind / np.sqrt(self.variance_upwind)
        (c21, c03), (c40, c22, c04) = self.skewness, self.peakedness
        series = (
            1.0
            - c21 / 2.0 * (xi2 - 1.0) * eta
            - c03 / 6.0 * (eta2 - 3.0) * eta
            + c40 / 24.0 * (xi2**2 - 6.0 * xi2 + 3.0)
            + c22 / 4.0 * (xi2 - 1.0) * (eta2 - 1.0)
            + c04 / 24.0 * (eta2**2 - 6.0 * eta2 + 3.0)
        )
        return np.asarray(gauss * np.maximum(series, 0.0) / self.norm, dtype=np.float64)


def slope_statistics(wind_speed_m_s: float, law: SlopeLaw) -> SlopeStatistics:
    """Return the slope statistics at a wind speed.

    Parameters
    ----------
    wind_speed_m_s : float
        0 to 60; 0 to 20 for the Gram-Charlier series, whose skewness grows with the wind (measured: 1 to 14).
    law : {"isotropic", "upwind-crosswind", "gram-charlier"}
        Two halves of 0.003 + 0.00512 U; 0.00316 U upwind and 0.003 + 0.00192 U crosswind; the same with
        skewness (0.01 - 0.0086 U, 0.04 - 0.033 U) and peakedness (0.40, 0.12, 0.23).

    Raises
    ------
    ValueError, ScenarioError
        If the wind speed is outside the range of Cox and Munk's laws, or that of the Gram-Charlier series.
    """
    total = mean_square_slope(wind_speed_m_s)
    if law == "isotropic":
        return SlopeStatistics(0.5 * total, 0.5 * total)
    wind = max(wind_speed_m_s, _RATIO_FROM_M_S)
    upwind, crosswind = 0.00316 * wind, 0.003 + 0.00192 * wind
    scale = (0.003 + 0.00508 * wind_speed_m_s) / (upwind + crosswind)
    upwind, crosswind = scale * upwind, scale * crosswind
    if law == "upwind-crosswind":
        return SlopeStatistics(upwind, crosswind)
    low, high = GRAM_CHARLIER_WIND_M_S
    if not low <= wind_speed_m_s <= high:
        message = (
            f"{wind_speed_m_s:g} m/s with sea.parameters.slopes = 'gram-charlier'; allowed: {low:g} to {high:g} m/s, "
            f"or up to {ALLOWED_WIND_M_S[1]:g} m/s with slopes = 'upwind-crosswind'"
        )
        raise ScenarioError([Problem("sea.wind_speed", message)])
    skewness = (0.01 - 0.0086 * wind_speed_m_s, 0.04 - 0.033 * wind_speed_m_s)
    raw = SlopeStatistics(1.0, 1.0, skewness, _PEAKEDNESS)
    # A sum over a fine grid: the density has kinks where the series changes sign, and vanishes at the edge.
    axis = np.asarray((np.arange(800) + 0.5) * (_TAIL_SIGMA / 400) - _TAIL_SIGMA, dtype=np.float64)
    norm = float(raw.density(axis[:, None], axis[None, :]).sum()) * (axis[1] - axis[0]) ** 2
    return SlopeStatistics(upwind, crosswind, skewness, _PEAKEDNESS, norm)


UPWIND_SHARE = 0.75
"""Fraction of the resolved mean-square slope along the wind, for wave directions with the density 2/pi cos^2."""


@dataclass(frozen=True)
class Tilt:
    """Mean slope, and statistics of the facets about it.

    Attributes
    ----------
    upwind, crosswind : float
        Slope along the bearing that the wind comes from, and at right angles to it in the direction of increasing
        ``wind_azimuth``.
    rest : SlopeStatistics
        Of the subpixel facets, about the mean slope.
    """

    upwind: float
    crosswind: float
    rest: SlopeStatistics

    def turned(self, wind_azimuth: Array | float) -> tuple[Array, Array]:
        """Return the mean slope along and across a bearing relative to the wind (radians, any shape)."""
        cosine, sine = np.cos(wind_azimuth), np.sin(wind_azimuth)
        along = self.upwind * cosine + self.crosswind * sine
        return np.asarray(along), np.asarray(self.crosswind * cosine - self.upwind * sine)

    def cross_section(self, mu: Array, wind_azimuth: Array) -> Array:
        """Return the projected area (M,) of facets that face each view, per horizontal area; above 0.

        The mean of max(mu - z sin(zenith), 0) over Gaussian slopes z along the view. For the sea as a whole it is mu (1
        + Lambda), see :func:`hcss_twin.models.sea.facets.smith_lambda`.
        """
        from scipy.special import ndtr  # takes 0.1 s to import

        sine = np.sqrt((1.0 - mu) * (1.0 + mu))
        middle = mu - self.turned(wind_azimuth)[0] * sine
        width = np.maximum(np.sqrt(self.rest.variance_along(wind_azimuth)) * sine, 1e-12)
        # At 30 standard deviations the density is 0 in double precision; the area stays above 0.
        far = np.maximum(middle / width, -30.0)
        density = np.exp(-0.5 * far**2) / np.sqrt(2.0 * np.pi)
        return np.asarray(np.maximum(width * (far * ndtr(far) + density), 1e-200), dtype=np.float64)


def resolved_variances(spectrum: WaveSpectrum, pixel_size_m: float) -> tuple[float, float]:
    """Return the variances of the resolved slopes (upwind, crosswind).

    Raises
    ------
    ValueError
        If the pixel size is not above 0.
    """
    total = spectrum.resolved_mean_square_slope(cutoff_frequency_rad_s(pixel_size_m))
    return UPWIND_SHARE * total, (1.0 - UPWIND_SHARE) * total


def unresolved(slopes: SlopeStatistics, spectrum: WaveSpectrum, pixel_size_m: float) -> SlopeStatistics:
    """Return the statistics of the subpixel slopes.

    Raises
    ------
    ProviderError
        If the sea's slopes are not Gaussian, or the resolved waves alone are as rough as the sea.
    """
    if not slopes.gaussian:
        raise ProviderError(
            "slopes 'gram-charlier' with resolved waves: their skewness cannot be divided between waves and facets; "
            "allowed: 'isotropic', 'upwind-crosswind'"
        )
    upwind, crosswind = resolved_variances(spectrum, pixel_size_m)
    rest = SlopeStatistics(slopes.variance_upwind - upwind, slopes.variance_crosswind - crosswind)
    if min(rest.variance_upwind, rest.variance_crosswind) <= 0.0:
        raise ProviderError(
            f"waves longer than {2.0 * pixel_size_m:g} m have slope variances of {upwind:.3g} upwind and "
            f"{crosswind:.3g} crosswind, the whole sea only {slopes.variance_upwind:.3g} and "
            f"{slopes.variance_crosswind:.3g}: waves cannot be resolved with pixels this small; allowed: larger pixels"
        )
    return rest
