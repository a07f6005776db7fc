"""A split window: the difference of brightness temperatures of two bands, and pixels that it marks."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np
from hcss_twin.providers import Declaration, OutputVariable, VariableInputs
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field


class Parameters(BaseModel):
    """Keys that a scenario can set."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    first: int = Field(default=0, ge=0, description="Number of the first band.")
    second: int = Field(default=-1, description="Number of the band that is subtracted; -1: the last.")
    least: float = Field(default=1.0, description="Difference from which on a pixel is marked, K.")


class Provider:
    """Difference of brightness temperatures, and a flag."""

    declares = Declaration()
    needs: tuple[str, ...] = ("brightness_temperature",)
    variables: Mapping[str, OutputVariable] = MappingProxyType(
        {
            "temperature_difference": OutputVariable(
                units="K",
                long_name="difference of brightness temperatures",
                description="Brightness temperature of the first band less that of the second.",
            ),
            "difference_flag": OutputVariable(
                units="1",
                long_name="flag of a large difference",
                description="Whether the difference reaches the parameter least.",
                dtype="uint8",
                flag_meanings=("small", "large"),
            ),
        }
    )

    def __init__(self, inputs: VariableInputs, parameters: Parameters) -> None:
        self._parameters = parameters

    def values(self, fields: Mapping[str, NDArray[Any]], time_s: float) -> Mapping[str, NDArray[Any]]:
        """Return both variables (y, x) of a part of a frame."""
        kelvin = fields["brightness_temperature"]
        difference = kelvin[self._parameters.first] - kelvin[self._parameters.second]
        return {
            "temperature_difference": difference,
            "difference_flag": (difference >= self._parameters.least).astype(np.uint8),
        }
