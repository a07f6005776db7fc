"""Lambertian surfaces with published emissivities (``catalogs/surfaces/emissivity.csv``)."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import CatalogError, choose_from
from hcss_twin.models.sea.reflection import basis_values
from hcss_twin.physics import quadrature
from hcss_twin.physics.planck import wavenumber_from_um
from hcss_twin.providers import SeaDeclaration

_FILE = "emissivity"
_COSINES = 32
"""Gauss points of the reflected sky; exact for up to 64 nodes."""


class Lambertian:
    """A surface that emits and reflects equally in all directions: the BRDF is (1 - emissivity) / pi.

    Parameters
    ----------
    wavelength_um, emissivity : ndarray (N,)
        Ascending wavelengths; emissivity is linear between them and unknown beyond them.
    note : str
    """

    def __init__(self, wavelength_um: Array, emissivity: Array, note: str) -> None:
        self._wavenumber, self._emissivity = wavenumber_from_um(wavelength_um)[::-1], emissivity[::-1]
        valid = {"wavenumber_cm1": (float(self._wavenumber[0]), float(self._wavenumber[-1]))}
        self.declares = SeaDeclaration(valid=valid, notes=(note,))

    def emissivity(self, wavenumber_cm1: Array, mu: Array) -> Array:
        """Return emissivity (M, V)."""
        return np.tile(self._at(wavenumber_cm1), (mu.size, 1))

    def brdf(self, wavenumber_cm1: Array, mu_out: Array, mu_in: Array, relative_azimuth: Array) -> Array:
        """Return BRDF (M, V) in sr-1."""
        return np.tile((1.0 - self._at(wavenumber_cm1)) / np.pi, (mu_out.size, 1))

    def reflection_weights(
        self, wavenumber_cm1: Array, mu: Array, mu_nodes: Array, basis: Literal["lagrange", "linear"] = "lagrange"
    ) -> Array:
        """Return the weights (M, N, V) of the sky at the nodes: means of their polynomials over the hemisphere."""
        x, weight = quadrature.gauss_legendre(_COSINES)
        cosine = 0.5 * (x + 1.0)
        shares = (cosine * weight) @ basis_values(cosine, mu_nodes, basis)
        reflected = shares[:, None] * (1.0 - self._at(wavenumber_cm1))
        return np.tile(reflected, (mu.size, 1, 1))

    def _at(self, wavenumber_cm1: Array) -> Array:
        # Linear in wavelength, as the table is.
        return np.asarray(np.interp(-1e4 / wavenumber_cm1, -1e4 / self._wavenumber, self._emissivity))


def material(name: str, catalog: Catalog) -> Lambertian:
    """Return the surface of a class without a boundary of its own.

    Raises
    ------
    CatalogError
        If its emissivity is not in the table.
    """
    columns: dict[str, Any] = catalog.columns(catalog.find(_FILE, "surfaces", ".csv"))
    wavelength_um = columns.pop("wavelength_um")
    if name not in columns:
        raise CatalogError(f"surface class '{name}' has no boundary and no published emissivity; "
                           f"{choose_from(name, columns)}")  # fmt: skip
    note = (
        f"surface class {name}: Lambertian, with a published mean emissivity; single places differ by several percent"
    )
    return Lambertian(wavelength_um, columns[name], note)
