"""A detector whose response is not proportional to radiance."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from hcss_twin.models.sensor.parameters import OfBands
from hcss_twin.providers import Array, Measured, SensorDeclaration, SensorInputs


class Parameters(BaseModel):
    """Keys that a scenario can set."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    full_radiance: Annotated[float | dict[str, float], OfBands.within(1e-12, 1e9)] = Field(
        description="Radiance at full scale, W m-2 sr-1; one number or a table by band."
    )
    quadratic: float = Field(
        0.01, ge=-0.25, le=0.25, description="Largest deviation from a line through zero and full scale, of full scale."
    )


class NonLinearity:
    """A parabola that is exact at zero and at full scale: L + 4 q L (1 - L / full).

    Its largest deviation from the line, at half of full scale, is q of full scale: the integral non-linearity of EMVA
    Standard 1288. Above full scale and below zero, it goes on along its tangent, so that it is monotonic.
    """

    variables = ()
    declares = SensorDeclaration(reach_pixels=0)

    def __init__(self, inputs: SensorInputs, parameters: Parameters) -> None:
        full = [OfBands.number(parameters.full_radiance, band.name, "full_radiance") for band in inputs.bands]
        self._full = np.array(full)[:, None, None]
        self._slope = 4.0 * parameters.quadratic

    def measure(self, radiance: Array, frame: int, time_s: float) -> Measured:
        """Return the apparent radiance of a frame."""
        share = radiance / self._full
        inside = np.clip(share, 0.0, 1.0)
        bent = inside + self._slope * inside * (1.0 - inside)
        tangent = 1.0 + self._slope * (1.0 - 2.0 * inside)
        return Measured(self._full * (bent + tangent * (share - inside)))
