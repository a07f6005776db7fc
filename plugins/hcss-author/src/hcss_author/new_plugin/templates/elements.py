"""A warm square that covers one pixel and rests on the sea."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np
from hcss_twin.providers import Declaration, ElementInputs, ElementPixels, ElementScene
from pydantic import BaseModel, ConfigDict, Field


class Parameters(BaseModel):
    """Keys that a scenario can set."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    temperature: float = Field(default=320.0, ge=200, le=1000, description="Of a black body, K.")
    share: float = Field(default=0.5, gt=0, le=1, description="Share of the pixel that is covered.")


class Provider:
    """The pixel right and below the image centre is covered in part by a black body."""

    declares = Declaration()
    variables: Mapping[str, tuple[str, str]] = MappingProxyType({"number": ("1", "Number of the square.")})

    def __init__(self, inputs: ElementInputs, parameters: Parameters) -> None:
        self._parameters = parameters
        self._radiance = inputs.black_body(parameters.temperature)

    def pixels(self, time_s: float, rows: slice, columns: slice, scene: ElementScene) -> Sequence[ElementPixels]:
        """Return the one pixel, if it is in the window."""
        row, column = (
            np.floor(position).astype(np.intp) for position in scene.project(np.zeros(1), np.zeros(1), np.zeros(1))
        )
        if not (rows.start <= row[0] < rows.stop and columns.start <= column[0] < columns.stop):
            return []
        share, radiance = np.array([self._parameters.share]), self._radiance.copy()
        return [
            ElementPixels(row, column, share, 0.0, radiance, None, self._parameters.temperature, {"number": np.ones(1)})
        ]
