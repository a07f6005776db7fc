"""What a conical scanner sees of points: its arcs, pixels and angles, for elements and variables of geometry."""

from __future__ import annotations

import math

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from hcss_twin.core.units import QuantityParser as Quantity
from hcss_twin.plan.rays import Rays
from hcss_twin.providers import Array


class ConicalScanner(BaseModel):
    """Section ``[conical_scanner]``."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)
    altitude: Quantity.Length = Field(5e5, ge=1e4, le=2e6, description="Height of the platform above a flat sea, m.")
    zenith: Quantity.Angle = Field(53.0, gt=0, le=70, description="Zenith angle of all lines of sight, degrees.")
    half_arc: Quantity.Angle = Field(20.0, gt=0, le=60, description="Half the arc that a row scans ahead, degrees.")
    rows: int = Field(32, ge=1, le=4096, description="Arcs of a frame.")
    columns: int = Field(64, ge=2, le=4096, description="Pixels of an arc.")
    step: Quantity.Length = Field(1000.0, gt=0, le=1e5, description="Advance of the platform between rows, m.")


class ConicalProjection(Rays):
    """Rays to which points can be projected."""

    given: ConicalScanner

    def along_arc(self, column: Array) -> Array:
        """Return places along the arc, -1 to 1, of columns."""
        return 2.0 * column / self.given.columns - 1.0

    def project(
        self, x_m: Array, y_m: Array, altitude_m: Array, time_s: float, later_s: float = 0.0
    ) -> tuple[Array, Array]:
        """Return the arc from whose height on the cone points are seen, and the place along it."""
        given, slope = self.given, math.tan(math.radians(self.given.zenith))
        reach_m = (given.altitude - altitude_m) * slope
        across = np.divide(x_m, reach_m, out=np.full_like(reach_m, np.inf), where=reach_m > 0.0)
        seen = np.abs(across) < 1.0
        azimuth = np.arcsin(np.where(seen, across, 0.0))
        advance_m = y_m - reach_m * np.cos(azimuth)
        row = (advance_m + given.altitude * slope) / given.step + 0.5 * given.rows
        column = 0.5 * given.columns * (1.0 + azimuth / math.radians(given.half_arc))
        return np.where(seen, row, self.NOWHERE), np.where(seen, column, self.NOWHERE)

    def pixel_area_m2(
        self, row: float, column: float, time_s: float, point_m: tuple[float, float, float] | None = None
    ) -> float:
        """Return the area: arcs shrink toward the platform, the step between them does not."""
        given, zenith = self.given, math.radians(self.given.zenith)
        below_m = given.altitude - (0.0 if point_m is None else point_m[2])
        arc_m = below_m * math.tan(zenith) * 2.0 * math.radians(given.half_arc) / given.columns
        azimuth = math.radians(given.half_arc) * (2.0 * column / given.columns - 1.0)
        return given.step * math.cos(azimuth) * arc_m * math.cos(zenith)

    def angles_deg(self, window: tuple[slice, slice], time_s: float) -> tuple[Array, Array]:
        """Return zenith and azimuth of the platform at pixels: back along the arc's azimuth."""
        along, _ = self.positions(window, time_s)
        return np.full_like(along, self.given.zenith), (180.0 + self.given.half_arc * along) % 360.0
