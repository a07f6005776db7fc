"""Split window: the brightness-temperature difference that tells thin ice cloud from water cloud, as a variable."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from hcss_twin.core.units import QuantityParser as Quantity
from hcss_twin.providers import Declaration, OutputVariable, ProviderError, VariableInputs, choose_from


class Parameters(BaseModel):
    """Keys that a scenario can set."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    bands: tuple[str, str] = Field(("10.3-11.3um", "11.5-12.5um"), description="Names of the two bands.")
    thin: Quantity.TemperatureDifference = Field(
        2.0, gt=0, le=50, description="Difference from which a pixel counts as thin cloud, K."
    )


class SplitWindow:
    """Brightness temperature of one band less that of another, and a flag."""

    declares = Declaration()
    needs = ("brightness_temperature",)
    variables: Mapping[str, OutputVariable] = MappingProxyType(
        {
            "split_window_difference": OutputVariable(
                "K", "split-window difference", "Brightness temperature of the first band less that of the second."
            ),
            "split_window_class": OutputVariable(
                "1", "class by split window", "Whether the difference reaches that of thin cloud.", dtype="uint8",
                flag_meanings=("opaque_or_clear", "thin_cloud"),
            ),
        }
    )  # fmt: skip

    def __init__(self, inputs: VariableInputs, parameters: Parameters) -> None:
        names = [band.name for band in inputs.bands]
        for name in parameters.bands:
            if name not in names:
                raise ProviderError(f"split-window: bands has {name!r}; {choose_from(name, names)}")
        self._first, self._second = (names.index(name) for name in parameters.bands)
        self._thin = parameters.thin

    def values(self, fields: Mapping[str, NDArray[Any]], time_s: float) -> Mapping[str, NDArray[Any]]:
        """Return both variables (y, x) of a part of a frame."""
        kelvin = fields["brightness_temperature"]
        difference = kelvin[self._first] - kelvin[self._second]
        return {
            "split_window_difference": difference,
            "split_window_class": (difference >= self._thin).astype(np.uint8),
        }
