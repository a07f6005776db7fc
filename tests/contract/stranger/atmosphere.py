"""One band of lines that saturate (Malkmus 1967): transmittances of legs do not multiply."""

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from hcss_twin.providers import AtmosphereDeclaration


class Parameters(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)

    depth: float = Field(1.0, ge=0, description="Optical depth of the vertical column if no line saturated.")
    width: float = Field(0.2, gt=0, description="Line width over line spacing at the surface.")


class Malkmus:
    declares = AtmosphereDeclaration()

    def __init__(self, inputs, parameters):
        self._p = parameters
        self._profile = inputs.profile
        pressure = inputs.profile.pressure_Pa
        mass = -np.diff(pressure)
        self._share = mass / mass.sum()
        self._width = parameters.width * 0.5 * (pressure[1:] + pressure[:-1]) / pressure[0]

    def transmittance(self, wavenumber_cm1, paths):
        result = np.ones((len(paths), wavenumber_cm1.size))
        for row, path in enumerate(paths):
            amount = self._profile.airmass(path) * self._share  # summed over the legs
            if np.any(amount):
                width = np.pi * (amount @ self._width) / amount.sum()  # Curtis and Godson's mean
                strong = np.sqrt(1.0 + 4.0 * self._p.depth * amount.sum() / width)
                result[row] = np.exp(-0.5 * width * (strong - 1.0))
        return result
