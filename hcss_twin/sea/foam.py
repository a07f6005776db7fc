"""Foam: how much of the sea it covers, and what it reflects.

Foam is Lambertian and absorbs what it does not reflect. Its reflectance in sunlight is the effective one of
whitecaps of all ages, 0.22 in the visible (P. Koepke, Effective reflectance of oceanic whitecaps, Appl. Opt.
23, 1816-1824, 1984), falling into the infrared as R. Frouin, M. Schwindling and P.-Y. Deschamps, Spectral
reflectance of sea foam in the visible and near-infrared, J. Geophys. Res. 101, 14361-14371 (1996), measured
to 1.65 um; from 2 um on it is what the thermal emissivity leaves.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

FoamLaw = Literal["monahan-1980", "monahan-1980-least-squares", "monahan-1986"]

# Coverage = a U^b. E. C. Monahan and I. O'Muircheartaigh, J. Phys. Oceanogr. 10, 2094-2099 (1980): robust
# biweight and ordinary least-squares fit; Int. J. Remote Sens. 7, 627-642 (1986), with air and sea equally warm.
_LAWS: dict[FoamLaw, tuple[float, float]] = {
    "monahan-1980": (3.84e-6, 3.41),
    "monahan-1980-least-squares": (2.95e-6, 3.52),
    "monahan-1986": (1.95e-5, 2.55),
}
_VISIBLE = 0.22
_SHAPE_UM = (0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.7, 1.8, 1.9, 2.0)
_SHAPE = (1.0, 0.95, 0.9, 0.7, 0.55, 0.5, 0.45, 0.4, 0.35, 0.3, 0.25, 0.2, 0.15, 0.1, 0.05, 0.0)


def foam_coverage(wind_speed_m_s: float, law: FoamLaw) -> float:
    """Return the fraction of the sea under foam, a U^b, at most 1; U at 10 m.

    Raises
    ------
    ValueError
        If the wind speed is negative or not finite.
    """
    if not (np.isfinite(wind_speed_m_s) and wind_speed_m_s >= 0.0):
        raise ValueError(f"wind_speed_m_s {wind_speed_m_s}: allowed finite, at least 0")
    factor, exponent = _LAWS[law]
    # The laws were fitted below 20 m/s; the power reaches the whole sea at 39 m/s or earlier.
    return float(min(factor * wind_speed_m_s**exponent, 1.0))


def foam_reflectance(wavenumber_cm1: NDArray[np.float64], thermal_emissivity: float) -> NDArray[np.float64]:
    """Return the Lambertian reflectance (V,) of foam; its emissivity is 1 minus this.

    Parameters
    ----------
    wavenumber_cm1 : ndarray (V,)
        Wavenumbers, above 0.
    thermal_emissivity : float
        Emissivity wherever the solar reflectance does not exceed 1 minus it, in [0, 1].
    """
    wavelength_um = 1e4 / np.asarray(wavenumber_cm1, dtype=np.float64)
    solar = _VISIBLE * np.interp(wavelength_um, _SHAPE_UM, _SHAPE)
    return np.asarray(np.maximum(solar, 1.0 - thermal_emissivity), dtype=np.float64)
