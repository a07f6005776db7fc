"""A grey sea that reflects the same in all directions (Lambert)."""

import numpy as np
from hcss_twin.providers import Array, SeaDeclaration, SeaInputs
from pydantic import BaseModel, ConfigDict, Field


class Parameters(BaseModel):
    """Keys that a scenario can set."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    emissivity: float = Field(default=0.98, ge=0, le=1, description="In every direction and at all wavelengths.")


class Provider:
    """BRDF = (1 - emissivity) / pi: what is not emitted is reflected (Kirchhoff)."""

    declares = SeaDeclaration()

    def __init__(self, inputs: SeaInputs, parameters: Parameters) -> None:
        self._emissivity = parameters.emissivity

    def emissivity(self, wavenumber_cm1: Array, mu: Array) -> Array:
        """Return emissivity (M, V) for cosines `mu` (M,) of the view zenith."""
        return np.full((mu.size, wavenumber_cm1.size), self._emissivity)

    def brdf(self, wavenumber_cm1: Array, mu_out: Array, mu_in: Array, relative_azimuth: Array) -> Array:
        """Return the BRDF (M, V) in sr-1 for directions (M,)."""
        return np.full((mu_out.size, wavenumber_cm1.size), (1.0 - self._emissivity) / np.pi)
