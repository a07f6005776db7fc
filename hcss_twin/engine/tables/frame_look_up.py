"""Look-up in the tables of a scene at one instant, for whatever differs from pixel to pixel or point to point."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.engine.tables.look_up import LookUp, Thickness
from hcss_twin.engine.tables.over_views import GridViews, views_of_frame
from hcss_twin.engine.tables.point_axis import FrameAxis, Group, PointAxis, both
from hcss_twin.engine.tables.radiance_tables import DenseTable, RadianceTables, stacked_tables
from hcss_twin.engine.tables.tensor_train import LOST, MANY_STATES
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.windows import Window, length, pixel_sums, points_of

VALUES_AT_ONCE = 2**21
"""Maximum pixels, or points, times states that are looked up together; 16 MB of weights."""


class FrameLookUps:
    """Look-ups of the frames of a scene; request them in the order of time: the tables of two nodes are kept.

    Parameters
    ----------
    axes : sequence of PointAxis
        Those of the points of the plan.
    """

    def __init__(self, plan: Plan, tables: RadianceTables, axes: Sequence[PointAxis[Any]]) -> None:
        self._plan, self._axes = plan, axes
        self._leaves = tables.leaves

    def at(self, time_s: float) -> FrameLookUp:
        """Return the look-up at an instant."""
        tables, axes = [leaf.at(time_s) for leaf in self._leaves], [axis.in_frame(time_s) for axis in self._axes]
        sizes = [len(axis.nodes) for axis in self._axes]
        if self._plan.views.varies:
            views = len(self._plan.views.places)
            together = [stacked_tables(tables[first : first + views]) for first in range(0, len(tables), views)]
            of_frame, weights = views_of_frame(self._plan, time_s, together[0])
            if weights is not None:
                views, together = len(weights), [table.mixed(weights) for table in together]
                tables = [table.in_state(number) for table in together for number in range(views)]
            axes, sizes = [*axes, of_frame], [*sizes, views]
        return FrameLookUp(self._plan, axes, sizes, tables)


class FrameLookUp:
    """Look-up at one instant with the state of each point.

    Parameters
    ----------
    axes : sequence of FrameAxis
    sizes : sequence of int
        Number of nodes of each axis.
    tables : sequence of DenseTable
        At all combinations of nodes, those of the last axis one after another.
    """

    def __init__(
        self, plan: Plan, axes: Sequence[FrameAxis], sizes: Sequence[int], tables: Sequence[DenseTable]
    ) -> None:
        self._bands, self._axes, self._tables = len(plan.bands), axes, tables
        self._number = np.arange(len(tables)).reshape(tuple(sizes))
        self._within_pixels = any(axis.within_pixels for axis in axes)
        self._extent: Window = slice(0, plan.image.rows), slice(0, plan.image.columns)
        self._points = 0
        self._known = dict[bytes, tuple[LookUp, Array | None]]()

    def of_part(self, extent: Window) -> FrameLookUp:
        """Return the look-up of some rows and columns, counted from the first of this one."""
        part = copy(self)
        part._extent = self._moved(extent)
        return part

    def of_points(self, extent: Window, samples: int) -> FrameLookUp:
        """Return the look-up of the points of some rows and columns, as if each were a pixel."""
        part = self.of_part(extent)
        part._points = samples
        return part

    def fill(
        self,
        radiance: NDArray[np.float32],
        thickness_m: Sequence[Thickness],
        samples: int = 1,
        corner: tuple[int, int] = (0, 0),
    ) -> None:
        """Write the radiance of a window of the image like :meth:`LookUp.fill`; without layers, of the whole image."""
        if not self._axes:
            self._together(self._number.ravel())[0].fill(radiance, thickness_m, samples, corner)
            return
        rows, columns = (length(pixels) for pixels in self._extent)
        per_pixel = self._points or samples
        if thickness_m:
            rows, columns = (size // per_pixel for size in thickness_m[0].shape)
        points = per_pixel if self._within_pixels or self._points else 1
        step = max(1, VALUES_AT_ONCE // (self._number.size * columns * points**2))
        for first in range(0, rows, step):
            strip = slice(first, min(first + step, rows))
            of_strip = [thickness[points_of(strip, per_pixel)] for thickness in thickness_m]
            window = self._moved(
                (slice(corner[0] + strip.start, corner[0] + strip.stop), slice(corner[1], corner[1] + columns))
            )
            place = (strip.start * (self._points or 1) + corner[0], corner[1])
            if points == 1 and len(self._axes) == 1 and isinstance(self._axes[0], GridViews):
                look_up, weights = self._of_grid(self._axes[0], window)
                look_up.fill(radiance, of_strip, samples, place, weights)
                continue
            groups = self._groups(window, points)
            if points == 1 and len(groups) == 1:  # all pixels, which may have several points
                look_up, weights = self._weighted(groups[0], radiance.shape[0])
                shape = strip.stop - strip.start, columns
                look_up.fill(radiance, of_strip, samples, place, weights.reshape(*shape, *weights.shape[1:]))
                continue
            values = self._of_points(radiance.shape[0], groups, of_strip, window, points)
            for channel, of_channel in zip(radiance, values, strict=True):
                shown = of_channel if self._points or samples == 1 else pixel_sums(of_channel, samples) / samples**2
                channel[place[0] : place[0] + shown.shape[0], place[1] : place[1] + shown.shape[1]] = shown

    def _of_grid(self, axis: GridViews, window: Window) -> tuple[LookUp, Array]:
        """Return the look-up of the views of a grid, and the weights (y, x, 1, R) of its states: products of two."""
        look_up, fewer = self._together(self._number.ravel())
        up, across = axis.weights(window)
        shares = np.eye(self._number.size) if fewer is None else fewer
        of_columns = np.tensordot(across, shares.reshape(up.shape[1], across.shape[1], -1), (1, 1))
        weights: Array = np.tensordot(up, of_columns, (1, 1))[:, :, None]
        return look_up, weights

    def _of_points(
        self, channels: int, groups: Sequence[Group], thickness_m: Sequence[Thickness], window: Window, points: int
    ) -> NDArray[np.float32]:
        """Return the radiance (C, y, x) of the points of a window."""
        shape = tuple(length(pixels) * points for pixels in window)
        values = np.empty((channels, shape[0] * shape[1]), dtype=np.float32)
        for group in groups:
            some = slice(None) if group.points is None else group.points
            look_up, weights = self._weighted(group, channels)
            result = np.empty((channels, 1, len(weights)), dtype=np.float32)
            inside = [np.ascontiguousarray(thickness.ravel()[some])[None] for thickness in thickness_m]
            if weights.shape[2] > 1:
                look_up.fill(result, inside, weights=weights[None])
            else:
                look_up.fill(result, inside)
            values[:, some] = result[:, 0]
        return values.reshape(channels, *shape)

    def _groups(self, window: Window, points: int) -> list[Group]:
        """Return the points of a window by the nodes of all axes; of one point for each pixel, its pixels."""
        size = tuple(length(pixels) for pixels in window)
        row, column = np.divmod(np.arange(size[0] * size[1] * points**2), size[1] * points)
        pixel = row // points * size[1] + column // points
        found = [Group(None, [0], np.ones((1, 1, 1)))]
        for axis, nodes in zip(self._axes, self._number.shape, strict=True):
            finer = []
            for before in found:
                for group in axis.groups(window, points):
                    if not axis.within_pixels and points > 1:
                        group = Group(None, group.nodes, group.weights[:, :, pixel])
                    finer.append(both(before, group, nodes))
            found = [group for group in finer if group.points is None or group.points.size]
        return found

    def _weighted(self, group: Group, channels: int) -> tuple[LookUp, Array]:
        """Return the look-up of the nodes of a group, and the weights (N, C or 1, R) of its states at the points."""
        look_up, fewer = self._together(np.asarray(group.nodes))
        weights = group.weights if fewer is None else np.tensordot(fewer, group.weights, ((0,), (0,)))
        if weights.shape[1] > 1:
            weights = np.tile(weights, (1, channels // weights.shape[1], 1))
        return look_up, np.ascontiguousarray(weights.transpose(2, 1, 0))

    def _together(self, nodes: NDArray[np.intp]) -> tuple[LookUp, Array | None]:
        """Return the look-up of some nodes, and their weights (S, R) if fewer states do."""
        key = nodes.tobytes()
        if key not in self._known:
            table, fewer = stacked_tables([self._tables[node] for node in nodes.tolist()]), None
            if nodes.size > MANY_STATES:
                table, fewer = table.fewest(LOST)
            self._known[key] = LookUp(table), fewer
        return self._known[key]

    def _moved(self, window: Window) -> Window:
        """Return a window of this part as one of the image."""
        rows, columns = (
            slice(pixels.start + whole.start, pixels.stop + whole.start)
            for pixels, whole in zip(window, self._extent, strict=True)
        )
        return rows, columns
