"""A part of the sea that a resolved wave tilts: the mean slope of its facets, and what is left around it.

A Gaussian sea is the sum of independent waves, so that their variances add: slopes of the resolved waves with one
part of the variance, and about each of them the facets below the pixel with the rest, together have the density of
the whole sea. Seen from one direction a tilted part has another cross-section; weighted with it, what the parts
send adds up to what the sea sends as a whole, exactly.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from hcss_twin.errors import ProviderError
from hcss_twin.sea.slope_statistics import SlopeStatistics
from hcss_twin.sea.wave_field import cutoff_frequency_rad_s
from hcss_twin.sea.wave_spectrum import WaveSpectrum

Array = NDArray[np.float64]

UPWIND_SHARE = 0.75
"""Share of the resolved mean-square slope along the wind: waves scatter about it with the density 2/pi cos^2."""


@dataclass(frozen=True)
class Tilt:
    """A mean slope and the statistics of the facets about it.

    Attributes
    ----------
    upwind, crosswind : float
        Slope along the bearing the wind comes from, and at right angles to it in the sense in which ``wind_azimuth``
        is counted.
    rest : SlopeStatistics
        Of the facets below the pixel, about the mean slope.
    """

    upwind: float
    crosswind: float
    rest: SlopeStatistics

    def turned(self, wind_azimuth: Array | float) -> tuple[Array, Array]:
        """Return the mean slope along and across a bearing counted from the wind's (radians, any shape)."""
        cosine, sine = np.cos(wind_azimuth), np.sin(wind_azimuth)
        along = self.upwind * cosine + self.crosswind * sine
        return np.asarray(along), np.asarray(self.crosswind * cosine - self.upwind * sine)

    def cross_section(self, mu: Array, wind_azimuth: Array) -> Array:
        """Return the area (M,) that the facets turned toward views show, per horizontal area; above 0.

        The mean of max(mu - z sin(zenith), 0) over Gaussian slopes z along the view. For the sea as a whole it is
        mu (1 + Lambda), see :func:`hcss_twin.sea.shadowing.smith_lambda`.
        """
        sine = np.sqrt((1.0 - mu) * (1.0 + mu))
        middle = mu - self.turned(wind_azimuth)[0] * sine
        width = np.maximum(np.sqrt(self.rest.variance_along(wind_azimuth)) * sine, 1e-12)
        # 30 widths out the density is 0 in double precision; the area stays above 0.
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
    """Return the statistics of the slopes below the pixel.

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
            f"{slopes.variance_crosswind:.3g}: pixels so small cannot be resolved; allowed: larger ones"
        )
    return rest
