"""Shadows of clouds on the clear sea: a stage of each frame, after the look-up."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from hcss_twin.cube.variables import SHADOW_MASK
from hcss_twin.providers import Sun
from hcss_twin.scene.footprint import Window, points_of
from hcss_twin.scene.plan import Plan
from hcss_twin.scene.slant.sun_paths import SunPaths, sun_paths
from hcss_twin.scene.tables.radiance_tables import RadianceTables, ShadowTables

Array = NDArray[np.float64]
Thickness = NDArray[np.float32]


class Shadows:
    """Shadows of a scene, instant by instant.

    Parameters
    ----------
    plan : Plan
    tables : RadianceTables or None
        None where no requested variable needs radiance; the mask can be had without.
    """

    def __init__(self, plan: Plan, tables: RadianceTables | None) -> None:
        self._plan = plan
        self._tables = None if tables is None else tables.shadows
        self._point_m = plan.grid.pixel_size_m / plan.samples_per_pixel

    def at(self, time_s: float) -> InstantShadows | None:
        """Return the shadows at one instant; None where there can be none."""
        plan = self._plan
        if not (plan.slant.shadows and plan.layers and plan.sun_matters):
            return None
        sun = plan.sun_track.at(time_s)
        if not sun.is_up:
            return None
        paths: list[SunPaths | None] = []
        for layer in plan.layers:
            met = sun_paths(layer, sun, self._point_m)
            # Where sight and sunlight meet the same point, what is clear to one is clear to the other.
            paths.append(None if met.stay_at(plan.slant.of_view(layer, self._point_m)) else met)
        return InstantShadows(plan, self._tables, time_s, sun, paths) if any(paths) else None


class InstantShadows:
    """Shadows at one instant.

    Parameters
    ----------
    paths : sequence of SunPaths or None
        Through each layer; None where it takes nothing from points that it leaves clear.
    """

    def __init__(
        self,
        plan: Plan,
        tables: ShadowTables | None,
        time_s: float,
        sun: Sun,
        paths: Sequence[SunPaths | None],
    ) -> None:
        self._plan = plan
        self._time_s = time_s
        self._paths = paths
        layers = len(plan.layers)
        if tables is None:
            self._loss, self._depth = np.zeros((0, 0)), np.zeros((layers, 2, 0))
            self._part = np.zeros(layers)
        else:
            self._loss, self._depth = tables.at(time_s)
            self._part = 1.0 / (math.cos(math.radians(sun.zenith_deg)) * tables.longest_m)

    def cast(
        self,
        window: Window,
        thickness_m: Sequence[Thickness],
        radiance: NDArray[np.float32],
        truth: dict[str, NDArray[Any]],
        place: Window | None = None,
    ) -> NDArray[np.bool_]:
        """Take from a window of the image the sunlight that clouds keep from its clear points.

        Parameters
        ----------
        window : (slice, slice)
            Rows and columns, in pixels of the image.
        thickness_m : sequence of ndarray (window rows x samples, window columns x samples)
            Of each layer, as it is seen from the points.
        radiance : ndarray of float32 (C, y, x)
            Of a part of the image; C may be 0.
        truth : dict of str to ndarray
            Truth variables of the same part, among which the mask may be.
        place : (slice, slice), optional
            Where the window lies in the part; by default the part is the whole image.

        Returns
        -------
        ndarray of bool (window rows, window columns)
            Pixels of which some part is in shadow.
        """
        place = window if place is None else place
        mask = truth.get(SHADOW_MASK)
        if mask is None:
            mask = np.zeros(radiance.shape[1:], dtype=np.uint8)
        _cast(
            radiance,
            mask,
            place[0].start,
            place[1].start,
            self._plan.samples_per_pixel,
            ~np.any([each > 0 for each in thickness_m], axis=0),
            self._in_cloud(window),
            self._part,
            self._depth,
            self._loss,
        )
        shaded: NDArray[np.bool_] = mask[place] > 0
        return shaded

    def _in_cloud(self, window: Window) -> Thickness:
        """Height in each layer's cloud of the sun's paths to the points of a window, (L, y, x)."""
        plan = self._plan
        rows, columns = (points_of(pixels, plan.samples_per_pixel) for pixels in window)
        heights = np.zeros(
            (len(plan.layers), rows.stop - rows.start, columns.stop - columns.start), dtype=np.float32
        )
        for layer, generator, paths in zip(heights, plan.generators, self._paths, strict=True):
            if paths is not None:
                layer[:] = paths.heights_m(generator, self._time_s, rows, columns)
        return heights


@njit(cache=True, nogil=True)
def _cast(  # type: ignore[no-untyped-def]
    radiance, mask, row, column, samples, clear, in_cloud, part, depth, loss
):
    """Weaken clear points; ``part`` (L,) is that of the longest path, per metre of height in cloud."""
    layers, intervals, bands = depth.shape[0], depth.shape[1] - 1, depth.shape[2]
    share = 1.0 / (samples * samples)
    kept_back, path = np.empty(bands), np.empty(bands)
    for y in range(clear.shape[0] // samples):
        for x in range(clear.shape[1] // samples):
            shaded = False
            kept_back[:] = 0.0
            for i in range(y * samples, (y + 1) * samples):
                for j in range(x * samples, (x + 1) * samples):
                    if not clear[i, j]:
                        continue
                    met = False
                    for n in range(layers):
                        height = np.float64(in_cloud[n, i, j])
                        if height <= 0.0:
                            continue
                        if not met:
                            met = True
                            path[:] = 0.0
                        # Nodes are even in the square root; paths that rounding puts beyond the last go on along
                        # the last line.
                        root = math.sqrt(height * part[n]) * intervals
                        k = min(int(root), intervals - 1)
                        inside = (root * root - k * k) / (2.0 * k + 1.0)
                        for b in range(bands):
                            low = depth[n, k, b]
                            path[b] += low + inside * (depth[n, k + 1, b] - low)
                    if met:
                        shaded = True
                        for b in range(bands):
                            kept_back[b] -= math.expm1(-path[b])
            if not shaded:
                continue
            mask[row + y, column + x] = 1
            for q in range(loss.shape[0]):
                for b in range(bands):
                    if loss[q, b] != 0.0:
                        left = np.float64(radiance[q * bands + b, row + y, column + x])
                        left -= loss[q, b] * kept_back[b] * share
                        # Where nothing is left, single precision can leave less.
                        radiance[q * bands + b, row + y, column + x] = np.float32(max(left, 0.0))
