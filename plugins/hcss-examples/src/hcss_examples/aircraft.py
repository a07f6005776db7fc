"""An aircraft smaller than a pixel: its skin hides what is below, its plume adds the light of hot gas."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from hcss_twin.core.units import QuantityParser as Quantity
from hcss_twin.providers import Declaration, ElementInputs, ElementPoint, ElementScene, ProviderError, choose_from


class Parameters(BaseModel):
    """Keys that a scenario can set."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    x: Quantity.Length = Field(0.0, ge=-1e8, le=1e8, description="Start, m east of the image centre.")
    y: Quantity.Length = Field(0.0, ge=-1e8, le=1e8, description="Start, m north of the image centre.")
    altitude: Quantity.Length = Field(10_000.0, ge=0, le=30_000, description="Start, m above the sea.")
    speed: Quantity.Speed = Field(240.0, ge=0, le=1000, description="Over the ground, m/s.")
    heading: Quantity.Angle = Field(90.0, ge=0, le=360, description="Degrees clockwise from north.")
    climb: Quantity.Speed = Field(0.0, ge=-100, le=100, description="Vertical speed, m/s.")
    area: Quantity.Area = Field(150.0, gt=0, le=1e8, description="Of the skin across the line of sight, m2.")
    skin: Quantity.Temperature = Field(245.0, gt=0, le=2000, description="Temperature of the skin, a black body, K.")
    plume: Mapping[str, float] = Field({}, description="Radiant intensity of the plume by band, W/sr; others: none.")


class Aircraft:
    """An aircraft on a straight course."""

    declares = Declaration(notes=("aircraft: its skin reflects nothing",))
    variables: Mapping[str, tuple[str, str]] = MappingProxyType(
        {"altitude": ("m", "Altitude of the aircraft."), "skin": ("K", "Temperature of the aircraft's skin.")}
    )

    def __init__(self, inputs: ElementInputs, parameters: Parameters) -> None:
        self._of, names = parameters, [band.name for band in inputs.bands]
        for name in parameters.plume:
            if name not in names:
                raise ProviderError(f"aircraft: plume names '{name}', which is no band; {choose_from(name, names)}")
        self._skin = inputs.black_body(parameters.skin)
        self._plume = np.array([parameters.plume.get(name, 0.0) for name in names])

    def pixels(self, time_s: float, rows: slice, columns: slice, scene: ElementScene) -> Sequence[ElementPoint]:
        """Return skin and plume as points, which the engine draws."""
        of, angle = self._of, math.radians(self._of.heading)
        velocity = of.speed * math.sin(angle), of.speed * math.cos(angle), of.climb
        x, y, altitude = (
            start + time_s * speed for start, speed in zip((of.x, of.y, of.altitude), velocity, strict=True)
        )
        if altitude < 0.0:
            return []
        point = ElementPoint(x, y, altitude, velocity_m_s=velocity, truth={"altitude": altitude, "skin": of.skin})
        parts = [replace(point, radiance=self._skin.copy(), area_m2=of.area, temperature_K=of.skin)]
        if np.any(self._plume):
            parts.append(replace(point, intensity=self._plume.copy()))
        return parts
