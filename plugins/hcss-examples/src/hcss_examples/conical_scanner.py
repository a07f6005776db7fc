"""Rays of a conical scanner: each row is an arc on the ground, seen at one zenith angle from an advancing platform."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import cast

import numpy as np

from hcss_examples.conical_projection import ConicalProjection, ConicalScanner
from hcss_twin import Scenario
from hcss_twin.providers import Array, Catalog, Grid, SectionSpec, View, hookimpl


@dataclass(frozen=True)
class Cone:
    """Directions of the arc: positions along x are azimuths, and along y all are alike."""

    given: ConicalScanner
    suns: None = None

    def at(self, places: Iterable[tuple[float, float]]) -> list[View]:
        """Return the view back to the platform from positions."""
        return [View(self.given.zenith, (180.0 + self.given.half_arc * x) % 360.0) for x, _ in places]


class ConicalRays(ConicalProjection):
    """Rays that turn about the vertical; the middle of the frame is that of the scene."""

    def __init__(self, given: ConicalScanner) -> None:
        self.given, self.directions, self.view = given, Cone(given), View(given.zenith, 180.0)
        self.image, self.samples_per_pixel = Grid(given.rows, given.columns, given.step), 3

    def points_m(self, window: tuple[slice, slice], time_s: float, height_m: float) -> tuple[Array, Array]:
        """Return where lines of sight meet a height: on a circle around the platform."""
        given, per = self.given, self.samples_per_pixel
        row, column = ((np.arange(pixels.start * per, pixels.stop * per) + 0.5) / per for pixels in window)
        azimuth, reach = np.radians(given.half_arc) * self.along_arc(column), math.tan(math.radians(given.zenith))
        x_m, y_m = ((given.altitude - height_m) * reach * of(azimuth) for of in (np.sin, np.cos))
        advance_m = (row - 0.5 * given.rows)[:, None] * given.step - given.altitude * reach
        return np.broadcast_to(x_m, (row.size, column.size)), advance_m + y_m

    def positions(self, window: tuple[slice, slice], time_s: float) -> tuple[Array, Array]:
        """Return the positions of pixels on the arc."""
        row, column = (np.arange(pixels.start, pixels.stop, dtype=np.float64) + 0.5 for pixels in window)
        return np.tile(self.along_arc(column), (row.size, 1)), np.zeros((row.size, column.size))


def make_rays(scenario: Scenario, catalog: Catalog) -> ConicalRays:
    """Return the rays of a scenario with the section."""
    return ConicalRays(cast(ConicalScanner, scenario.sections["conical_scanner"]))


@hookimpl
def hcss_sections() -> list[SectionSpec]:
    """Name the section, and what makes its rays."""
    return [SectionSpec("conical_scanner", f"{__name__}:ConicalScanner", "Arcs ahead.", f"{__name__}:make_rays")]
