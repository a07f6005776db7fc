"""Rays of a push-broom: each row is seen at one zenith angle from straight above its middle, fanning out along x."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from hcss_twin import Scenario
from hcss_twin.plan.rays import Rays
from hcss_twin.providers import Array, Catalog, Grid, View
from pydantic import BaseModel, ConfigDict, Field


class Settings(BaseModel):
    """Keys of the section."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    altitude: float = Field(default=5e5, ge=1e4, le=2e6, description="Height of the platform above a flat sea, m.")
    half_width: float = Field(default=5.0, gt=0, le=60, description="Angle between vertical and edge, degrees.")
    rows: int = Field(default=32, ge=1, le=4096, description="Rows of a frame.")
    columns: int = Field(default=32, ge=2, le=4096, description="Pixels of a row.")
    step: float = Field(default=500.0, gt=0, le=1e5, description="Advance of the platform between rows, m.")


@dataclass(frozen=True)
class Fan:
    """Directions of a row: positions along x are equal steps of the angle; along y all are alike."""

    half_width_deg: float
    suns: None = None

    def at(self, places: Iterable[tuple[float, float]]) -> list[View]:
        """Return the view back to the platform from positions."""
        angles = [self.half_width_deg * x for x, _ in places]
        return [View(abs(angle), 270.0 if angle > 0.0 else 90.0) for angle in angles]


class FanRays(Rays):
    """Where the pixels of a frame look; its middle is that of the scene."""

    def __init__(self, given: Settings) -> None:
        self._given, self.directions, self.view = given, Fan(given.half_width), View(0.0, 0.0)
        self.image, self.samples_per_pixel = Grid(given.rows, given.columns, given.step), 2

    def points_m(self, window: tuple[slice, slice], time_s: float, height_m: float) -> tuple[Array, Array]:
        """Return where lines of sight meet a height, metres east and north of the centre of the scene."""
        given, per = self._given, self.samples_per_pixel
        row, column = ((np.arange(pixels.start * per, pixels.stop * per) + 0.5) / per for pixels in window)
        x_m = (given.altitude - height_m) * np.tan(math.radians(given.half_width) * self._along(column))
        y_m = (row - 0.5 * given.rows) * given.step
        x, y = np.broadcast_arrays(x_m[None, :], y_m[:, None])
        return x, y

    def positions(self, window: tuple[slice, slice], time_s: float) -> tuple[Array, Array]:
        """Return the positions of pixels in the fan, -1 to 1."""
        row, column = (np.arange(pixels.start, pixels.stop, dtype=np.float64) + 0.5 for pixels in window)
        return np.tile(self._along(column), (row.size, 1)), np.zeros((row.size, column.size))

    def _along(self, column: Array) -> Array:
        return 2.0 * column / self._given.columns - 1.0


def make_rays(scenario: Scenario, catalog: Catalog) -> Rays:
    """Return the rays of a scenario with the section."""
    (settings,) = (settings for settings in scenario.sections.values() if isinstance(settings, Settings))
    return FanRays(settings)
