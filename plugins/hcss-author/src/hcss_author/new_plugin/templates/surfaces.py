"""A round island of given temperature in the sea."""

import numpy as np
from hcss_twin.providers import Declaration, SurfaceClass, SurfaceInputs, SurfaceMap
from pydantic import BaseModel, ConfigDict, Field


class Parameters(BaseModel):
    """Keys that a scenario can set."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    latitude: float = Field(default=35.0, ge=-80, le=80, description="Of the middle of the island, degrees north.")
    longitude: float = Field(default=150.0, ge=-180, le=360, description="Of the middle, degrees east.")
    radius: float = Field(default=0.02, gt=0, le=5, description="Degrees of latitude.")
    temperature: float = Field(default=300.0, ge=200, le=350, description="Of the island, K.")


class Provider:
    """Sand within a radius of a place, sea elsewhere."""

    declares = Declaration()

    def __init__(self, inputs: SurfaceInputs, parameters: Parameters) -> None:
        self._ground, self._parameters = inputs.ground, parameters
        self.classes: tuple[SurfaceClass, ...] = (SurfaceClass("sea"), SurfaceClass("sand", parameters.temperature))

    def surface(self, time_s: float, rows: slice, columns: slice) -> SurfaceMap:
        """Return 1 for points of the island, 0 for sea."""
        latitude, longitude = self._ground(time_s, rows, columns)
        middle = self._parameters
        east = (longitude - middle.longitude) * np.cos(np.radians(middle.latitude))
        inside = np.hypot(latitude - middle.latitude, east) < middle.radius
        return SurfaceMap(inside.astype(np.uint8))
