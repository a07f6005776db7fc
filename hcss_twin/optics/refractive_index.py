"""Complex refractive index from a table of wavelengths."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcss_twin.catalog import Catalog
from hcss_twin.errors import CatalogError

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class RefractiveIndex:
    """Tabulated n + ik; n and ln k are linear in ln wavelength between the rows.

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

    def __call__(self, wavelength_um: Array) -> NDArray[np.complex128]:
        """Return n + ik at ``wavelength_um`` (V,).

        Raises
        ------
        ValueError
            If a wavelength lies outside the table.
        """
        wavelength = np.asarray(wavelength_um, dtype=np.float64)
        low, high = float(self.wavelength_um[0]), float(self.wavelength_um[-1])
        outside = ~((wavelength >= low) & (wavelength <= high))
        if np.any(outside):
            wrong = float(wavelength[outside][0])
            near = low if wrong < low else high
            raise ValueError(
                f"wavelength {wrong:g} um: the refractive index '{self.name}' covers {low:g} to {high:g} um; "
                f"closest is {near:g} um"
            )
        position, nodes = np.log(wavelength), np.log(self.wavelength_um)
        real = np.interp(position, nodes, self.n)
        return real + 1j * np.exp(np.interp(position, nodes, np.log(self.k)))


def load_refractive_index(catalog: Catalog, name: str) -> RefractiveIndex:
    """Read ``optical_constants/<name>.csv`` (columns wavelength_um, n, k) or a user's file of that form.

    Raises
    ------
    CatalogError
        If the file is missing, lacks a column, does not ascend, or has n or k that are not above 0.
    """
    path = catalog.find(name, "optical_constants", ".csv")
    columns = catalog.columns(path)
    missing = [column for column in ("wavelength_um", "n", "k") if column not in columns]
    if missing:
        raise CatalogError(f"{path}: lacks the columns {', '.join(missing)}; it has {', '.join(columns)}")
    table = RefractiveIndex(name, columns["wavelength_um"], columns["n"], columns["k"])
    if table.wavelength_um.size < 2 or not np.all(np.diff(table.wavelength_um) > 0.0):
        raise CatalogError(f"{path}: wavelength_um must increase over at least two rows")
    if not (table.wavelength_um[0] > 0.0 and np.all(table.n > 0.0) and np.all(table.k > 0.0)):
        raise CatalogError(f"{path}: wavelength_um, n and k must be above 0")
    return table
