"""Resolved waves in frames: the change of clear points with the slope of the sea."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.cached_method import cached_method
from hcss_twin.core.kernels import kernel
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
        states, to_nodes = self._at(time_s, self._plan.rays.frame_key(time_s))
        kept_back = window.kept_back
        if kept_back is None or states.values.shape[1] == 1:
            kept_back = np.zeros((0, 0, 0), np.float32)
        weights = states.weights(window.window)
        radiance, samples = part.radiance[:, *inside], self._samples
        with part.changing_columns(inside):
            _add(radiance, states.values, weights, kept_back, to_nodes, slopes, clear, samples)

    def _changes(self, time_s: float, key: Hashable) -> tuple[ViewStates, NDArray[np.float32]]:
        """Return the states (R, 1 or 2, C, N, M) of the tables at a time, seen through the rays of a key.

        The second (2, 2) turns slopes along x and y to places in the tables, counted from their middle.
        """
        waves = [(tables.waves, tables.time_s) for tables in self._tables]
        sizes = np.max([of_view.change[0].shape[:2] for of_view, _ in waves], axis=0)
        toward_all = np.stack([of_view.at(time_s, times, tuple(sizes.tolist())) for of_view, times in waves])
        states = point_states(self._plan, self._effects, toward_all, time_s)
        states = replace(states, values=np.ascontiguousarray(states.values, np.float32))
        to_nodes = to_wind(self._plan.scenario.sea.wind_from) * (0.5 * (sizes - 1) / waves[0][0].reach)[:, None]
        return states, to_nodes.astype(np.float32)


def slopes_of(plan: Plan, shapes: WaveShapes, time_s: float, window: Window) -> NDArray[np.float32]:
    """Return the slopes (2, y, x) of the sea at the points of a window of the image, along x and y.

    Between the points of the scene it is the nearest one that rays see: a mean of neighbours would be flatter.
    """

    def of_scene(below: Window) -> NDArray[np.float32]:
        return shapes.slopes(time_s, *(points_of(pixels, plan.scene.samples) for pixels in below))

    return at_rays(plan, window, time_s, 0.0, of_scene, nearest)


@kernel(inner=True)
def _cubic(weights, positions, last):  # type: ignore[no-untyped-def]
    """Set the weights (N, 4) of the cubic through four nodes around each position (N,), from 0, and it to the first."""
    end, two, six = np.float32(last), np.float32(2), np.float32(1 / 6)
    for c in range(positions.size):
        at = min(max(positions[c], np.float32(0)), end)
        first = min(max(np.float32(np.int32(at) - np.int32(1)), np.float32(0)), np.float32(last - 3))
        t = at - first
        a, b, d = t - np.float32(1), t - two, t - np.float32(3)
        weights[c, 0] = -a * b * d * six
        weights[c, 1] = t * b * d * np.float32(0.5)
        weights[c, 2] = -t * a * d * np.float32(0.5)
        weights[c, 3] = t * a * b * six
        positions[c] = first


@kernel(inner=True)
def _between(found, table, up, cross, first, width):  # type: ignore[no-untyped-def]
    """Set values (K,) between four nodes along either slope, of which ``first`` (N,) is the first.

    ``table`` has lines of some width.
    """
    for c in range(found.size):
        near, second, third, far = np.float32(0), np.float32(0), np.float32(0), np.float32(0)
        at = first[c]
        for a in range(4):  # the four columns at once
            weight = up[c, a]
            near += weight * table[at]
            second += weight * table[at + np.uint64(1)]
            third += weight * table[at + np.uint64(2)]
            far += weight * table[at + np.uint64(3)]
            at += width
        found[c] = (cross[c, 0] * near + cross[c, 1] * second) + (cross[c, 2] * third + cross[c, 3] * far)


@kernel()
def _add(  # type: ignore[no-untyped-def]
    radiance, tables, weights, kept_back, to_nodes, slopes, clear, samples
):
    """Add to each pixel (C, y, x) the mean change of its clear points, by cubic interpolation in the tables.

    ``weights`` (y or 1, x or 1, R) of the states in ``tables``; ``kept_back`` (B, y, x) at points, or empty.
    ``to_nodes`` (2, 2) turns slopes along x and y into places in the table, counted from its middle.
    """
    channels, rows, columns = radiance.shape
    last_up, last_cross = tables.shape[3] - 1, tables.shape[4] - 1
    middle_up, middle_cross = np.float32(0.5 * last_up), np.float32(0.5 * last_cross)
    points, bands, width = slopes.shape[2], max(kept_back.shape[0], 1), np.uint64(last_cross + 1)
    # The clear points of a row, first those in shadow: columns, pixels, places in the tables, values and weights.
    at, pixel, first = np.empty(points, np.uint64), np.empty(points, np.uint64), np.empty(points, np.uint64)
    along, across = np.empty(points, np.float32), np.empty(points, np.float32)
    up, cross = np.empty((points, 4), np.float32), np.empty((points, 4), np.float32)
    found, lost = np.empty(points, np.float32), np.empty(points, np.float32)
    dark, pixels = np.zeros(points, np.bool_), (np.arange(points) // samples).astype(np.uint64)
    sums = np.empty((channels, columns), np.float32)
    states, kinds = tables.shape[:2]
    share = np.float32(1 / (samples * samples))
    for y in range(rows):
        of_row = weights[min(y, weights.shape[0] - 1)]
        sums[:] = 0
        for i in range(y * samples, (y + 1) * samples):
            for b in range(kept_back.shape[0]):
                for j in range(points):
                    dark[j] = kept_back[b, i, j] > 0 or (b > 0 and dark[j])
            count = 0
            for j in range(points):
                at[count] = j
                count += clear[i, j] and dark[j]
            in_shadow = count
            for j in range(points):
                at[count] = j
                count += clear[i, j] and not dark[j]
            for c in range(count):
                x_slope, y_slope = slopes[0, i, at[c]], slopes[1, i, at[c]]
                along[c] = to_nodes[0, 0] * x_slope + to_nodes[0, 1] * y_slope + middle_up
                across[c] = to_nodes[1, 0] * x_slope + to_nodes[1, 1] * y_slope + middle_cross
                pixel[c] = pixels[at[c]]
            _cubic(up[:count], along[:count], last_up)
            _cubic(cross[:count], across[:count], last_cross)
            for c in range(count):
                first[c] = np.uint64(along[c]) * width + np.uint64(across[c])
            for channel in range(channels):
                for r in range(states):
                    _between(found[:count], tables[r, 0, channel].ravel(), up, cross, first, width)
                    if in_shadow:
                        sunlit, kept = tables[r, kinds - 1, channel].ravel(), kept_back[channel % bands, i]
                        _between(lost[:in_shadow], sunlit, up, cross, first, width)
                        for c in range(in_shadow):
                            found[c] -= kept[at[c]] * lost[c]
                    for c in range(count):
                        weight = np.float32(of_row[min(pixel[c], np.uint64(of_row.shape[0] - 1)), r])
                        sums[channel, pixel[c]] += weight * found[c]
        for channel in range(channels):
            for x in range(columns):
                if sums[channel, x] != 0:
                    # A vanishing term can become negative by rounding.
                    radiance[channel, y, x] = max(radiance[channel, y, x] + sums[channel, x] * share, np.float32(0))
