"""Detectors that keep a part of what the last frame left in them."""

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from hcss_twin.providers import Measured, SensorDeclaration


class Parameters(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)

    part: float = Field(0.1, ge=0, lt=1, description="Part of a frame that comes from the last one.")


class Lagging:
    declares = SensorDeclaration(reach_pixels=0, remembers=True)
    variables = ()

    def __init__(self, inputs, parameters):
        self._part = parameters.part
        self._last = None

    def measure(self, radiance, frame, time_s):
        last = radiance if self._last is None else self._last
        self._last = np.array(radiance)
        return Measured(radiance=(1.0 - self._part) * radiance + self._part * last)
