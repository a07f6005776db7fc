"""A converter without noise: radiance is counted in equal steps."""

import numpy as np
from hcss_twin.providers import Array, SensorDeclaration, Measured, SensorInputs
from pydantic import BaseModel, ConfigDict, Field


class Parameters(BaseModel):
    """Keys that a scenario can set."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    step_W_m2_sr: float = Field(default=0.005, gt=0, description="Radiance of one step, W m-2 sr-1.")
    bits: int = Field(default=14, ge=1, le=30, description="The highest digital number is 2^bits - 1.")


class Provider:
    """Every pixel alone: digital number, whether it is saturated, and the radiance in the middle of its step."""

    declares = SensorDeclaration(reach_pixels=0)
    variables: tuple[str, ...] = ("digital_number", "saturated")

    def __init__(self, inputs: SensorInputs, parameters: Parameters) -> None:
        self._step = parameters.step_W_m2_sr
        self._highest = 2**parameters.bits - 1

    def measure(self, radiance: Array, frame: int, time_s: float) -> Measured:
        """Return the measurement of a clean frame (B, y, x) in W m-2 sr-1."""
        steps = np.floor(radiance / self._step)
        number = np.clip(steps, 0, self._highest).astype(np.int32)
        return Measured(
            radiance=(number.astype(np.float64) + 0.5) * self._step,
            digital_number=number,
            saturated=(1 * (steps > self._highest) + 2 * (steps < 0)).astype(np.uint8),
        )
