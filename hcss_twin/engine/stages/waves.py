"""Resolved waves in frames: the change of clear points with the slope of the sea."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.kernels import kernel
from hcss_twin.engine.stages.stage import WITH_WAVES, FramePart, PartWindow, Stage
from hcss_twin.engine.tables.radiance_tables import RadianceTables, WaveTables, interval
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.waves import PlannedWaves
from hcss_twin.plan.windows import pixel_sums, points_of

SLOPES = ("sea_slope_x", "sea_slope_y")


class WaveStage(Stage):
    """Adds resolved waves to frames.

    Parameters
    ----------
    tables : RadianceTables or None
        Tables with ``waves``; None if no radiance is needed.
    sea : int
        Number of the class of surface that has the waves.
    """

    def __init__(self, plan: Plan, waves: PlannedWaves, tables: RadianceTables | None, sea: int) -> None:
        self._shapes, self._sea = waves.shapes, sea
        self._tables: WaveTables | None = None if tables is None else tables.waves
        self._nodes: tuple[NDArray[np.float32], ...] = ()
        self._time_s = () if tables is None else tables.time_s
        if self._tables is not None:
            self._nodes = tuple(np.ascontiguousarray(np.moveaxis(change, 2, 0)) for change in self._tables.change)
            # Upwind points toward the origin of the wind; crosswind is clockwise from it. x points east, y north.
            bearing = math.radians(plan.scenario.sea.wind_from)
            turn = np.array([[math.sin(bearing), math.cos(bearing)], [math.cos(bearing), -math.sin(bearing)]])
            last = np.array(self._nodes[0].shape[1:]) - 1
            self._to_nodes = (turn * (0.5 * last / self._tables.reach)[:, None]).astype(np.float32)
        self._samples = plan.samples_per_pixel

    def apply(self, part: FramePart, window: PartWindow) -> None:
        """Add waves to the radiance of the sea's clear points, and fill the slopes of the truth if requested."""
        truth, inside = part.truth, window.inside
        clear = window.clear_points(self._sea)
        if window.observed:
            window.left_out[WITH_WAVES] = pixel_sums(clear, self._samples) > 0
        wanted = [name for name in SLOPES if name in truth]
        if self._tables is None and not wanted:
            return
        rows, columns = (points_of(pixels, self._samples) for pixels in window.window)
        slopes = self._shapes.slopes(part.time_s, rows, columns)
        for name in wanted:
            sums = pixel_sums(slopes[SLOPES.index(name)], self._samples)
            truth[name][inside] = sums / self._samples**2
        if self._tables is None:
            return
        change = self._change(part.time_s)
        _add(part.radiance[:, *inside], change, self._to_nodes, slopes, clear, self._samples)

    def _change(self, time_s: float) -> NDArray[np.float32]:
        """Table (C, N, M) at a time, linear between time nodes."""
        change, nodes = self._nodes, self._time_s
        if len(nodes) == 1:
            return change[0]
        index, weight = interval(nodes, time_s)
        # Not as a difference: small night values would be lost in the rounding of day values.
        return np.float32(1 - weight) * change[index] + np.float32(weight) * change[index + 1]


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


@kernel()
def _add(radiance, change, to_nodes, slopes, clear, samples):  # type: ignore[no-untyped-def]
    """Add to each pixel (C, y, x) the mean change of its clear points, by cubic interpolation in the table.

    ``to_nodes`` (2, 2) turns slopes along x and y into places in the table, counted from its middle.
    """
    channels, rows, columns = radiance.shape
    last_up, last_cross = change.shape[1] - 1, change.shape[2] - 1
    middle_up, middle_cross = np.float32(0.5 * last_up), np.float32(0.5 * last_cross)
    points = slopes.shape[2]
    up, cross = np.empty((4, points), np.float32), np.empty((4, points), np.float32)
    k, m = np.empty(points, np.int32), np.empty(points, np.int32)
    sums = np.empty((channels, columns), np.float32)
    share = np.float32(1 / (samples * samples))
    for y in range(rows):
        sums[:] = 0
        for i in range(y * samples, (y + 1) * samples):
            _cubic(up, k, to_nodes[0, 0] * slopes[0, i] + to_nodes[0, 1] * slopes[1, i] + middle_up, last_up)
            _cubic(cross, m, to_nodes[1, 0] * slopes[0, i] + to_nodes[1, 1] * slopes[1, i] + middle_cross, last_cross)
            for c in range(channels):
                for x in range(columns):
                    for j in range(x * samples, (x + 1) * samples):
                        if clear[i, j]:
                            n, found = m[j], np.float32(0)
                            for a in range(4):
                                line = change[c, k[j] + a]
                                found += up[a, j] * (
                                    (cross[0, j] * line[n] + cross[1, j] * line[n + 1])
                                    + (cross[2, j] * line[n + 2] + cross[3, j] * line[n + 3])
                                )
                            sums[c, x] += found
        for c in range(channels):
            for x in range(columns):
                if sums[c, x] != 0:
                    # A vanishing term can become negative by rounding.
                    radiance[c, y, x] = max(radiance[c, y, x] + sums[c, x] * share, np.float32(0))
