"""Refractive index of sea water, and foam.

Foam is Lambertian and opaque. Its reflectance in sunlight is the effective one of whitecaps
of all ages, 0.22 in the visible (P. Koepke, Effective reflectance of oceanic whitecaps, Appl. Opt. 23, 1816-1824,
1984), decreasing in the infrared as measured up to 1.65 um by R. Frouin, M. Schwindling and P.-Y. Deschamps, Spectral
reflectance of sea foam in the visible and near-infrared, J. Geophys. Res. 101, 14361-14371 (1996); from 2 um on it is 1
minus the thermal emissivity.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import Problem, ScenarioError
from hcss_twin.models.parameters import RoughSeaParameters
from hcss_twin.models.refractive_index import RefractiveIndex, load_refractive_index
from hcss_twin.models.sea.slope_statistics import MEASURED_WIND_M_S
from hcss_twin.models.sea.wave_spectrum import WaveSpectrum
from hcss_twin.providers import SeaInputs

WARM_K, COLD_K = 298.15, 273.15
ALLOWED_K = (263.15, 318.15)
ALLOWED_SALINITY_PSU = (0.0, 45.0)
SALINE_N_PER_PSU = 0.006 / 34.3
"""McLellan, Elements of Physical Oceanography (1965), p 129; Friedman, Appl. Opt. 8, 2073 (1969)."""


@dataclass(frozen=True, eq=False)
class SeaWater:
    """Refractive index n + ik of sea water.

    Between 0 and 25 degC, the index varies by the difference of two pure-water tables, scaled with temperature: Rowe et
    al. (2020) at 273.15 K and Hale and Querry (1973) at 298.15 K; n and ln k are linear. Outside this range both are
    extrapolated. Salt increases n by 0.006 at 34.3 psu, in proportion to salinity, and does not change k.

    Attributes
    ----------
    base : RefractiveIndex
        Table at 298.15 K.
    cold, warm : RefractiveIndex or None
        The pair whose difference gives the temperature dependence; None omits it.
    temperature_K, salinity_psu : float
        Of the water.
    """

    base: RefractiveIndex
    cold: RefractiveIndex | None
    warm: RefractiveIndex | None
    temperature_K: float
    salinity_psu: float

    @property
    def valid_cm1(self) -> tuple[float, float]:
        """Wavenumber range covered by all tables."""
        tables = [table.valid_cm1 for table in (self.base, self.cold, self.warm) if table is not None]
        return max(low for low, _ in tables), min(high for _, high in tables)

    def at(self, wavenumber_cm1: NDArray[np.float64]) -> NDArray[np.complex128]:
        """Return n + ik (V,) at ``wavenumber_cm1`` (V,).

        Raises
        ------
        ValueError
            If a wavenumber lies outside a table.
        """
        index = self.base.at(wavenumber_cm1)
        n, k = index.real, index.imag
        if self.cold is not None and self.warm is not None:
            part = (WARM_K - self.temperature_K) / (WARM_K - COLD_K)
            cold, warm = self.cold.at(wavenumber_cm1), self.warm.at(wavenumber_cm1)
            n = n + part * (cold.real - warm.real)
            k = k * (cold.imag / warm.imag) ** part
        return np.asarray(n + SALINE_N_PER_PSU * self.salinity_psu + 1j * k, dtype=np.complex128)


def load_sea_water(
    catalog: Catalog, name: str, temperature_K: float, salinity_psu: float, *, by_temperature: bool
) -> SeaWater:
    """Read the refractive-index tables of sea water.

    Raises
    ------
    ScenarioError
        If the temperature (if used) is out of range.
    ValueError
        If the salinity is out of range.
    CatalogError
        If a table cannot be read.
    """
    low, high = ALLOWED_SALINITY_PSU
    if not low <= salinity_psu <= high:
        raise ValueError(f"salinity_psu {salinity_psu}: allowed {low:g} to {high:g}")
    base = load_refractive_index(catalog, name)
    if not by_temperature:
        return SeaWater(base, None, None, temperature_K, salinity_psu)
    if not ALLOWED_K[0] <= temperature_K <= ALLOWED_K[1]:
        message = (
            f"{temperature_K:g} K is outside the range of the refractive index of sea water; allowed: "
            f"{ALLOWED_K[0]:g} to {ALLOWED_K[1]:g} K, or any with sea.parameters.water_temperature = false, which "
            f"takes the index at {WARM_K:g} K"
        )
        raise ScenarioError([Problem("sea.temperature", message)])
    cold, warm = load_refractive_index(catalog, "water-273K"), load_refractive_index(catalog, "water")
    return SeaWater(base, cold, warm, temperature_K, salinity_psu)


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
    """Return the foam-covered fraction of the sea, a U^b, at most 1; U at 10 m.

    Raises
    ------
    ValueError
        If the wind speed is negative or not finite.
    """
    if not (np.isfinite(wind_speed_m_s) and wind_speed_m_s >= 0.0):
        raise ValueError(f"wind_speed_m_s {wind_speed_m_s}: allowed finite, at least 0")
    factor, exponent = _LAWS[law]
    # The laws were fitted below 20 m/s; the power law reaches full coverage at 39 m/s or below.
    return float(min(factor * wind_speed_m_s**exponent, 1.0))


def foam_reflectance(wavenumber_cm1: NDArray[np.float64], thermal_emissivity: float) -> NDArray[np.float64]:
    """Return the Lambertian reflectance (V,) of foam; its emissivity is 1 minus this.

    Parameters
    ----------
    wavenumber_cm1 : ndarray (V,)
        Wavenumbers, above 0.
    thermal_emissivity : float
        Emissivity wherever the solar reflectance is at most 1 minus this value, in [0, 1].
    """
    wavelength_um = 1e4 / np.asarray(wavenumber_cm1, dtype=np.float64)
    solar = _VISIBLE * np.interp(wavelength_um, _SHAPE_UM, _SHAPE)
    return np.asarray(np.maximum(solar, 1.0 - thermal_emissivity), dtype=np.float64)


OWN_ERRORS = (
    "sea: emissivity within 0.0004 to 75 deg and 0.004 to 85 deg of rays followed over random surfaces (10.8 um, "
    "winds to 30 m/s)",
)
"""With shadowing and second reflection (docs/development/optics-sea-and-air.md)."""


def notes(inputs: SeaInputs, parameters: RoughSeaParameters, foam: float) -> tuple[str, ...]:
    """Return notes on extrapolated laws and the effects of options; ``foam`` is the foam coverage."""
    texts = []
    low, high = MEASURED_WIND_M_S
    if not low <= inputs.wind_speed_m_s <= high:
        texts.append(
            f"sea: wind {inputs.wind_speed_m_s:g} m/s is outside {low:g} to {high:g} m/s, where Cox and Munk "
            "measured slopes; their laws are extrapolated"
        )
    if parameters.water_temperature and not COLD_K <= inputs.temperature_K <= WARM_K:
        texts.append(
            f"sea: water of {inputs.temperature_K:g} K is outside {COLD_K:g} to {WARM_K:g} K; its refractive "
            "index is extrapolated"
        )
    if parameters.shadowing == "none":
        texts.append("sea: waves do not hide one another; the BRDF reflects too much toward grazing views")
    if not parameters.re_reflection:
        texts.append("sea: no second reflection; emissivity is too low toward grazing views")
    if parameters.slopes != "isotropic":
        texts.append("sea: slopes depend on the bearing to the wind; calls without a bearing give the mean")
    if parameters.spectrum == "jonswap" and inputs.wind_speed_m_s > 0.0:
        grown, whole = (
            WaveSpectrum(name, inputs.wind_speed_m_s, parameters.fetch_m).peak_frequency_rad_s
            for name in ("jonswap", "pierson-moskowitz")
        )
        if grown < whole:
            texts.append(
                f"sea: after {parameters.fetch_m / 1e3:g} km at {inputs.wind_speed_m_s:g} m/s the sea is fully "
                "developed; JONSWAP lets the waves grow beyond that"
            )
    if foam > 0.1:
        texts.append(f"sea: {100 * foam:.0f} % under foam; the coverage law was fitted to less than 10 %")
    return tuple(texts)
