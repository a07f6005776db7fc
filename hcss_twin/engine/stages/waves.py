"""Resolved waves in frames: the change of clear points with the slope of the sea."""

from __future__ import annotations

import math
from collections.abc import Hashable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.cached_method import cached_method
from hcss_twin.core.kernels import kernel
from hcss_twin.core.lanes import LANES, mix_of_sixteen
from hcss_twin.engine.scene_points import at_rays, nearest
from hcss_twin.engine.stages.stage import FramePart, PartWindow, Stage
from hcss_twin.engine.tables.point_axis import PointAxis
from hcss_twin.engine.tables.radiance_tables import RadianceTables
from hcss_twin.engine.tables.view_states import ViewStates, point_states
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.waves import PlannedWaves, to_wind
from hcss_twin.plan.windows import Window, pixel_sums, points_of
from hcss_twin.providers import WaveShapes

SLOPES = ("sea_slope_x", "sea_slope_y")


class WaveStage(Stage):
    """Adds resolved waves to frames.

    Parameters
    ----------
    tables : sequence of RadianceTables
        At each value of the effects and toward each view, with ``waves``; none if no radiance is needed.
    sea : int
        Number of the class of surface that has the waves.
    effects : sequence of PointAxis
        Effects of points.
    """

    title = "waves as shapes"
    reads = ("truth", "columns", "light between columns", "texture", "ground", "sunlight")
    writes = ("waves",)

    def __init__(
        self,
        plan: Plan,
        waves: PlannedWaves,
        tables: Sequence[RadianceTables],
        sea: int,
        effects: Sequence[PointAxis[Any]] = (),
    ) -> None:
        self._plan, self._shapes, self._sea = plan, waves.shapes, sea
        self._tables, self._effects = tables, effects
        self._samples = plan.samples_per_pixel
        self._moves = not plan.is_grid or bool(effects) or any(len(of_view.time_s) > 1 for of_view in tables)
        self._at = cached_method(self._changes, 1)

    def apply(self, part: FramePart, window: PartWindow) -> None:
        """Add waves to the radiance of the sea's clear points, and fill the slopes of the truth if requested."""
        truth, inside = part.truth, window.inside
        clear = window.clear_points(self._sea)
        wanted = [name for name in SLOPES if name in truth]
        if not self._tables and not wanted:
            return
        slopes = slopes_of(self._plan, self._shapes, part.time_s, window.window)
        for name in wanted:
            sums = pixel_sums(slopes[SLOPES.index(name)], self._samples)
            truth[name][inside] = sums / self._samples**2
        if not self._tables:
            return
        time_s = part.time_s if self._moves else 0.0
        states, by_texture, to_nodes = self._at(time_s, self._plan.rays.frame_key(time_s))
        kept_back = window.kept_back
        if kept_back is None or not self._tables[0].waves.sunlit:
            kept_back = np.zeros((0, 0, 0), np.float32)
        weights = states.weights(window.window)
        by_vapour, _ = self._plan.texture.change_between(by_texture, *window.perturbation)
        radiance, samples = part.radiance[:, *inside], self._samples
        with part.changing_columns(inside):
            _add(radiance, states.values, weights, kept_back, by_vapour, to_nodes, slopes, clear, samples)

    def _changes(self, time_s: float, key: Hashable) -> tuple[ViewStates, Array, NDArray[np.float32]]:
        """Return the states (R, N, M, L) of the tables at a time, seen through the rays of a key.

        L values of a node are the change of each channel, that of its direct sunlight if shadows or vapour weaken it,
        and zeros. The second result (S, R, B) is the relative change of the sunlight in the states of vapour, empty
        without its texture; the third (2, 2) turns slopes along x and y to places in the tables, counted from their
        middle.
        """
        waves = [(tables.waves, tables.time_s) for tables in self._tables]
        sizes = np.max([of_view.change[0].shape[:2] for of_view, _ in waves], axis=0)
        toward_all = np.stack([of_view.at(time_s, times, tuple(sizes.tolist())) for of_view, times in waves])
        shape, texture = toward_all.shape[1:], np.empty((len(waves), 0, 0), np.float32)
        if self._plan.texture.changes_sunlight:
            texture = np.stack([tables.texture.sunlight for tables in self._tables]).astype(np.float32)
        both = np.concatenate((toward_all.reshape(len(waves), -1), texture.reshape(len(waves), -1)), axis=1)
        states = point_states(self._plan, self._effects, both, time_s)
        of_waves, of_texture = np.split(states.values, [math.prod(shape)], axis=1)
        by_texture = np.moveaxis(of_texture.reshape(len(of_texture), *texture.shape[1:]), 1, 0)
        states = replace(states, values=_in_lanes(of_waves.reshape(-1, *shape)))
        to_nodes = to_wind(self._plan.scenario.sea.wind_from) * (0.5 * (sizes - 1) / waves[0][0].reach)[:, None]
        return states, by_texture, to_nodes.astype(np.float32)


