"""An aircraft smaller than a pixel: its skin hides what is below, its plume adds the light of hot gas."""

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from hcss_twin.errors import ProviderError, choose_from
from hcss_twin.providers import Declaration, ElementInputs, ElementPixels, ElementScene


class Parameters(BaseModel):
    """Keys that a scenario can set."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    x: float = Field(0.0, ge=-1e8, le=1e8, description="Start, m east of the image centre.")
    y: float = Field(0.0, ge=-1e8, le=1e8, description="Start, m north of the image centre.")
    altitude: float = Field(10_000.0, ge=0, le=30_000, description="Start, m above the sea.")
    speed: float = Field(240.0, ge=0, le=1000, description="Over the ground, m/s.")
    heading: float = Field(90.0, ge=0, le=360, description="Degrees clockwise from north.")
    climb: float = Field(0.0, ge=-100, le=100, description="Vertical speed, m/s.")
    area: float = Field(150.0, gt=0, le=1e8, description="Of the skin as the sensor sees it, m2.")
    skin: float = Field(245.0, gt=0, le=2000, description="Temperature of the skin, a black body, K.")
    plume: Mapping[str, float] = Field({}, description="Radiant intensity of the plume by band, W/sr; others: none.")


class Aircraft:
    """An aircraft on a straight course."""

    declares = Declaration(notes=("aircraft: its skin reflects nothing",))
    variables: Mapping[str, tuple[str, str]] = MappingProxyType(
        {"altitude": ("m", "Altitude of the aircraft."), "skin": ("K", "Temperature of the aircraft's skin.")}
    )

    def __init__(self, inputs: ElementInputs, parameters: Parameters) -> None:
        self._of = parameters
        self._share = parameters.area / inputs.grid.pixel_size_m**2
        if self._share > 1.0:
            raise ProviderError(
                f"aircraft: area {parameters.area:g} m2; allowed: up to that of a pixel, "
                f"{inputs.grid.pixel_size_m**2:g} m2, because one pixel holds the aircraft"
            )
        names = [band.name for band in inputs.bands]
        for name in parameters.plume:
            if name not in names:
                raise ProviderError(f"aircraft: plume names '{name}', which is no band; {choose_from(name, names)}")
        self._skin = inputs.black_body(parameters.skin)
        self._plume = np.array([parameters.plume.get(name, 0.0) for name in names])

    def pixels(self, time_s: float, rows: slice, columns: slice, scene: ElementScene) -> Sequence[ElementPixels]:
        """Return the pixel of the aircraft, if it is in the window."""
        of, way = self._of, self._of.speed * time_s
        angle, altitude = math.radians(of.heading), of.altitude + of.climb * time_s
        place = of.x + way * math.sin(angle), of.y + way * math.cos(angle), altitude
        row, column = (np.floor(each).astype(np.intp) for each in scene.project(*(np.array([each]) for each in place)))
        if altitude < 0.0 or not (rows.start <= row[0] < rows.stop and columns.start <= column[0] < columns.stop):
            return []
        truth = {"altitude": np.array([altitude]), "skin": np.array([of.skin])}
        share, whole = np.array([self._share]), np.ones(1)
        parts = [ElementPixels(row, column, share, altitude, self._skin, None, of.skin, truth)]
        if np.any(self._plume):
            parts.append(ElementPixels(row, column, whole, altitude, None, self._plume, None, truth))
        return parts
