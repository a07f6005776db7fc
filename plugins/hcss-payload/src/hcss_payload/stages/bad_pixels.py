"""Bad pixels: dead, hot and blinking detectors."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from hcss_payload.stages.random_numbers import uniform
from hcss_twin.core.units import QuantityParser as Quantity
from hcss_twin.models.sensor.noise import Noise
from hcss_twin.providers import Array, Measured, Problem, ScenarioError, SensorDeclaration, SensorInputs


class Parameters(BaseModel):
    """Keys that a scenario can set."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    dead: Quantity.Fraction = Field(
        1e-3, ge=0, le=0.3, description="Share of pixels that always give the same radiance."
    )
    dead_radiance: float = Field(0.0, ge=0, description="This radiance, W m-2 sr-1.")
    hot: Quantity.Fraction = Field(0.0, ge=0, le=0.3, description="Share of pixels with an offset.")
    blinking: Quantity.Fraction = Field(
        0.0, ge=0, le=0.3, description="Share of pixels with an offset half of the time."
    )
    offset_radiance: float = Field(0.0, ge=0, description="This offset, W m-2 sr-1.")
    dwell_time: Quantity.Duration = Field(
        1.0, gt=0, le=1e6, description="Mean time between two changes of a blinking pixel, s."
    )


class BadPixels:
    """Detectors that fail, independently of each other; the same ones in all frames of a band.

    Blinking is random telegraph noise: in each interval of half the dwell time, which begins at a time of the pixel's
    own, the offset is there with probability 1/2. Its state then changes every dwell time on average, and depends on
    the time alone.
    """

    variables = ()
    declares = SensorDeclaration(reach_pixels=0)

    def __init__(self, inputs: SensorInputs, parameters: Parameters) -> None:
        total = parameters.dead + parameters.hot + parameters.blinking
        if total > 0.5:
            message = f"{total:g} of the pixels together with hot and blinking; allowed: up to 0.5"
            raise ScenarioError([Problem("sensor.parameters.dead", message)])
        self._inputs, self._of = inputs, parameters
        shape = inputs.grid.rows, inputs.grid.columns
        number = np.stack([uniform(self._key("kind", band.name), shape, inputs.corner) for band in inputs.bands])
        ends = np.cumsum([parameters.dead, parameters.hot, parameters.blinking])
        self.dead = number < ends[0]
        self.hot = (number >= ends[0]) & (number < ends[1])
        self.blinking = (number >= ends[1]) & (number < ends[2])

    def measure(self, radiance: Array, frame: int, time_s: float) -> Measured:
        """Return the radiance with bad pixels."""
        on = self.hot | (self.blinking & self._is_on(time_s))
        return Measured(np.where(self.dead, self._of.dead_radiance, radiance + self._of.offset_radiance * on))

    def _is_on(self, time_s: float) -> NDArray[np.bool_]:
        if not self._of.blinking:
            return np.zeros(self.blinking.shape, np.bool_)
        inputs, on = self._inputs, np.empty(self.blinking.shape, np.bool_)
        shape = inputs.grid.rows, inputs.grid.columns
        elapsed = time_s / (0.5 * self._of.dwell_time)
        whole = int(np.floor(elapsed))
        for band, band_is_on in zip(inputs.bands, on, strict=True):
            begun = elapsed - whole >= uniform(self._key("start", band.name), shape, inputs.corner)
            states = [
                uniform(self._key(f"state {number}", band.name), shape, inputs.corner) < 0.5
                for number in (whole - 1, whole)
            ]
            band_is_on[:] = np.where(begun, states[1], states[0])
        return on

    def _key(self, purpose: str, band: str) -> int:
        return Noise.key_of(self._inputs.seed, f"bad pixels, {purpose}", band)