def slopes_of(plan: Plan, shapes: WaveShapes, time_s: float, window: Window) -> NDArray[np.float32]:
    """Return the slopes (2, y, x) of the sea at the points of a window of the image, along x and y.

    Between the points of the scene it is the nearest one that rays see: a mean of neighbours would be flatter.
    """

    def of_scene(below: Window) -> NDArray[np.float32]:
        return shapes.slopes(time_s, *(points_of(pixels, plan.scene.samples) for pixels in below))

    return at_rays(plan, window, time_s, 0.0, of_scene, nearest)


def _in_lanes(tables: NDArray[Any]) -> NDArray[np.float32]:
    """Return tables (R, K, C, N, M) as (R, N, M, L): K x C values, and zeros up to whole vectors."""
    states, kinds, channels, *sizes = tables.shape
    values = kinds * channels
    lanes = np.zeros((states, *sizes, -(-values // LANES) * LANES), np.float32)
    lanes[..., :values] = np.moveaxis(tables.reshape(states, values, *sizes), 1, -1)
    return lanes


@kernel(inner=True)
def _cubic(weights, positions, last):  # type: ignore[no-untyped-def]
    """Set the weights (4, N) of the cubic through four nodes around each position (N,), from 0, and it to the first."""
    end, two, six, three = np.float32(last), np.float32(2), np.float32(1 / 6), np.float32(3)
    one, zero, half = np.float32(1), np.float32(0), np.float32(0.5)
    first, second, third, fourth = weights[0], weights[1], weights[2], weights[3]
    for c in range(positions.size):
        at = min(max(positions[c], zero), end)
        node = min(max(np.float32(np.int32(at) - np.int32(1)), zero), np.float32(last - 3))
        t = at - node
        a, b, d = t - one, t - two, t - three
        first[c] = -a * b * d * six
        second[c] = t * b * d * half
        third[c] = -t * a * d * half
        fourth[c] = t * a * b * six
        positions[c] = node


@kernel(inner=True)
def _between(found, table, up, across, first, width):  # type: ignore[no-untyped-def]
    """Set values (N, L) between four nodes along either slope, of which ``first`` (N,) is the first.

    ``up`` and ``across`` (4, N) are their weights; ``table`` has lines of some width, and L values at each node.
    """
    flat, lanes = found.ravel(), np.uint64(found.shape[1])
    up0, up1, up2, up3 = up[0], up[1], up[2], up[3]
    across0, across1, across2, across3 = across[0], across[1], across[2], across[3]
    for c in range(first.size):
        weights = (up0[c], up1[c], up2[c], up3[c], across0[c], across1[c], across2[c], across3[c])
        for lane in range(np.uint64(0), lanes, np.uint64(LANES)):
            to, at = np.uint64(c) * lanes + lane, np.uint64(first[c]) + lane
            mix_of_sixteen(flat, to, table, at, lanes, np.uint64(width), *weights)


@kernel()
def _add(  # type: ignore[no-untyped-def]
    radiance, tables, weights, kept_back, by_vapour, to_nodes, slopes, clear, samples
):
    """Add to each pixel (C, y, x) the mean change of its clear points, by cubic interpolation in the tables.

    ``tables`` (R, N, M, L) of the states hold the change of each channel, and after them that of the direct sunlight in
    each, if clouds keep some of it back. ``weights`` (y or 1, x or 1, R) of the states; ``kept_back`` (B, y, x) at
    points, or empty; ``by_vapour`` (R, B, y or 1, x or 1) the relative change of sunlight that the vapour of each pixel
    causes, or without bands. ``to_nodes`` (2, 2) turns slopes along x and y into places in the table, counted from its
    middle.
    """
    (channels, rows, columns), (states, _, _, lanes) = radiance.shape, tables.shape
    last_up, last_across = tables.shape[1] - 1, tables.shape[2] - 1
    middle_up, middle_across = np.float32(0.5 * last_up), np.float32(0.5 * last_across)
    points, step, width = slopes.shape[2], np.uint32(lanes), np.uint32(lanes * (last_across + 1))
    # The clear points of a row: columns, pixels, places in the tables, values and weights.
    at, pixel, first = np.empty(points, np.uint32), np.empty(points, np.uint32), np.empty(points, np.uint32)
    up_at, across_at = np.empty(points, np.float32), np.empty(points, np.float32)
    up, across = np.empty((4, points), np.float32), np.empty((4, points), np.float32)
    found, weight = np.empty((points, lanes), np.float32), np.empty(points, np.float32)
    sums = np.empty((channels, columns), np.float32)
    share, bands = np.float32(1 / (samples * samples)), by_vapour.shape[1]
    # How much more direct sunlight the pixels of a row have, and how much less their points.
    more, nothing_kept = np.zeros(columns, np.float32), np.zeros(points, np.float32)
    x_up, y_up, x_across, y_across = to_nodes[0, 0], to_nodes[0, 1], to_nodes[1, 0], to_nodes[1, 1]
    for y in range(rows):
        of_row = weights[min(y, weights.shape[0] - 1)]
        last_weight = np.uint32(of_row.shape[0] - 1)
        sums[:] = 0
        for i in range(y * samples, (y + 1) * samples):
            count = 0
            for j in range(points):
                at[count] = j
                count += clear[i, j]
            x_slopes, y_slopes = slopes[0, i], slopes[1, i]
            for c in range(count):
                x_slope, y_slope = x_slopes[at[c]], y_slopes[at[c]]
                up_at[c] = x_up * x_slope + y_up * y_slope + middle_up
                across_at[c] = x_across * x_slope + y_across * y_slope + middle_across
                pixel[c] = at[c] // np.uint32(samples)
            _cubic(up, up_at[:count], last_up)
            _cubic(across, across_at[:count], last_across)
            for c in range(count):
                first[c] = np.uint32(np.int32(up_at[c])) * width + np.uint32(np.int32(across_at[c])) * step
            for r in range(states):
                _between(found, tables[r].ravel(), up, across, first[:count], width)
                for c in range(count):
                    weight[c] = np.float32(of_row[min(pixel[c], last_weight), r])
                for channel in range(channels):
                    total, kept = sums[channel], nothing_kept
                    if kept_back.shape[0] > 0:
                        kept = kept_back[channel % kept_back.shape[0], i]
                    if bands > 0:
                        of_vapour = by_vapour[r, channel % bands, min(y, by_vapour.shape[2] - 1)]
                        for x in range(columns):
                            more[x] = np.float32(of_vapour[min(x, of_vapour.size - 1)])
                        for c in range(count):
                            lit = more[pixel[c]] * (np.float32(1) - kept[at[c]]) - kept[at[c]]
                            total[pixel[c]] += weight[c] * (found[c, channel] + lit * found[c, channels + channel])
                    elif kept_back.shape[0] > 0:
                        for c in range(count):
                            change = found[c, channel] - kept[at[c]] * found[c, channels + channel]
                            total[pixel[c]] += weight[c] * change
                    else:
                        for c in range(count):
                            total[pixel[c]] += weight[c] * found[c, channel]
        for channel in range(channels):
            total, line = sums[channel], radiance[channel, y]
            for x in range(columns):
                if total[x] != 0:
                    # A vanishing term can become negative by rounding.
                    line[x] = max(line[x] + total[x] * share, np.float32(0))
