"""Complex refractive index of sea water from a catalog table."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcss_twin.catalog import Catalog
from hcss_twin.errors import CatalogError


@dataclass(frozen=True)
class RefractiveIndex:
    """A tabulated refractive index n + i k, both interpolated linearly in wavelength.

    With Hale and Querry's table, interpolating ln k in ln wavelength instead changes the reflectance of a
    flat surface by at most 0.0004 at nadir and 0.001 at 60 degrees (2.6 to 14 um).

    Attributes
    ----------
    name : str
        Name in the catalog, or the user's path.
    wavelength_um : ndarray (N,)
        Ascending vacuum wavelengths.
    n, k : ndarray (N,)
        Real and imaginary part; k >= 0 absorbs.
    """

    name: str
    wavelength_um: NDArray[np.float64]
    n: NDArray[np.float64]
    k: NDArray[np.float64]

    @classmethod
    def from_catalog(cls, catalog: Catalog, name: str) -> RefractiveIndex:
        """Read the table ``name`` from ``optical_constants`` or from a user's CSV file.

        Raises
        ------
        CatalogError
            If there is no such table, a column is missing, or the wavelengths do not ascend.
        """
        path = catalog.find(name, "optical_constants", ".csv")
        columns = catalog.columns(path)
        missing = [column for column in ("wavelength_um", "n", "k") if column not in columns]
        if missing:
            raise CatalogError(f"{path}: column {', '.join(missing)} missing; needs wavelength_um, n, k")
        wavelength_um, n, k = columns["wavelength_um"], columns["n"], columns["k"]
        if wavelength_um.size < 2 or wavelength_um[0] <= 0.0 or np.any(np.diff(wavelength_um) <= 0.0):
            raise CatalogError(f"{path}: wavelength_um must be positive, ascending, at least two rows")
        if np.any(n <= 0.0) or np.any(k < 0.0):
            raise CatalogError(f"{path}: needs n > 0 and k >= 0")
        return cls(name, wavelength_um, n, k)

    @property
    def valid_cm1(self) -> tuple[float, float]:
        """Lowest and highest wavenumber of the table."""
        return float(1e4 / self.wavelength_um[-1]), float(1e4 / self.wavelength_um[0])

    def at(self, wavenumber_cm1: NDArray[np.float64]) -> NDArray[np.complex128]:
        """Return n + i k (V,) at ``wavenumber_cm1`` (V,).

        Raises
        ------
        ValueError
            If a wavenumber is outside the table.
        """
        wavenumber = np.asarray(wavenumber_cm1, dtype=np.float64)
        low, high = self.valid_cm1
        if not np.all((wavenumber >= low) & (wavenumber <= high)):
            raise ValueError(
                f"wavenumber_cm1 between {np.min(wavenumber):g} and {np.max(wavenumber):g}: the refractive "
                f"index '{self.name}' covers {low:g} to {high:g} cm-1 "
                f"({self.wavelength_um[0]:g} to {self.wavelength_um[-1]:g} um)"
            )
        wavelength_um = 1e4 / wavenumber
        n = np.interp(wavelength_um, self.wavelength_um, self.n)
        k = np.interp(wavelength_um, self.wavelength_um, self.k)
        return np.asarray(n + 1j * k, dtype=np.complex128)
