"""Radiance of the pixels of a frame, each toward its own direction, from tables toward few directions.

The tables of a pass lie at the nodes of polynomials over its rectangle of directions. A frame covers a small part of
the rectangle, where polynomials of lower order do: their tables are combinations of those of the pass. These in turn
are combinations of still fewer (:mod:`hcss_twin.engine.tables.mixed_tables`), which are looked up together.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from copy import copy
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.engine.tables.look_up import LookUp
from hcss_twin.engine.tables.mixed_tables import mix, mixed_tables, on_common_nodes
from hcss_twin.engine.tables.over_views import GridViews, Thickness, ViewedLookUp
from hcss_twin.engine.tables.radiance_tables import DenseTable
from hcss_twin.physics import quadrature
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.rays import Rays
from hcss_twin.plan.views import ViewAxis
from hcss_twin.plan.windows import Window, length

LOST = 1e-5
"""Largest relative error of the polynomials of a frame, relative to those of the pass."""


@dataclass(frozen=True, eq=False)
class FrameViews:
    """Nodes of the directions of one frame.

    Attributes
    ----------
    rays : Rays
    time_s : float
        Of the frame.
    middle, half : (float, float)
        Of the frame's rectangle, in coordinates of the pass.
    orders : (int, int)
        Polynomial order along x and y.
    of_pass : ndarray (N, M) or None
        Weight of the M tables of the pass at the N nodes; None: the nodes are those of the pass.
    """

    rays: Rays
    time_s: float
    middle: tuple[float, float]
    half: tuple[float, float]
    orders: tuple[int, int]
    of_pass: Array | None

    def weights(self, x: Array, y: Array) -> Array:
        """Return the weights (N, n) of the nodes at positions x and y (n,) of the pass."""
        return self.weights_at(*self.within(x, y))

    def within(self, x: Array, y: Array) -> tuple[Array, Array]:
        """Return positions in the frame's rectangle, -1 to 1, of those of the pass."""
        (at_x, at_y), (half_x, half_y) = self.middle, self.half
        return (x - at_x) / half_x, (y - at_y) / half_y

    def positions(self, window: Window) -> tuple[Array, Array]:
        """Return the positions x and y (y, x) of pixels in the frame's rectangle; 0 off the ground."""
        places = self.rays.positions(window, self.time_s)
        x, y = (np.where(np.isnan(position), at, position) for position, at in zip(places, self.middle, strict=True))
        return self.within(x, y)

    def weights_of(self, window: Window) -> Array:
        """Return the weights (N, pixels) of the nodes for the pixels of a window."""
        x, y = self.positions(window)
        return self.weights_at(x.ravel(), y.ravel())

    def weights_at(self, x: Array, y: Array) -> Array:
        """Return the weights (N, n) of the nodes at positions x and y (n,) in the frame's rectangle."""
        across, up = quadrature.weights(self.orders[0], x), quadrature.weights(self.orders[1], y)
        product: Array = (up[:, :, None] * across[:, None, :]).reshape(x.size, -1).T
        return product

    def look_ups(self, of_pass: Sequence[LookUp]) -> list[LookUp]:
        """Return the look-ups at the nodes."""
        if self.of_pass is None:
            return list(of_pass)
        tables = [look_up.table for look_up in of_pass]
        nodes, alone = on_common_nodes(tables)
        clear = np.stack([table.clear for table in tables])
        made: list[LookUp] = []
        for weight in self.of_pass:
            mixed = tuple(np.tensordot(weight, columns, 1) for columns in alone)
            made.append(LookUp(DenseTable(weight @ clear, nodes, mixed, None), made[0] if made else None))
        return made


