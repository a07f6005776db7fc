"""Rays of a conical scanner: each row is an arc on the ground, seen at one zenith angle from an advancing platform."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import cast

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from hcss_twin import Scenario
from hcss_twin.plan.rays import Rays
from hcss_twin.providers import Array, Catalog, Grid, SectionSpec, View, hookimpl


class ConicalScanner(BaseModel):
    """Section ``[conical_scanner]``."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)
    altitude: float = Field(5e5, ge=1e4, le=2e6, description="Height of the platform above a flat sea, m.")
    zenith: float = Field(53.0, gt=0, le=70, description="Zenith angle of all lines of sight, degrees.")
    half_arc: float = Field(20.0, gt=0, le=60, description="Half the arc that a row scans ahead, degrees.")
    rows: int = Field(32, ge=1, le=4096, description="Arcs of a frame.")
    columns: int = Field(64, ge=2, le=4096, description="Pixels of an arc.")
    step: float = Field(1000.0, gt=0, le=1e5, description="Advance of the platform between rows, m.")


@dataclass(frozen=True)
class Cone:
    """Directions of the arc: positions along x are azimuths, and along y all are alike."""

    given: ConicalScanner
    suns: None = None

    def at(self, places: Iterable[tuple[float, float]]) -> list[View]:
        """Return the view back to the platform from positions."""
        return [View(self.given.zenith, (180.0 + self.given.half_arc * x) % 360.0) for x, _ in places]


class ConicalRays(Rays):
    """Rays that turn about the vertical; the middle of the frame is that of the scene."""

    def __init__(self, given: ConicalScanner) -> None:
        self._given, self.directions, self.view = given, Cone(given), View(given.zenith, 180.0)
        self.image, self.samples_per_pixel = Grid(given.rows, given.columns, given.step), 3

    def points_m(self, window: tuple[slice, slice], time_s: float, height_m: float) -> tuple[Array, Array]:
        """Return where lines of sight meet a height: on a circle around the platform."""
        given, per = self._given, self.samples_per_pixel
        row, column = ((np.arange(pixels.start * per, pixels.stop * per) + 0.5) / per for pixels in window)
        azimuth, reach = np.radians(given.half_arc) * self._azimuth(column), math.tan(math.radians(given.zenith))
        x_m, y_m = ((given.altitude - height_m) * reach * of(azimuth) for of in (np.sin, np.cos))
        advance_m = (row - 0.5 * given.rows)[:, None] * given.step - given.altitude * reach
        return np.broadcast_to(x_m, (row.size, column.size)), advance_m + y_m

    def positions(self, window: tuple[slice, slice], time_s: float) -> tuple[Array, Array]:
        """Return the positions of pixels on the arc."""
        row, column = (np.arange(pixels.start, pixels.stop, dtype=np.float64) + 0.5 for pixels in window)
        return np.tile(self._azimuth(column), (row.size, 1)), np.zeros((row.size, column.size))

    def project(
        self, x_m: Array, y_m: Array, altitude_m: Array, time_s: float, later_s: float = 0.0
    ) -> tuple[Array, Array]:
        """Return the arc from whose height on the cone points are seen, and the place along it."""
        given, slope = self._given, math.tan(math.radians(self._given.zenith))
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
        given, zenith = self._given, math.radians(self._given.zenith)
        below_m = given.altitude - (0.0 if point_m is None else point_m[2])
        arc_m = below_m * math.tan(zenith) * 2.0 * math.radians(given.half_arc) / given.columns
        azimuth = math.radians(given.half_arc) * (2.0 * column / given.columns - 1.0)
        return given.step * math.cos(azimuth) * arc_m * math.cos(zenith)

    def angles_deg(self, window: tuple[slice, slice], time_s: float) -> tuple[Array, Array]:
        """Return zenith and azimuth of the platform at pixels: back along the arc's azimuth."""
        along, _ = self.positions(window, time_s)
        return np.full_like(along, self._given.zenith), (180.0 + self._given.half_arc * along) % 360.0

    def _azimuth(self, column: Array) -> Array:  # -1 to 1 along the arc
        return 2.0 * column / self._given.columns - 1.0


def make_rays(scenario: Scenario, catalog: Catalog) -> ConicalRays:
    """Return the rays of a scenario with the section."""
    return ConicalRays(cast(ConicalScanner, scenario.sections["conical_scanner"]))


@hookimpl
def hcss_sections() -> list[SectionSpec]:
    """Name the section, and what makes its rays."""
    return [SectionSpec("conical_scanner", f"{__name__}:ConicalScanner", "Arcs ahead.", f"{__name__}:make_rays")]
