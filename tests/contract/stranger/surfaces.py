"""Ice whose temperature falls toward the north, beside open water."""

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from hcss_twin.providers import Declaration, SeaDeclaration, SurfaceClass, SurfaceMap


class Parameters(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)

    edge: float = Field(35.0, description="Latitude of the ice edge, degrees north.")


class Grey:
    declares = SeaDeclaration()

    def emissivity(self, wavenumber_cm1, mu):
        return np.full((mu.size, wavenumber_cm1.size), 0.97)

    def brdf(self, wavenumber_cm1, mu_out, mu_in, relative_azimuth):
        return np.full((mu_out.size, wavenumber_cm1.size), 0.03 / np.pi)


class Floe:
    declares = Declaration()

    def __init__(self, inputs, parameters):
        self._ground, self._edge = inputs.ground, parameters.edge
        self.classes = (SurfaceClass("sea"), SurfaceClass("floe", (250.0, 271.0), Grey()))

    def surface(self, time_s, rows, columns):
        latitude, _ = self._ground(time_s, rows, columns)
        kelvin = np.clip(271.0 - 100.0 * (latitude - self._edge), 250.0, 271.0)
        return SurfaceMap((latitude > self._edge).astype(np.uint8), kelvin)
