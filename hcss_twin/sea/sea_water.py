"""Refractive index of sea water: a table at one temperature, moved to another and to a salinity."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcss_twin.catalog import Catalog
from hcss_twin.refractive_index import RefractiveIndex, load_refractive_index

WARM_K, COLD_K = 298.15, 273.15
ALLOWED_K = (263.15, 318.15)
ALLOWED_SALINITY_PSU = (0.0, 45.0)
SALINE_N_PER_PSU = 0.006 / 34.3
"""McLellan, Elements of Physical Oceanography (1965), p 129; Friedman, Appl. Opt. 8, 2073 (1969)."""


@dataclass(frozen=True, eq=False)
class SeaWater:
    """n + ik of sea water.

    Between 0 and 25 degC the difference of two tables of pure water is scaled with temperature: Rowe et al.
    (2020) at 273.15 K and Hale and Querry (1973) at 298.15 K; n is linear and ln k is linear. Beyond, both
    are extrapolated. Salt raises n by 0.006 at 34.3 psu, in proportion to salinity, and leaves k.

    Attributes
    ----------
    base : RefractiveIndex
        Table at 298.15 K.
    cold, warm : RefractiveIndex or None
        The pair whose difference gives the temperature dependence; None leaves it out.
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
        """Range of wavenumbers that all tables cover."""
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
    """Read the tables of a sea's water.

    Raises
    ------
    ValueError
        If temperature (when used) or salinity is outside its range.
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
        raise ValueError(
            f"temperature_K {temperature_K} of the sea: its refractive index is known for {ALLOWED_K[0]} to "
            f"{ALLOWED_K[1]}; water_temperature = false takes the table's temperature instead"
        )
    cold, warm = load_refractive_index(catalog, "water-273K"), load_refractive_index(catalog, "water")
    return SeaWater(base, cold, warm, temperature_K, salinity_psu)
