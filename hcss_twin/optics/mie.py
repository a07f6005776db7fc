"""Optics provider: homogeneous spheres of water or ice (Mie theory)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcss_twin.optics.bulk import bulk_properties
from hcss_twin.optics.parameters import MieParameters
from hcss_twin.optics.size_distribution import check
from hcss_twin.optics.spectral_panels import PanelTable, panel_edges
from hcss_twin.providers import Declares, Microphysics, OpticsInputs, SingleScattering
from hcss_twin.refractive_index import RefractiveIndex, load_refractive_index

Array = NDArray[np.float64]

VALID_CM1 = (625.0, 4000.0)
"""Wavenumbers, 2.5 to 16 um, inside which the errors of quadrature and interpolation were measured."""


class MieOptics:
    """Extinction, albedo and asymmetry of a modified gamma distribution of spheres.

    Eqs 8 to 11 and 13 of the HCSS paper; the phase function is Henyey and Greenstein's.

    Parameters
    ----------
    inputs : OpticsInputs
        Brings the catalog with the refractive indices.
    parameters : MieParameters
        Tables and accuracy.
    """

    declares = Declares(
        valid={"wavenumber_cm1": VALID_CM1},
        notes=(
            "ice particles are spheres, as in the HCSS paper; real ice crystals scatter less forward",
            "the phase function is Henyey-Greenstein with the asymmetry parameter of Mie theory",
            "refractive indices are for one temperature; shipped: water at 25 degC, ice at -7 degC",
        ),
    )

    def __init__(self, inputs: OpticsInputs, parameters: MieParameters) -> None:
        self._catalog = inputs.catalog
        self._parameters = parameters
        self._indices: dict[str, RefractiveIndex] = {}
        self._tables: dict[Microphysics, PanelTable] = {}

    def single_scattering(self, cloud: Microphysics, wavenumber_cm1: Array) -> SingleScattering:
        """Return bulk properties at ``wavenumber_cm1`` (V,).

        The logarithms of extinction and absorption, and the asymmetry parameter, are interpolated
        over ln wavelength; nothing nonlinear follows.

        Raises
        ------
        ValueError
            If a wavenumber lies outside 625 to 4000 cm-1 or outside the refractive-index table, or the
            particles' parameters are not valid.
        CatalogError
            If the refractive-index table is missing or malformed.
        """
        wavenumber = np.asarray(wavenumber_cm1, dtype=np.float64)
        _check_range(wavenumber)
        if wavenumber.size == 0:
            return SingleScattering(np.empty(0), np.empty(0), np.empty((2, 0)))
        if cloud not in self._tables:
            self._tables[cloud] = self._table(cloud)
        index = self._index(cloud.phase)
        wavelength = 1e4 / wavenumber
        index.at(1e4 / wavelength)  # refuses wavelengths a user's table does not cover
        log_extinction, log_absorption, asymmetry = self._tables[cloud](np.log(wavelength))
        extinction = np.exp(log_extinction)
        albedo = 1.0 - np.exp(log_absorption) / extinction
        return SingleScattering(extinction, albedo, np.stack([np.ones_like(asymmetry), asymmetry]))

    def _index(self, phase: str) -> RefractiveIndex:
        if phase not in self._indices:
            name = self._parameters.water_index if phase == "water" else self._parameters.ice_index
            self._indices[phase] = load_refractive_index(self._catalog, name)
        return self._indices[phase]

    def _table(self, cloud: Microphysics) -> PanelTable:
        check(cloud)
        if cloud.number_density_m3 <= 0.0:
            raise ValueError(f"number_density_m3 {cloud.number_density_m3}: allowed above 0")
        index = self._index(cloud.phase)
        nodes = self._parameters.radius_nodes

        def evaluate(position: Array) -> Array:
            bulk = bulk_properties(cloud, index, np.exp(position), nodes)
            return np.stack([np.log(bulk.extinction_m1), np.log(bulk.absorption_m1), bulk.asymmetry])

        edges = panel_edges(np.log(index.wavelength_um), self._parameters.spectral_step)
        return PanelTable(edges, evaluate, components=3)


def _check_range(wavenumber: Array) -> None:
    low, high = VALID_CM1
    outside = ~((wavenumber >= low) & (wavenumber <= high))
    if np.any(outside):
        wrong = float(wavenumber[outside][0])
        raise ValueError(
            f"wavenumber_cm1 {wrong:g}: Mie optics allow {low:g} to {high:g}; "
            f"closest is {low if wrong < low else high:g}"
        )