def frame_views(axis: ViewAxis, rays: Rays, time_s: float, tables: Sequence[DenseTable]) -> FrameViews:
    """Return the nodes of a frame: the fewest whose polynomials equal those of the pass within ``LOST``.

    Tables with clouds in two layers are not combined, nor are those of frames whose rays do not say what they see.
    """
    orders = axis.order_x, axis.order_y
    whole = FrameViews(rays, time_s, (0.0, 0.0), (1.0, 1.0), orders, None)
    bounds = None if max(orders) == 0 or any(table.both is not None for table in tables) else rays.bounds(time_s)
    if bounds is None:
        return whole
    clipped = [(max(-1.0, min(low, 1.0)), max(-1.0, min(high, 1.0))) for low, high in bounds]
    middle = tuple(0.5 * (low + high) for low, high in clipped)
    half = tuple(max(0.5 * (high - low), 1e-9) for low, high in clipped)
    sample = np.stack(
        [
            np.concatenate((table.clear, *(columns[[0, -1]].ravel() for columns in table.alone if columns.size)))
            for table in tables
        ]
    )
    test = np.linspace(-1.0, 1.0, 7)
    x, y = (coordinates.ravel() for coordinates in np.meshgrid(middle[0] + half[0] * test, middle[1] + half[1] * test))
    true = whole.weights(x, y).T @ sample
    scale = np.maximum(np.abs(true), 1e-6 * np.max(np.abs(true), axis=0, initial=0.0) + 1e-300)
    for least in range(max(orders)):
        few = min(least, orders[0]), min(least, orders[1])
        if (few[0] + 1) * (few[1] + 1) >= (orders[0] + 1) * (orders[1] + 1):
            break
        at_x = middle[0] + half[0] * quadrature.nodes(few[0])
        at_y = middle[1] + half[1] * quadrature.nodes(few[1])
        node_x, node_y = (coordinates.ravel() for coordinates in np.meshgrid(at_x, at_y))
        of_pass = whole.weights(node_x, node_y).T
        guess = FrameViews(rays, time_s, (middle[0], middle[1]), (half[0], half[1]), few, of_pass)
        if np.max(np.abs(guess.weights(x, y).T @ (of_pass @ sample) - true) / scale) <= LOST:
            return guess
    return whole


PixelViews: TypeAlias = GridViews | FrameViews


def pixel_views(plan: Plan, time_s: float, tables: Sequence[DenseTable]) -> PixelViews | None:
    """Return the views of the pixels of a frame, from its tables for the nodes of the axis; None if they share one."""
    if plan.views is None:
        return None
    return GridViews(plan.views, plan.grid) if plan.is_grid else frame_views(plan.views, plan.rays, time_s, tables)


def views_together(plan: Plan, time_s: float, look_ups: Sequence[LookUp]) -> LookUp | ViewedLookUp:
    """Return the look-up of a frame with the view of each pixel, from one for each node of the axis if there is one."""
    if plan.views is None:
        return look_ups[0]
    if plan.is_grid:
        return ViewedLookUp(plan.views, plan.grid, look_ups)
    views = frame_views(plan.views, plan.rays, time_s, [look_up.table for look_up in look_ups])
    return DirectedLookUp(views, views.look_ups(look_ups), plan.extent)


class DirectedLookUp(ViewedLookUp):
    """Look-up of a frame with the direction of each pixel."""

    def __init__(self, views: FrameViews, look_ups: Sequence[LookUp], extent: Window) -> None:
        self._views, self._look_ups = views, look_ups
        self._mixed = mixed_tables([look_up.table for look_up in look_ups], views.orders, LOST)
        self._rows, self._columns = extent

    def of_part(self, extent: Window) -> DirectedLookUp:
        """Return the look-up of some rows and columns of the image, counted from the first of them."""
        part = copy(self)
        part._rows, part._columns = extent
        return part

    def _channels(self, channels: int) -> int:
        return channels if self._mixed is None else self._mixed.look_up.table.clear.size

    def _fill_strip(
        self, radiance: NDArray[np.float32], thickness_m: Sequence[Thickness], samples: int, y: slice, x: slice
    ) -> None:
        if self._mixed is None:
            super()._fill_strip(radiance, thickness_m, samples, y, x)
            return
        part = np.empty((self._channels(0), *radiance.shape[1:]), dtype=np.float32)
        self._mixed.look_up.fill(part, thickness_m, samples)
        mix(*self._positions(y, x), *self._mixed.nodes, self._mixed.weights, part, radiance)

    @property
    def _shape(self) -> tuple[int, int]:
        return length(self._rows), length(self._columns)

    def _weights(self, y: slice, x: slice) -> Iterator[Array]:
        across, up = self._positions(y, x)
        of_pixels = self._views.weights_at(across.ravel(), up.ravel())
        yield from of_pixels.reshape(-1, length(y), length(x))

    def _positions(self, y: slice, x: slice) -> tuple[Array, Array]:
        """Return the positions x and y (y, x) of pixels between the nodes, -1 to 1."""
        rows, columns = (
            slice(pixels.start + whole.start, pixels.stop + whole.start)
            for pixels, whole in ((y, self._rows), (x, self._columns))
        )
        return self._views.positions((rows, columns))
