"""Stray light: a veil over the image, and a ghost."""

from __future__ import annotations

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from hcss_twin.core.units import QuantityParser as Quantity
from hcss_twin.providers import Array, Measured, SensorDeclaration, SensorInputs


class Parameters(BaseModel):
    """Keys that a scenario can set."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    veil: Quantity.Fraction = Field(
        0.01, ge=0, le=0.5, description="Share of the light that is spread evenly over the image."
    )
    ghost: Quantity.Fraction = Field(
        0.0, ge=0, le=0.5, description="Share that two reflections bring to the opposite pixel."
    )


class StrayLight:
    """Veiling glare and a ghost turned by 180 degrees about the middle of the image.

    A uniform scene is unchanged, and so is the mean of any frame: light is moved, not made. The veil is that of ISO
    9358 (veiling glare index: radiance in the middle of a small black area in a white field, over that of the field).
    The light of sources outside the image is that of a scene like the one inside.
    """

    variables = ()
    declares = SensorDeclaration(reach_pixels=None)

    def __init__(self, inputs: SensorInputs, parameters: Parameters) -> None:
        self._of = parameters

    def measure(self, radiance: Array, frame: int, time_s: float) -> Measured:
        """Return the radiance with stray light."""
        mean = np.mean(radiance, axis=(1, 2), keepdims=True)
        direct = 1.0 - self._of.veil - self._of.ghost
        return Measured(direct * radiance + self._of.veil * mean + self._of.ghost * radiance[:, ::-1, ::-1])
