"""Optics provider: homogeneous spheres of water or ice (Mie theory)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcss_twin.optics.parameters import MieParameters
from hcss_twin.optics.spheres_of_a_cloud import ICE_NOTE, MOMENTS_NOTE, WATER_NOTES, CloudSpheres
from hcss_twin.providers import Declares, Microphysics, OpticsInputs, SingleScattering
from hcss_twin.providers.notes import Note

Array = NDArray[np.float64]


class MieOptics:
    """Extinction, albedo and phase function of a modified gamma distribution of spheres.

    Eqs 8 to 11 of the HCSS paper. The phase function is that of Mie theory, given by its Legendre moments, or
    Henyey and Greenstein's with the same asymmetry (eq 13).

    Parameters
    ----------
    inputs : OpticsInputs
        Brings the catalog with refractive indices and tables.
    parameters : MieParameters
        Refractive indices and accuracy.

    Raises
    ------
    ScenarioError
        If both a refractive index and a temperature of water are given.
    """

    declares = Declares(
        valid={"wavenumber_cm1": (1e4 / 16.0, 1e4 / 0.3)},
        notes_by_phase={
            "water": WATER_NOTES,
            "ice": (
                "ice particles are spheres, as in the HCSS paper; real ice crystals scatter less forward",
                ICE_NOTE,
                MOMENTS_NOTE,
                Note("the forward peak of ice spheres needs more than 128 moments", sunlight=True),
            ),
        },
    )

    def __init__(self, inputs: OpticsInputs, parameters: MieParameters) -> None:
        self._spheres = CloudSpheres(inputs.catalog, parameters)

    def single_scattering(self, cloud: Microphysics, wavenumber_cm1: Array) -> SingleScattering:
        """Return bulk properties at ``wavenumber_cm1`` (V,).

        The logarithms of extinction and absorption, and the moments of the phase function, are interpolated
        over ln wavelength; nothing nonlinear follows.

        Raises
        ------
        ValueError
            If a wavenumber lies outside 0.3 to 16 um or outside the refractive-index table, or the
            particles' parameters are not valid.
        CatalogError
            If the refractive-index table is missing or malformed.
        """
        return self._spheres.single_scattering(cloud, wavenumber_cm1)
