"""Complex refractive index of water and ice from a catalog table."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import CatalogError


@dataclass(frozen=True, eq=False)
class RefractiveIndex:
    """Tabulated n + ik; n and ln k are interpolated linearly in ln wavelength.

    Attributes
    ----------
    name : str
        Name in the catalog, for messages.
    wavelength_um : ndarray (T,)
        Ascending.
    n, k : ndarray (T,)
        Real and imaginary part, both above 0.
    """

    name: str
    wavelength_um: Array
    n: Array
    k: Array

    @property
    def valid_cm1(self) -> tuple[float, float]:
        """Lowest and highest wavenumber of the table."""
        return float(1e4 / self.wavelength_um[-1]), float(1e4 / self.wavelength_um[0])

    def at(self, wavenumber_cm1: Array) -> NDArray[np.complex128]:
        """Return n + ik (V,) at ``wavenumber_cm1`` (V,).

        Raises
        ------
        ValueError
            If a wavenumber lies outside the table.
        """
        wavenumber = np.asarray(wavenumber_cm1, dtype=np.float64)
        low, high = self.valid_cm1
        if not np.all((wavenumber >= low) & (wavenumber <= high)):
            raise ValueError(
                f"wavenumber_cm1 between {np.min(wavenumber):g} and {np.max(wavenumber):g}: the refractive "
                f"index '{self.name}' covers {low:g} to {high:g} cm-1 "
                f"({self.wavelength_um[0]:g} to {self.wavelength_um[-1]:g} um)"
            )
        position, nodes = np.log(1e4 / wavenumber), np.log(self.wavelength_um)
        real = np.interp(position, nodes, self.n)
        imaginary = np.exp(np.interp(position, nodes, np.log(self.k)))
        return np.asarray(real + 1j * imaginary, dtype=np.complex128)


def load_refractive_index(catalog: Catalog, name: str) -> RefractiveIndex:
    """Read ``optical_constants/<name>.csv`` (columns wavelength_um, n, k) or a user file in that format.

    Raises
    ------
    CatalogError
        If the file is missing or lacks a column, the wavelengths do not ascend, or an n or k is not above 0.
    """
    path = catalog.find(name, "optical_constants", ".csv")
    columns = catalog.columns(path)
    missing = [column for column in ("wavelength_um", "n", "k") if column not in columns]
    if missing:
        raise CatalogError(f"{path}: column {', '.join(missing)} missing; it has {', '.join(columns)}")
    table = RefractiveIndex(name, columns["wavelength_um"], columns["n"], columns["k"])
    if table.wavelength_um.size < 2 or not np.all(np.diff(table.wavelength_um) > 0.0):
        raise CatalogError(f"{path}: wavelength_um must increase over at least two rows")
    if not (table.wavelength_um[0] > 0.0 and np.all(table.n > 0.0) and np.all(table.k > 0.0)):
        raise CatalogError(f"{path}: wavelength_um, n and k must be above 0")
    return table


def load_water_at(catalog: Catalog, temperature_K: float) -> RefractiveIndex:
    """Interpolate the refractive index of liquid water in temperature between the tables ``water-<T>K``.

    n and ln k are interpolated linearly between the two nearest tables, which must have the same wavelengths.

    Raises
    ------
    ValueError
        If the temperature lies outside the tables.
    CatalogError
        If there are no tables, or two neighbouring tables have different wavelengths.
    """
    matches = (re.fullmatch(r"water-(\d+)K", name) for name in catalog.names("optical_constants", ".csv"))
    known = sorted(int(match[1]) for match in matches if match)
    if not known:
        raise CatalogError(f"{catalog.root / 'optical_constants'}: no table water-<T>K.csv")
    if not known[0] <= temperature_K <= known[-1]:
        closest = known[0] if temperature_K < known[0] else known[-1]
        raise ValueError(
            f"water temperature {temperature_K:g} K: the tables allow {known[0]} to {known[-1]} K; closest is {closest}"
        )
    low = max(kelvin for kelvin in known if kelvin <= temperature_K)
    cold = load_refractive_index(catalog, f"water-{low}K")
    if low == temperature_K:
        return cold
    high = min(kelvin for kelvin in known if kelvin > temperature_K)
    warm = load_refractive_index(catalog, f"water-{high}K")
    if not np.array_equal(cold.wavelength_um, warm.wavelength_um):
        raise CatalogError(f"optical_constants water-{low}K and water-{high}K: their wavelengths differ")
    share = (temperature_K - low) / (high - low)
    n = (1.0 - share) * cold.n + share * warm.n
    k = np.exp((1.0 - share) * np.log(cold.k) + share * np.log(warm.k))
    return RefractiveIndex(f"water at {temperature_K:g} K", cold.wavelength_um, n, k)
