"""The waves of a frame: what their slopes add to the radiance of clear sky."""

from __future__ import annotations

import math
from collections.abc import MutableMapping, Sequence
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from hcss_twin.engine.tables.radiance_tables import RadianceTables, WaveTables
from hcss_twin.plan.waves import DrawnWaves
from hcss_twin.plan.windows import Window, pixel_sums, points_of

SLOPES = ("sea_slope_x", "sea_slope_y")
Thickness = NDArray[np.float32]


class WaveStage:
    """Adds the waves to frames.

    Parameters
    ----------
    waves : DrawnWaves
    tables : RadianceTables or None
        With ``waves``; None where no radiance is needed.
    wind_from_deg : float
        Bearing the wind comes from.
    samples : int
        Points along each side of a pixel.
    """

    def __init__(self, waves: DrawnWaves, tables: RadianceTables | None, wind_from_deg: float, samples: int) -> None:
        self._shapes = waves.shapes
        self._tables: WaveTables | None = None if tables is None else tables.waves
        self._time_s = () if tables is None else tables.time_s
        bearing = math.radians(wind_from_deg)
        self._sine, self._cosine = math.sin(bearing), math.cos(bearing)
        self._samples = samples

    def fill(
        self,
        radiance: NDArray[np.float32],
        truth: MutableMapping[str, NDArray[Any]],
        window: Window,
        thickness_m: Sequence[Thickness],
        time_s: float,
        place: Window | None = None,
    ) -> None:
        """Add to a window of the radiance, and fill the slopes of the truth where they are asked for.

        Parameters
        ----------
        radiance : ndarray of float32 (C, y, x)
            Of a part of the image, every band and term; changed where the window lies.
        truth : mapping of str to ndarray (y, x)
            Truth variables of the same part.
        window : (slice, slice)
            Rows and columns, in pixels of the image.
        thickness_m : sequence of ndarray
            Of each cloud layer at the points of the window. Points under any cloud stay as they are.
        time_s : float
            Time of the frame.
        place : (slice, slice), optional
            Where the window lies in the part; by default the part is the whole image.
        """
        place = window if place is None else place
        wanted = [name for name in SLOPES if name in truth]
        if self._tables is None and not wanted:
            return
        rows, columns = (points_of(pixels, self._samples) for pixels in window)
        slopes = self._shapes.slopes(time_s, rows, columns)
        for name in wanted:
            sums = pixel_sums(slopes[SLOPES.index(name)], self._samples)
            truth[name][place] = sums / self._samples**2
        if self._tables is None:
            return
        clear = np.ones(slopes.shape[1:], dtype=np.bool_)
        for layer in thickness_m:
            clear &= layer <= 0
        # Upwind points to where the wind comes from; crosswind clockwise from it. x points east, y north.
        upwind = slopes[0] * self._sine + slopes[1] * self._cosine
        crosswind = slopes[0] * self._cosine - slopes[1] * self._sine
        _add(radiance[:, place[0], place[1]], self._change(time_s), *self._tables.reach,
             upwind, crosswind, clear, self._samples)  # fmt: skip

    def _change(self, time_s: float) -> NDArray[np.float32]:
        """Table at a time: between its nodes a straight line."""
        assert self._tables is not None
        change, nodes = self._tables.change, self._time_s
        if len(nodes) == 1:
            return change[0]
        index = int(np.clip(np.searchsorted(nodes, time_s, side="right") - 1, 0, len(nodes) - 2))
        weight = (time_s - nodes[index]) / (nodes[index + 1] - nodes[index])
        # Not as a difference: night beside day would be lost to the rounding of day.
        return np.float32(1 - weight) * change[index] + np.float32(weight) * change[index + 1]


@njit(cache=True, nogil=True)
def _cubic(weights, place, last):  # type: ignore[no-untyped-def]
    """Set the weights of the cubic through the four nodes around a place (0 to ``last``); return the first node."""
    first = min(max(int(place) - 1, 0), last - 3)
    t = place - first
    a, b, c = t - 1.0, t - 2.0, t - 3.0
    weights[0] = -a * b * c / 6.0
    weights[1] = t * b * c / 2.0
    weights[2] = -t * a * c / 2.0
    weights[3] = t * a * b / 6.0
    return first


@njit(cache=True, nogil=True)
def _add(  # type: ignore[no-untyped-def]
    radiance, change, reach_up, reach_cross, upwind, crosswind, clear, samples
):
    """Add to each pixel (C, y, x) the mean of the changes of its clear points, by cubics through the table."""
    channels, rows, columns = radiance.shape
    last_up, last_cross = change.shape[0] - 1, change.shape[1] - 1
    per_up, per_cross = 0.5 * last_up / reach_up, 0.5 * last_cross / reach_cross
    share = 1.0 / (samples * samples)
    sums, of_up, of_cross = np.empty(channels), np.empty(4), np.empty(4)
    for y in range(rows):
        for x in range(columns):
            found = False
            for i in range(y * samples, (y + 1) * samples):
                for j in range(x * samples, (x + 1) * samples):
                    if not clear[i, j]:
                        continue
                    if not found:
                        found = True
                        sums[:] = 0.0
                    up = min(max((upwind[i, j] + reach_up) * per_up, 0.0), np.float64(last_up))
                    cross = min(max((crosswind[i, j] + reach_cross) * per_cross, 0.0), np.float64(last_cross))
                    k, m = _cubic(of_up, up, last_up), _cubic(of_cross, cross, last_cross)
                    for a in range(4):
                        for b in range(4):
                            weight = of_up[a] * of_cross[b]
                            for c in range(channels):
                                sums[c] += weight * change[k + a, m + b, c]
            if found:
                for c in range(channels):
                    # A term that vanishes may be less than 0 by rounding.
                    radiance[c, y, x] = np.float32(max(radiance[c, y, x] + sums[c] * share, 0.0))
