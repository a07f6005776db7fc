"""Thickness of the clouds at the points that the pixels of a frame see.

Each layer is met at the height of its flat side, as in :mod:`hcss_twin.plan.slant_paths`, and one whose tops vary at
all heights (:mod:`hcss_twin.plan.hanging_levels`). Rays that form no grid on the ground meet it between the points of
the scene, so that every layer moves against the sea, and against the others, with the direction of view.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.engine.scene_points import at_rays, interpolated
from hcss_twin.plan.clouds import sums_up
from hcss_twin.plan.displaced_clouds import upright
from hcss_twin.plan.hanging_levels import Met, farthest_points, levels_of, spanning, spread
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.rays import Rays
from hcss_twin.plan.windows import Window, length, points_of
from hcss_twin.providers import CloudGenerator, CloudLayer, Grid

__all__ = ["FrameClouds"]

Thickness = NDArray[np.float32]

WHOLE_POINTS = 2**24
"""Maximum points (4096 x 4096) of a frame computed whole by a generator that could also use a summary."""


class FrameClouds:
    """Thickness of every layer at the points of one instant.

    Parameters
    ----------
    summaries : sequence, optional
        Result of :func:`summaries_of` at the same instant, if already known.
    rays : Rays, optional
        By default those of the plan.
    """

    def __init__(
        self, plan: Plan, time_s: float, summaries: Sequence[Any] | None = None, rays: Rays | None = None
    ) -> None:
        self._plan, self._time_s, self._rays = plan, time_s, rays or plan.rays
        self._clouds = _generators(plan)
        self._summaries = summaries_of(plan, time_s) if summaries is None else summaries

    def thickness_m(self, window: Window) -> list[Thickness]:
        """Thickness of each layer at the points of a window in or around the image.

        Outside the scene, only for generators with ``thickness_around_m``.
        """
        return [self._of_layer(number, window) for number in range(len(self._plan.layers))]

    def of_scene_m(self, window: Window) -> list[Thickness]:
        """Thickness of each layer at the points of a window of the scene's plane, whatever rays see of it."""
        return [self._of_scene(number, window) for number in range(len(self._plan.layers))]

    def tops_m(self, number: int, window: Window) -> Thickness:
        """Altitude of the cloud tops of a layer whose tops vary, at the points of a window in or around the image."""
        if not self._plan.is_grid:
            return self._met(number, window).top_m
        return self._tops_of_scene(number, window)

    def standing(self, number: int, window: Window, edges_m: Array) -> tuple[Thickness, Thickness]:
        """Return the clouds of a layer whose tops vary above the points of a window, whatever lines of sight see.

        Returns
        -------
        thickness_m : ndarray (y, x)
        shares : ndarray (Z, y, x)
            How each is spread over the heights between altitudes (Z + 1,).
        """
        rows, columns = (points_of(pixels, self._plan.scene.samples) for pixels in window)
        own = upright(self._clouds[number][0], self._time_s, rows, columns, self._around[number])
        return own[0], spread(*own, edges_m)

    def as_columns(self, number: int, window: Window, edges_m: Array) -> tuple[Thickness, Thickness]:
        """Return the columns that tables show for what lines of sight cross of such a layer, as :meth:`standing`."""
        thickness = self._of_layer(number, window)
        return thickness, spread(thickness, self.tops_m(number, window), thickness, edges_m)

    def _of_layer(self, number: int, window: Window) -> Thickness:
        """Return the thickness of a layer at the points of a window of the image."""
        layer, (generator, cloudy) = self._plan.layers[number], self._clouds[number]
        if cloudy and not self._plan.is_grid and spanning(layer, generator) is not layer:
            return self._met(number, window).thickness_m
        of_scene = partial(self._of_scene, number)
        height_m = layer.reference_height_m
        return at_rays(self._plan, window, self._time_s, height_m, of_scene, interpolated, self._rays)

    def _met(self, number: int, window: Window) -> Met:
        """Return the clouds of a layer whose tops vary that rays of a window cross, at the nearest points."""
        scene, layer, (generator, _) = self._plan.scene, self._plan.layers[number], self._clouds[number]
        span = spanning(layer, generator)
        levels = levels_of(span, self._moved(span))
        places = [self._places(window, level.middle_m) for level in levels]
        limits_m = layer.thickness_min_m, layer.thickness_max_m
        met = Met(places[0][0].shape, limits_m, generator.cloud_top_range_m)
        rows, columns = (np.concatenate([np.ravel(part) for part in axis]) for axis in zip(*places, strict=True))
        below = scene.around(rows, columns)
        if below is None:
            return met
        thickness, corner = self._of_scene(number, below), scene.corner_of(below)
        depth = self._depth_of_scene(number, below) if hasattr(generator, "cloud_depth_m") else thickness
        clouds = thickness, self._tops_of_scene(number, below), depth
        for level, place in zip(levels, places, strict=True):
            seen = np.isfinite(place[0])
            y, x = (
                np.where(seen, np.rint(np.nan_to_num(part)) - first, -1.0).astype(np.int64)
                for part, first in zip(place, corner, strict=True)
            )
            met.look(*clouds, (y, x), level)
        return met

    def _places(self, window: Window, height_m: float) -> tuple[Array, Array]:
        """Return row and column of the scene, in points, where the rays of a window meet a height."""
        return self._plan.scene.in_points(*self._rays.points_m(window, self._time_s, height_m))

    def _moved(self, span: CloudLayer) -> float:
        """Return how many points the rays of the frame move through a layer, at most, whatever the window."""
        image = self._plan.image
        rows, columns = ((0, size // 2, size - 1) for size in (image.rows, image.columns))
        pixels = [(slice(row, row + 1), slice(column, column + 1)) for row in rows for column in columns]
        moved = [farthest_points(self._places(pixel, span.base_m), self._places(pixel, span.top_m)) for pixel in pixels]
        return max(moved)

    def _tops_of_scene(self, number: int, window: Window) -> Thickness:
        """Return the tops of a layer at the points of a window of the scene's plane."""
        generator, _ = self._clouds[number]
        rows, columns = (points_of(pixels, self._plan.scene.samples) for pixels in window)
        tops: Thickness = generator.cloud_top_m(self._time_s, rows, columns)
        return tops

    def _depth_of_scene(self, number: int, window: Window) -> Thickness:
        """Return the height of the clouds of a layer whose tops vary at the points of a window of the scene's plane."""
        rows, columns = (points_of(pixels, self._plan.scene.samples) for pixels in window)
        depth: Thickness = self._clouds[number][0].cloud_depth_m(self._time_s, rows, columns)
        return depth

    def _of_scene(self, number: int, window: Window) -> Thickness:
        """Return the thickness of a layer at the points of a window of the scene's plane."""
        rows, columns = (points_of(pixels, self._plan.scene.samples) for pixels in window)
        generator, cloudy = self._clouds[number]
        self._plan.scene.require_in_reach(generator, window, self._time_s)
        thickness: Thickness
        if not cloudy:
            thickness = np.zeros((length(rows), length(columns)), dtype=np.float32)
        elif not _is_inside(window, self._plan.grid):
            thickness = generator.thickness_around_m(self._time_s, rows, columns, self._around[number])
        elif (whole := self._whole[number]) is not None:
            thickness = whole[rows, columns]
        elif (summary := self._summaries[number]) is not None:
            thickness = generator.thickness_in_frame_m(self._time_s, rows, columns, summary)
        else:
            thickness = generator.thickness_m(self._time_s, rows, columns)
        return thickness

    @cached_property
    def _whole(self) -> list[Thickness | None]:
        """Frames of the layers that are computed whole."""
        plan, samples = self._plan, self._plan.scene.samples
        points = slice(0, plan.grid.rows * samples), slice(0, plan.grid.columns * samples)
        return [
            generator.thickness_m(self._time_s, *points)
            if cloudy and not generator.declares.tileable and not _is_summed_up(plan, generator)
            else None
            for generator, cloudy in self._clouds
        ]

    @cached_property
    def _around(self) -> list[Any]:
        """Frame summaries that windows around the image need."""
        return [
            generator.frame_summary(self._time_s)
            if cloudy and summary is None and not generator.declares.tileable
            else summary
            for (generator, cloudy), summary in zip(self._clouds, self._summaries, strict=True)
        ]


def summaries_of(plan: Plan, time_s: float) -> list[Any]:
    """Return the frame summary that the windows of each layer need; None if none is needed or there is no cloud.

    This takes two to three times as long as computing the frame, without its memory.
    """
    return [
        generator.frame_summary(time_s) if cloudy and _is_summed_up(plan, generator) else None
        for generator, cloudy in _generators(plan)
    ]


def _generators(plan: Plan) -> tuple[tuple[Any, bool], ...]:
    """Return the generator of each layer, possibly with optional methods, and whether it has cloud."""
    return tuple(zip(plan.assembly.generators, plan.assembly.cloudy_layers, strict=True))


def _is_summed_up(plan: Plan, generator: CloudGenerator) -> bool:
    points = plan.grid.rows * plan.grid.columns * plan.scene.samples**2
    return not generator.declares.tileable and points > WHOLE_POINTS and sums_up(generator)


def _is_inside(window: Window, grid: Grid) -> bool:
    return all(
        pixels.start >= 0 and pixels.stop <= size
        for pixels, size in zip(window, (grid.rows, grid.columns), strict=True)
    )
