"""A grey, well-mixed gas: T = exp(-optical depth x air mass)."""

from collections.abc import Sequence

import numpy as np
from hcss_twin.providers import Path, Array, AtmosphereInputs, AtmosphereDeclaration
from pydantic import BaseModel, ConfigDict, Field


class Parameters(BaseModel):
    """Keys that a scenario can set."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    optical_depth: float = Field(default=0.3, ge=0, le=100, description="Optical depth of the whole vertical column.")


class Provider:
    """Absorber amounts are added along all legs of a path; never multiply transmittances of legs."""

    declares = AtmosphereDeclaration()

    def __init__(self, inputs: AtmosphereInputs, parameters: Parameters) -> None:
        self._profile = inputs.profile
        layers = -np.diff(inputs.profile.pressure_Pa)
        self._depth = parameters.optical_depth * layers / layers.sum()

    def transmittance(self, wavenumber_cm1: Array, paths: Sequence[Path]) -> Array:
        """Return transmittance (P, V) of whole composite paths."""
        depth = np.array([self._profile.airmass(path) @ self._depth for path in paths])
        return np.repeat(np.exp(-depth)[:, None], wavenumber_cm1.size, axis=1)
