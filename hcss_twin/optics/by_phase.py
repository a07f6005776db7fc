"""Optics provider: Mie theory for water, a published parameterisation of crystals for ice."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcss_twin.optics.ice_crystals import CrystalRatios, load_crystals
from hcss_twin.optics.parameters import BulkParameters
from hcss_twin.optics.size_distribution import effective_radius_um
from hcss_twin.optics.spheres_of_a_cloud import ICE_NOTE, VALID_CM1, WATER_NOTES, CloudSpheres
from hcss_twin.providers import Declares, Microphysics, OpticsInputs, SingleScattering

Array = NDArray[np.float64]


class BulkOptics:
    """Water droplets as spheres, ice as crystals of the same volume and projected area per volume of cloud.

    For ice the particles' effective radius selects the crystals; extinction, absorption and asymmetry are those of
    equal-volume-to-area spheres (Grenfell and Warren 1999) times the ratios of :mod:`hcss_twin.optics.ice_crystals`,
    and the phase function is Henyey and Greenstein's.

    Parameters
    ----------
    inputs : OpticsInputs
        Brings the catalog with refractive indices and tables.
    parameters : BulkParameters
        Refractive indices, crystals and accuracy.

    Raises
    ------
    ScenarioError
        If both a refractive index and a temperature of water are given.
    """

    declares = Declares(
        valid={"wavenumber_cm1": VALID_CM1},
        notes_by_phase={
            "water": WATER_NOTES,
            "ice": (
                "ice is made of the crystals of Yang et al. (2013), known as averages over bands 70 to 1000 cm-1 "
                "wide; its phase function is Henyey-Greenstein, without halos",
                ICE_NOTE,
            ),
        },
    )

    def __init__(self, inputs: OpticsInputs, parameters: BulkParameters) -> None:
        self._catalog = inputs.catalog
        self._parameters = parameters
        self._droplets = CloudSpheres(inputs.catalog, parameters)
        self._ice = CloudSpheres(
            inputs.catalog, parameters.model_copy(update={"phase_function": "henyey-greenstein"})
        )
        self._crystals: CrystalRatios | None = None

    def single_scattering(self, cloud: Microphysics, wavenumber_cm1: Array) -> SingleScattering:
        """Return bulk properties at ``wavenumber_cm1`` (V,); for ice 2 moments.

        Raises
        ------
        ValueError
            If a wavenumber lies outside 0.3 to 16 um or outside the refractive-index table, the
            particles' parameters are not valid, or the effective radius of ice lies outside the table.
        CatalogError
            If a table is missing or malformed.
        """
        if cloud.phase == "water":
            return self._droplets.single_scattering(cloud, wavenumber_cm1)
        spheres = self._ice.single_scattering(cloud, wavenumber_cm1)
        if self._crystals is None:
            name, roughness = self._parameters.ice_table, self._parameters.roughness
            self._crystals = load_crystals(self._catalog, name, roughness)
        ratios = self._crystals.at(2.0 * effective_radius_um(cloud), np.asarray(wavenumber_cm1))
        extinction = ratios[0] * spheres.extinction_m1
        absorption = ratios[1] * spheres.extinction_m1 * (1.0 - spheres.albedo)
        asymmetry = 1.0 - ratios[2] * (1.0 - spheres.moments[1])
        return SingleScattering(
            extinction, 1.0 - absorption / extinction, np.stack([np.ones_like(asymmetry), asymmetry])
        )
