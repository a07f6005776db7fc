"""The plane of the scene in points: where clouds, surfaces and elements are defined, whatever the rays see of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import Problem, ScenarioError
from hcss_twin.core.kernels import kernel
from hcss_twin.plan.combinations import goes_on_with
from hcss_twin.plan.windows import Window, length
from hcss_twin.providers import CloudGenerator, Grid

LARGEST_POINTS = 2**26
"""Points of the scene below one window."""


@dataclass(frozen=True)
class ScenePlane:
    """The plane of a scene.

    Attributes
    ----------
    grid : Grid
        In pixels.
    samples : int
        Points along each side of a pixel; their centres are whole numbers.
    """

    grid: Grid
    samples: int

    @property
    def point_m(self) -> float:
        """Distance between points."""
        return self.grid.pixel_size_m / self.samples

    def in_points(self, x_m: Array, y_m: Array) -> tuple[Array, Array]:
        """Return row and column (...), in points, of places eastward and northward from the centre (...).

        Half a point beyond the outermost centres is still inside the image: such places are moved to these.
        """
        return self._in_points(y_m, self.grid.rows), self._in_points(x_m, self.grid.columns)

    def around(self, row: Array, column: Array) -> Window | None:
        """Return the pixels that hold points (...); None if all are NaN."""
        if np.all(np.isnan(row)):
            return None
        return self._around(row, self.grid.rows), self._around(column, self.grid.columns)

    def corner_of(self, window: Window) -> tuple[int, int]:
        """Return row and column of the first point of a window of pixels."""
        return window[0].start * self.samples, window[1].start * self.samples

    def require_in_reach(self, generator: CloudGenerator, window: Window, time_s: float) -> None:
        """Raise a :class:`ScenarioError` if a window that rays see is too large, or outside the clouds of a layer."""
        (rows, columns), grid = window, self.grid
        inside = rows.start >= 0 and columns.start >= 0 and rows.stop <= grid.rows and columns.stop <= grid.columns
        count = length(rows) * length(columns) * self.samples**2
        if count > LARGEST_POINTS:
            message = (
                f"rays meet {count:.3g} points of the scene at time {time_s:g} s; allowed: up to {LARGEST_POINTS:.3g}, "
                "with larger image.pixel_size or a smaller field"
            )
        elif not inside and not hasattr(generator, "thickness_around_m"):
            message = (
                f"rays meet rows {rows.start} to {rows.stop} and columns {columns.start} to {columns.stop} of the "
                f"scene at time {time_s:g} s; allowed: its {grid.rows} x {grid.columns} pixels, where these clouds "
                f"end, or {goes_on_with(generator)}"
            )
        else:
            return
        raise ScenarioError([Problem("image", message)])

    def _in_points(self, place_m: Array, size: int) -> Array:
        position = np.empty(place_m.shape)
        _to_points(position.reshape(-1), np.ascontiguousarray(place_m).reshape(-1), self.point_m, size * self.samples)
        return position

    def _around(self, position: Array, size: int) -> slice:
        """Return the pixels that hold positions along one axis, and the neighbours between which they are."""
        least, most = float(np.nanmin(position)), float(np.nanmax(position))
        low, high = int(np.floor(least)), int(np.floor(most)) + 2
        if most <= size * self.samples - 1:  # at the outermost centre there is nothing to interpolate
            high = min(high, size * self.samples)
        return slice(low // self.samples, -(-high // self.samples))


@kernel()
def _to_points(position, place_m, point_m, size):  # type: ignore[no-untyped-def]
    """Set positions (N,) along an axis of so many points, from places (N,); those of the outer half at its centre."""
    last = size - 1.0
    for n in range(place_m.size):
        at = place_m[n] / point_m + 0.5 * last
        if -0.5 <= at < 0.0:
            at = 0.0
        elif last < at <= last + 0.5:
            at = last
        position[n] = at
