"""Parameters of the element provider ``point-sources``."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from hcss_twin.core.units import QuantityParser as Quantity

_EACH = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

FARTHEST_M = 1e8
"""Greatest distance of a source from the image centre along an axis: more than twice round the Earth."""

_Speed = Annotated[Quantity.Speed, Field(ge=-1e5, le=1e5)]


class Track(BaseModel):
    """One source that moves in a straight line at constant speed, or along a path."""

    model_config = _EACH

    x: Quantity.Length = Field(
        0.0, ge=-FARTHEST_M, le=FARTHEST_M, description="Metres east of the image centre, both at the start."
    )
    y: Quantity.Length = Field(
        0.0, ge=-FARTHEST_M, le=FARTHEST_M, description="Metres north of the image centre, both at the start."
    )
    altitude: Quantity.Length = Field(0.0, ge=0, le=1e6, description="Metres above the sea, at the start.")
    velocity: tuple[_Speed, _Speed, _Speed] = Field((0.0, 0.0, 0.0), description="East, north and up, m/s.")
    path: tuple[tuple[float, float, float, float], ...] = Field(
        (),
        description="In place of x, y, altitude and velocity: time (s), x, y and altitude (m) of at least two points, "
        "linear between them; the source is absent before and after.",
    )
    intensity: float | dict[str, float] | None = Field(
        None,
        description="Of a plume, which hides nothing: radiant intensity toward the sensor, W/sr, a number for all "
        "bands, or a table by band.",
    )
    temperature: Quantity.Temperature | None = Field(
        None, gt=0, le=10_000, description="Of a body, which hides what is behind it, K; with area."
    )
    area: Quantity.Area | None = Field(
        None, gt=0, le=1e8, description="Of a body, across the line of sight, m2; with temperature."
    )
    emissivity: Quantity.Fraction = Field(
        1.0, gt=0, le=1, description="Of a body; it reflects the rest of sunlight and sky as a horizontal diffuser."
    )

    @model_validator(mode="after")
    def _one_motion(self) -> Self:
        if not self.path:
            return self
        if any((self.x, self.y, self.altitude, *self.velocity)):
            raise ValueError("path with x, y, altitude or velocity; allowed: path alone")
        times = [point[0] for point in self.path]
        if len(times) < 2 or any(later <= time for time, later in pairwise(times)):
            raise ValueError("path: allowed: at least two points whose times ascend")
        if any(max(abs(point[1]), abs(point[2])) > FARTHEST_M or not 0.0 <= point[3] <= 1e6 for point in self.path):
            raise ValueError(f"path: allowed: x and y within {FARTHEST_M:g} m, altitudes from 0 to 1e+06 m")
        return self

    @model_validator(mode="after")
    def _one_strength(self) -> Self:
        if (self.temperature is None) != (self.area is None) or (self.intensity is None) == (self.area is None):
            raise ValueError("allowed: either intensity (a plume), or temperature with area (a body)")
        if self.area is None and "emissivity" in self.model_fields_set:
            raise ValueError("emissivity without temperature and area; allowed: with them")
        values = self.intensity.values() if isinstance(self.intensity, dict) else [self.intensity or 0.0]
        if min(values, default=0.0) < 0.0:
            raise ValueError(f"intensity {min(values):g} W/sr; allowed: 0 or more; closest valid choice is 0")
        return self


class PointSourceParameters(BaseModel):
    """Parameters of the element provider ``point-sources``; `tracks`, `file` or both."""

    model_config = _EACH

    tracks: tuple[Track, ...] = Field(
        (),
        description="Sources with `x`, `y` (from the image centre at the start), `altitude` (m), "
        "`velocity` ([east, north, up], m/s) or a `path` of points [time, x, y, altitude], "
        "and the `intensity` of a plume (W/sr, a number or a table by band), or `temperature`"
        " (K), `area` (m2, across the line of sight) and `emissivity` (default 1) of a body.",
    )
    file: str | None = Field(
        None,
        min_length=1,
        description="CSV file of tracks with the columns source, time (s), x, y or latitude, longitude "
        "(degrees), altitude, and `intensity`, `intensity BAND` for each band, or "
        "temperature, area and optionally emissivity; linear between the times of a source, "
        "which is absent outside them.",
    )
    footprint: Quantity.Length = Field(
        0.0, ge=0, le=1e5, description="Side of the square, m, over which a source is spread evenly; 0: not."
    )

    @model_validator(mode="after")
    def _some_source(self) -> Self:
        if not self.tracks and self.file is None:
            raise ValueError("no source; allowed: tracks, file or both")
        return self
