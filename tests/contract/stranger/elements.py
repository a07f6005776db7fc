"""A warm square that hides the sea."""

from typing import ClassVar

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from hcss_twin.providers import Declaration, ElementPixels


class Parameters(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)

    temperature: float = Field(310.0, gt=0, description="Of the deck, K.")
    pixels: int = Field(3, ge=1, description="Side, pixels.")


class Ship:
    declares = Declaration()
    variables: ClassVar = {"temperature": ("K", "Temperature of the deck.")}

    def __init__(self, inputs, parameters):
        self._inputs, self._parameters = inputs, parameters

    def pixels(self, time_s, rows, columns, scene):
        first = [int(each[0]) for each in scene.project(np.zeros(1), np.zeros(1), np.full(1, 10.0))]
        y, x = (each.ravel() for each in np.mgrid[: self._parameters.pixels, : self._parameters.pixels])
        y, x = y + first[0], x + first[1]
        here = (y >= rows.start) & (y < rows.stop) & (x >= columns.start) & (x < columns.stop)
        kelvin = self._parameters.temperature
        truth = {"temperature": np.full(np.sum(here), kelvin)}
        radiance = self._inputs.black_body(kelvin)
        share = np.ones(np.sum(here))
        return [ElementPixels(y[here], x[here], share, 10.0, radiance, temperature_K=kelvin, truth=truth)]
