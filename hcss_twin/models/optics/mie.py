"""Optics providers ``mie`` (water and ice spheres) and ``bulk`` (water spheres and ice crystals)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import Problem, ScenarioError
from hcss_twin.models.model_errors import from_table
from hcss_twin.models.optics.bulk import VALID_UM, Accuracy, BulkTable
from hcss_twin.models.optics.ice_crystals import CrystalRatios, DiffractionPeaks, crystal_moments, load_crystals
from hcss_twin.models.optics.size_distribution import effective_radius_um, projected_area_m1
from hcss_twin.models.optics.table_store import TableStore
from hcss_twin.models.parameters import BulkParameters, MieParameters
from hcss_twin.models.refractive_index import RefractiveIndex, load_refractive_index, load_water_at
from hcss_twin.providers import Microphysics, OpticsDeclaration, OpticsInputs, SingleScattering
from hcss_twin.providers.declarations import ModelError, Note

VALID_CM1 = (1e4 / VALID_UM[1], 1e4 / VALID_UM[0])

MOMENTS_NOTE = Note(
    "below 2.6 um single moments of the Mie phase function are known within 0.003, above within 0.0005", below_um=2.6
)

WATER_NOTES = (
    "the refractive index of cloud droplets is for one temperature, as the provider's parameters say",
    MOMENTS_NOTE,
    Note("128 moments carry the whole phase function of water clouds above about 3 um", below_um=3.0),
)

CRYSTALS = {
    "ice-yang-2013": "the crystals of Yang et al. (2013), known as averages over bands 70 to 1000 cm-1 wide",
    "ice-fu-1996": "the hexagonal columns of Fu (1996) and Fu et al. (1998), known below 4 um as averages over bands",
}
PHASE_FUNCTION = "phase function of ice"
"""Name of the error that ``ice_phase_function`` decides about."""

OWN_CRYSTALS = "the crystals of the file ice_table"

ICE_NOTE = "the refractive index of ice particles is for one temperature, -7 degC in the catalog's table"


class CloudSpheres:
    """Bulk properties of clouds of spheres; refractive indices and tables are loaded once per run.

    Parameters
    ----------
    catalog : Catalog
        Source of refractive indices and tables.
    parameters : MieParameters
        Refractive indices and accuracy.

    Raises
    ------
    ScenarioError
        If both a refractive index and a water temperature are given, or there are no data at the temperature.
    """

    def __init__(self, catalog: Catalog, parameters: MieParameters) -> None:
        self._catalog = catalog
        self._parameters = parameters
        self._store = TableStore(catalog)
        self._indices: dict[str, RefractiveIndex] = {}
        self._tables: dict[Microphysics, BulkTable] = {}
        given = parameters.model_fields_set
        if parameters.water_temperature_K is not None and "water_index" in given:
            message = f"given together with water_index = '{parameters.water_index}'; allowed: one of the two"
            raise ScenarioError([Problem("water_temperature_K", message)])

    def single_scattering(self, cloud: Microphysics, wavenumber_cm1: Array) -> SingleScattering:
        """Return bulk properties; see :meth:`MieOptics.single_scattering`."""
        wavenumber = np.asarray(wavenumber_cm1, dtype=np.float64)
        _require_range(wavenumber)
        if wavenumber.size == 0:
            return SingleScattering(np.empty(0), np.empty(0), np.empty((2, 0)))
        if cloud.number_density_m3 <= 0.0:
            raise ValueError(f"number_density_m3 {cloud.number_density_m3}: allowed above 0")
        index = self.index_of(cloud.material)
        index.at(wavenumber)  # rejects wavelengths that a user's table does not cover
        single = replace(cloud, number_density_m3=1.0)
        if single not in self._tables:
            count = self._parameters.moments_of(cloud.material)
            accuracy = Accuracy(self._parameters.radius_nodes, self._parameters.spectral_step, count)
            self._tables[single] = BulkTable(single, index, accuracy)
        table = self._tables[single]
        position = np.log(1e4 / wavenumber)
        self._store.complete(table, position)
        extinction, absorption, _, moments = table(position)
        return SingleScattering(cloud.number_density_m3 * extinction, 1.0 - absorption / extinction, moments)

    def index_of(self, material: str) -> RefractiveIndex:
        """Return the refractive index of a material."""
        if material not in self._indices:
            parameters = self._parameters
            if material == "water" and parameters.water_temperature_K is not None:
                self._indices[material] = load_water_at(self._catalog, parameters.water_temperature_K)
            else:
                name = parameters.water_index if material == "water" else parameters.ice_index
                self._indices[material] = load_refractive_index(self._catalog, name)
        return self._indices[material]


def _require_range(wavenumber_cm1: Array) -> None:
    """Raise ValueError for a wavenumber outside 0.3 to 16 um."""
    low, high = VALID_CM1
    outside = ~((wavenumber_cm1 >= low) & (wavenumber_cm1 <= high))
    if np.any(outside):
        wrong = float(wavenumber_cm1[outside][0])
        raise ValueError(
            f"wavenumber_cm1 {wrong:g}: cloud optics allow {low:g} to {high:g}; "
            f"closest is {low if wrong < low else high:g}"
        )


class MieOptics:
    """Extinction, albedo and phase function of a modified gamma distribution of spheres (HCSS paper, eq 9 to eq 11).

    The phase function is that of Mie theory, given by its Legendre moments, or
    Henyey and Greenstein's with the same asymmetry (eq 13).

    Parameters
    ----------
    inputs : OpticsInputs
        Contains the catalog with refractive indices and tables.
    parameters : MieParameters
        Refractive indices and accuracy.

    Raises
    ------
    ScenarioError
        If both a refractive index and a temperature of water are given.
    """

    declares = OpticsDeclaration(
        valid={"wavenumber_cm1": (1e4 / 16.0, 1e4 / 0.3)},
        notes_by_material={
            "water": WATER_NOTES,
            "ice": (
                "ice particles are spheres, as in the HCSS paper; real ice crystals scatter less forward",
                ICE_NOTE,
                MOMENTS_NOTE,
            ),
        },
    )

    model_errors = from_table(__file__, "mie")

    def __init__(self, inputs: OpticsInputs, parameters: MieParameters) -> None:
        self._spheres = CloudSpheres(inputs.catalog, parameters)

    def single_scattering(self, cloud: Microphysics, wavenumber_cm1: Array) -> SingleScattering:
        """Return bulk properties at ``wavenumber_cm1`` (V,).

        The logarithms of extinction and absorption, and the moments of the phase function, are interpolated
        quadratically in ln wavelength.

        Raises
        ------
        ValueError
            If a wavenumber lies outside 0.3 to 16 um or outside the refractive-index table, or the
            particles' parameters are not valid.
        CatalogError
            If the refractive-index table is missing or malformed.
        """
        return self._spheres.single_scattering(cloud, wavenumber_cm1)


class BulkOptics:
    """Water droplets as spheres, ice as crystals with the same volume and projected area per cloud volume.

    For ice, the effective radius selects the crystals; extinction, absorption and asymmetry are those of spheres with
    equal volume-to-area ratio (Grenfell and Warren 1999) times the ratios of
    :mod:`hcss_twin.models.optics.ice_crystals`. The phase function is Henyey and Greenstein's or that of
    :mod:`hcss_twin.models.optics.ice_crystals`.

    Parameters
    ----------
    inputs : OpticsInputs
        Contains the catalog with refractive indices and tables.
    parameters : BulkParameters
        Refractive indices, crystals and accuracy.

    Raises
    ------
    ScenarioError
        If both a refractive index and a temperature of water are given.
    """

    def __init__(self, inputs: OpticsInputs, parameters: BulkParameters) -> None:
        self._catalog = inputs.catalog
        self._parameters = parameters
        self._droplets = CloudSpheres(inputs.catalog, parameters)
        self._ice = CloudSpheres(inputs.catalog, parameters.model_copy(update={"phase_function": "henyey-greenstein"}))
        self._crystals: CrystalRatios | None = None
        self._peaks: dict[Microphysics, DiffractionPeaks] = {}
        self._rays = parameters.ice_phase_function == "diffraction-and-rays"
        shape = "without halos" if self._rays else "Henyey-Greenstein, without halos"
        self.declares = OpticsDeclaration(
            valid={"wavenumber_cm1": VALID_CM1},
            notes_by_material={
                "water": WATER_NOTES,
                "ice": (
                    f"ice is made of {CRYSTALS.get(parameters.ice_table, OWN_CRYSTALS)}; its phase function is {shape}",
                    ICE_NOTE,
                ),
            },
        )

    def model_errors(self) -> tuple[ModelError, ...]:
        """Return the errors against the best references; for the phase function, the difference of both choices."""
        every = from_table(__file__, "bulk")()
        return tuple(
            replace(error, needs="") if self._rays and error.name == PHASE_FUNCTION else error for error in every
        )

    def single_scattering(self, cloud: Microphysics, wavenumber_cm1: Array) -> SingleScattering:
        """Return bulk properties at ``wavenumber_cm1`` (V,); for ice 2 moments with Henyey and Greenstein's function.

        Raises
        ------
        ValueError
            If a wavenumber lies outside 0.3 to 16 um or outside the refractive-index table, the
            particles' parameters are not valid, or the effective radius of ice lies outside the table.
        CatalogError
            If a table is missing or malformed.
        """
        if cloud.material == "water":
            return self._droplets.single_scattering(cloud, wavenumber_cm1)
        spheres = self._ice.single_scattering(cloud, wavenumber_cm1)
        if self._crystals is None:
            name, roughness = self._parameters.ice_table, self._parameters.roughness
            self._crystals = load_crystals(self._catalog, name, roughness)
        ratios = self._crystals.at(2.0 * effective_radius_um(cloud), np.asarray(wavenumber_cm1))
        extinction = ratios[0] * spheres.extinction_m1
        absorption = ratios[1] * spheres.extinction_m1 * (1.0 - spheres.albedo)
        asymmetry = 1.0 - ratios[2] * (1.0 - spheres.moments[1])
        albedo = 1.0 - absorption / extinction
        if not self._rays:
            return SingleScattering(extinction, albedo, np.stack([np.ones_like(asymmetry), asymmetry]))
        single = replace(cloud, number_density_m3=1.0)
        if single not in self._peaks:
            self._peaks[single] = DiffractionPeaks(single)
        wavelength = 1e4 / np.asarray(wavenumber_cm1, dtype=np.float64)
        index = self._ice.index_of("ice").at(1e4 / wavelength)
        efficiency = albedo * extinction / projected_area_m1(cloud)
        moments = crystal_moments(self._peaks[single], efficiency, asymmetry, index, wavelength)
        return SingleScattering(extinction, albedo, moments)
