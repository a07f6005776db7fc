"""The provider, imported only when a scenario selects it."""

from collections.abc import Sequence

import numpy as np

from hcss_grey_atmosphere.parameters import GreyParameters
from hcss_twin.providers import Array, AtmosphereDeclaration, AtmosphereInputs, Path


class GreyAtmosphere:
    """T = exp(-optical_depth m), with m the air mass of the whole path weighted by pressure."""

    def __init__(self, inputs: AtmosphereInputs, parameters: GreyParameters) -> None:
        self._profile = inputs.profile
        mass = -np.diff(inputs.profile.pressure_Pa)
        self._share = mass / mass.sum()
        self._optical_depth = parameters.optical_depth
        self.declares = AtmosphereDeclaration()

    def transmittance(self, wavenumber_cm1: Array, paths: Sequence[Path]) -> Array:
        """Return transmittance (P, V) of whole composite paths, the same at all wavenumbers."""
        # Profile.airmass sums the legs of a path: never multiply transmittances of legs.
        air_mass = np.array([self._profile.airmass(path) @ self._share for path in paths])
        return np.exp(-self._optical_depth * air_mass)[:, None] * np.ones(wavenumber_cm1.size)
