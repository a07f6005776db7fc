"""Displacement of a layer's cloud along the line of sight of each point of an image, in whole points.

Toward a sensor at a known altitude every point has a line of sight of its own. Where it meets the layer changes
smoothly over the image: polynomials give it, through exact lines of sight at as many nodes as they need.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.kernels import kernel
from hcss_twin.physics import quadrature
from hcss_twin.physics.geometry import displacement_m
from hcss_twin.physics.quadrature import weigh_row
from hcss_twin.physics.viewing import LinesOfSight
from hcss_twin.providers import Grid

ORDERS = (4, 8, 16, 32, 64)
"""Orders that are tried; 16 does for an image that ends at a zenith angle of 74 deg."""

TOLERANCE = 1e-6
"""Largest error of the polynomials before rounding, in points, unless the highest order leaves more."""

Shifts = NDArray[np.int32]


@dataclass(frozen=True)
class PointShifts:
    """Displacement of a layer's cloud seen from each point.

    Attributes
    ----------
    lines : LinesOfSight
    points : Grid
        The image, in points.
    height_m : float
        At which the layer is met.
    """

    lines: LinesOfSight
    points: Grid
    height_m: float

    def at(self, rows: slice, columns: slice) -> Shifts:
        """Return the displacement (2, y, x) by rows north and columns east; beyond the image that of its edge."""
        order, values = self._nodes
        sizes = self.points.rows, self.points.columns
        inside = [
            np.clip(np.arange(part.start, part.stop), 0, size - 1)
            for part, size in zip((rows, columns), sizes, strict=True)
        ]
        over_rows, over_columns = (
            quadrature.weights(order, (2.0 * places + 1.0 - size) / size)
            for places, size in zip(inside, sizes, strict=True)
        )
        shifts = np.empty((2, len(over_rows), len(over_columns)), dtype=np.int32)
        _round(shifts, over_rows, over_columns, values)
        return shifts

    @cached_property
    def range(self) -> tuple[tuple[int, int], tuple[int, int]]:
        """Smallest and largest displacement (rows, columns); both are at the edges of the image."""
        rows, columns = self.points.rows, self.points.columns
        edges = [
            *(self.at(slice(row, row + 1), slice(0, columns)) for row in (0, rows - 1)),
            *(self.at(slice(0, rows), slice(column, column + 1)) for column in (0, columns - 1)),
        ]
        every = np.concatenate([edge.reshape(2, -1) for edge in edges], axis=1)
        low, high = every.min(axis=1).tolist(), every.max(axis=1).tolist()
        return (low[0], low[1]), (high[0], high[1])

    @property
    def middle(self) -> tuple[int, int]:
        """Displacement (rows, columns) between the smallest and the largest."""
        low, high = self.range
        return (low[0] + high[0]) // 2, (low[1] + high[1]) // 2

    @cached_property
    def _nodes(self) -> tuple[int, Array]:
        """Order of the polynomials, and displacement in points at their nodes (Y, X, 2)."""
        for order in ORDERS:
            values, between = self._exact(quadrature.nodes(order)), quadrature.between(order)
            weights = quadrature.weights(order, between)
            error = np.einsum("yn,nkc,xk->yxc", weights, values, weights) - self._exact(between)
            if np.max(np.abs(error)) <= TOLERANCE:
                break
        return order, values

    def _exact(self, places: Array) -> Array:
        """Displacement in points (N, N, 2) at places along both axes, -1 to 1 from edge to edge."""
        size, half_m = self.points, 0.5 * self.points.pixel_size_m
        x_m, y_m = np.meshgrid(places * half_m * size.columns, places * half_m * size.rows)
        seen = self.lines.from_points(x_m, y_m)
        away = displacement_m(self.height_m, seen.zenith_deg, seen.plane_azimuth_deg)
        return np.ascontiguousarray(np.moveaxis(away, 0, 2) / size.pixel_size_m)


@kernel()
def _round(shifts, over_rows, over_columns, values):  # type: ignore[no-untyped-def]
    """Set the displacement of each point to whole points."""
    of_row = np.empty((over_columns.shape[0], 2))
    for y in range(over_rows.shape[0]):
        weigh_row(of_row, over_rows[y], over_columns, values)
        for x in range(over_columns.shape[0]):
            for axis in range(2):
                shifts[axis, y, x] = np.int32(np.rint(of_row[x, axis]))


def gathered(around: NDArray[np.float32], shifts: Shifts, first: tuple[int, int]) -> NDArray[np.float32]:
    """Return values (Y, X) of a larger plane, which begins ``first`` from a window, at the points of it displaced."""
    seen = np.empty(shifts.shape[1:], dtype=np.float32)
    _gather(seen, np.ascontiguousarray(around), shifts, *first)
    return seen


@kernel()
def _gather(seen, around, shifts, first_row, first_column):  # type: ignore[no-untyped-def]
    """Set what each point sees."""
    for y in range(seen.shape[0]):
        for x in range(seen.shape[1]):
            seen[y, x] = around[y + shifts[0, y, x] - first_row, x + shifts[1, y, x] - first_column]
