"""Slope statistics of the wind-roughened sea (Cox and Munk 1954), isotropic form.

The measurements (sun glitter off Hawaii) span winds of 1 to 14 m/s at 12.5 m (41 ft) above the sea.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

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
        Dimensionless; each of the two slope components has half of it as variance.

    Raises
    ------
    ValueError
        If the wind speed is outside 0 to 60 m/s.

    Notes
    -----
    C. Cox and W. Munk, Measurement of the roughness of the sea surface from photographs of the sun's
    glitter, J. Opt. Soc. Am. 44, 838-850 (1954), clean surface.
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
