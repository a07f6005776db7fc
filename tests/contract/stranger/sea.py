"""Slush: a half-space of isotropic grains that scatter once, after Lommel and Seeliger."""

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from hcss_twin.providers import SeaDeclaration


class Parameters(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)

    albedo: float = Field(0.1, ge=0, le=1, description="Single-scattering albedo of the grains.")


class Slush:
    declares = SeaDeclaration(depends_on=frozenset({"view_zenith", "sun_zenith"}))
    significant_wave_height_m = 0.0

    def __init__(self, inputs, parameters):
        self._albedo = parameters.albedo

    def emissivity(self, wavenumber_cm1, mu):
        # 1 - integral of the BRDF: albedo / 2 (1 - mu ln((1 + mu) / mu))
        reflected = 0.5 * self._albedo * (1.0 - mu * np.log1p(1.0 / mu))
        return np.repeat(1.0 - reflected[:, None], wavenumber_cm1.size, axis=1)

    def brdf(self, wavenumber_cm1, mu_out, mu_in, relative_azimuth):
        value = self._albedo / (4.0 * np.pi * (mu_out + mu_in))
        return np.repeat(value[:, None], wavenumber_cm1.size, axis=1)
