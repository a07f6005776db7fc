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


@kernel()
def _cubic(weights, first, position, last):  # type: ignore[no-untyped-def]
    """Set the first node (X,) and the weights (4, X) of the cubic through four nodes around each position, from 0."""
    end, two, six = np.float32(last), np.float32(2), np.float32(1 / 6)
    for x in range(position.size):
        at = min(max(position[x], np.float32(0)), end)
        first[x] = min(max(np.int32(at) - np.int32(1), np.int32(0)), np.int32(last - 3))
        t = at - np.float32(first[x])
        a, b, c = t - np.float32(1), t - two, t - np.float32(3)
        weights[0, x] = -a * b * c * six
        weights[1, x] = t * b * c * np.float32(0.5)
        weights[2, x] = -t * a * c * np.float32(0.5)
        weights[3, x] = t * a * b * six


@kernel(inner=True)
def _between(table, up, cross, j, k, n):  # type: ignore[no-untyped-def]
    """Return a table (N, M) at point j, between four nodes along either slope."""
    found = np.float32(0)
    for a in range(4):
        line = table[k + a]
        found += up[a, j] * (
            (cross[0, j] * line[n] + cross[1, j] * line[n + 1])
            + (cross[2, j] * line[n + 2] + cross[3, j] * line[n + 3])
        )
    return found


@kernel()
def _add(  # type: ignore[no-untyped-def]
    radiance, tables, weights, kept_back, to_nodes, slopes, clear, samples
):
    """Add to each pixel (C, y, x) the mean change of its clear points, by cubic interpolation in the tables.

    ``weights`` (y, x, R) of the states in ``tables``; ``kept_back`` (B, y, x) at points, or empty.
    ``to_nodes`` (2, 2) turns slopes along x and y into places in the table, counted from its middle.
    """
    channels, rows, columns = radiance.shape
    last_up, last_cross = tables.shape[3] - 1, tables.shape[4] - 1
    middle_up, middle_cross = np.float32(0.5 * last_up), np.float32(0.5 * last_cross)
    points, bands = slopes.shape[2], max(kept_back.shape[0], 1)
    up, cross = np.empty((4, points), np.float32), np.empty((4, points), np.float32)
    k, m = np.empty(points, np.int32), np.empty(points, np.int32)
    sums = np.empty((channels, columns), np.float32)
    states, kinds = tables.shape[:2]
    of_row = np.empty((states, columns), np.float32)
    share = np.float32(1 / (samples * samples))
    shaded, nothing = kept_back.shape[0] > 0, np.empty(0, np.float32)
    for y in range(rows):
        sums[:] = 0
        of_row[:] = weights[y].T
        for i in range(y * samples, (y + 1) * samples):
            _cubic(up, k, to_nodes[0, 0] * slopes[0, i] + to_nodes[0, 1] * slopes[1, i] + middle_up, last_up)
            _cubic(cross, m, to_nodes[1, 0] * slopes[0, i] + to_nodes[1, 1] * slopes[1, i] + middle_cross, last_cross)
            for c in range(channels):
                for r in range(states):
                    whole, sunlit = tables[r, 0, c], tables[r, kinds - 1, c]
                    kept = kept_back[c % bands, i] if shaded else nothing
                    for x in range(columns):
                        weight = of_row[r, x]
                        for j in range(x * samples, (x + 1) * samples):
                            if clear[i, j]:
                                found = _between(whole, up, cross, j, k[j], m[j])
                                if shaded and kept[j] > 0:
                                    found -= kept[j] * _between(sunlit, up, cross, j, k[j], m[j])
                                sums[c, x] += weight * found
        for c in range(channels):
            for x in range(columns):
                if sums[c, x] != 0:
                    # A vanishing term can become negative by rounding.
                    radiance[c, y, x] = max(radiance[c, y, x] + sums[c, x] * share, np.float32(0))
