"""What lines of sight cross of clouds whose tops vary, by tops or sides of columns.

A straight line passes the heights of such a layer from its highest top down to its lowest base. They are divided into
slices of equal height, in each of which the line moves by at most half a point along either axis. Its point sees a
column that is as thick as the sum of what the line crosses of the columns in all slices, at the mean height of that: a
column that is crossed from top to base is seen as it is, the side of a tower is as warm as it is low, and edges are
thin. Clouds of generators with ``cloud_depth_m`` are spread over another height than their thickness.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.kernels import kernel
from hcss_twin.providers import CloudGenerator, CloudLayer

Cloud = NDArray[np.float32]

MOVED_POINTS = 0.5
"""By which lines move in a slice."""


def spanning(layer: CloudLayer, generator: CloudGenerator) -> CloudLayer:
    """Return a layer from the lowest base to the highest top of its clouds; itself if its tops do not vary."""
    tops_m = getattr(generator, "cloud_top_range_m", None)
    if tops_m is None:
        return layer
    low, high = tops_m
    lowest = layer.hanging_from(float(low)).base_m
    return replace(layer, base_m=lowest, top_m=float(high), anchor="top")


def spread(thickness_m: Cloud, top_m: Cloud, depth_m: Cloud, edges_m: Array) -> Cloud:
    """Return the shares (Z, y, x) of clouds (y, x) between altitudes (Z + 1,); 0 where there is none."""
    edges, shares = (
        edges_m.astype(np.float32)[:, None, None],
        np.empty((edges_m.size - 1, *thickness_m.shape), np.float32),
    )
    for level, (low, high) in enumerate(pairwise(edges)):
        shares[level] = np.clip(np.minimum(top_m, high) - np.maximum(top_m - depth_m, low), 0.0, None)
    total = shares.sum(axis=0)
    cloudy = (thickness_m > 0.0) & (total > 0.0)
    shares *= np.where(cloudy, np.float32(1.0) / np.where(cloudy, total, np.float32(1.0)), np.float32(0.0))
    return shares


@dataclass(frozen=True)
class Level:
    """One slice of height: its limits, and its middle, at which paths are followed."""

    low_m: float
    high_m: float

    @property
    def middle_m(self) -> float:
        """Altitude between the limits."""
        return 0.5 * (self.low_m + self.high_m)


def levels_of(span: CloudLayer, moved_points: float) -> list[Level]:
    """Return the slices of a layer from the highest down, through all of which a path moves by so many points."""
    count = max(1, math.ceil(moved_points / MOVED_POINTS))
    edges = np.linspace(span.top_m, span.base_m, count + 1).tolist()
    return [Level(low, high) for high, low in pairwise(edges)]


class Met:
    """Clouds that the lines of sight of some points have crossed so far.

    Parameters
    ----------
    shape : (int, int)
    thickness_range_m : (float, float)
        Thickness of the thinnest and of the thickest cloud of the layer.
    top_range_m : (float, float)
        Of the generator: points that cross no cloud have the lowest top.
    """

    def __init__(
        self, shape: tuple[int, ...], thickness_range_m: tuple[float, float], top_range_m: tuple[float, float]
    ) -> None:
        self._crossed, self._height, self._moment = (np.zeros(shape) for _ in range(3))
        self._range_m, self._top_range_m = thickness_range_m, top_range_m

    def look(
        self,
        thickness_m: Cloud,
        top_m: Cloud,
        depth_m: Cloud,
        at: tuple[NDArray[np.int64], NDArray[np.int64]],
        of: Level,
    ) -> None:
        """Look at a slice of clouds (Y, X) of a part of the plane, at its points (y, x) of these rows and columns."""
        row, column = (np.broadcast_to(part, self._crossed.shape) for part in at)
        seen = self._crossed, self._height, self._moment
        _look(*seen, thickness_m, top_m, depth_m, row, column, of.low_m, of.high_m)

    @property
    def thickness_m(self) -> Cloud:
        """Thickness of what each point crosses (y, x), limited as that of clouds; 0 where it is clear."""
        least, most = self._range_m
        seen = np.where(self._crossed < 0.5 * least, 0.0, np.clip(self._crossed, least, most))
        # dense clouds are thicker than high, and no column of theirs reaches below the sea
        return np.minimum(seen.astype(np.float32), self.top_m)

    @property
    def top_m(self) -> Cloud:
        """Top (y, x) of the column as high as what the point crosses, whose middle is the mean height of that."""
        middle = np.divide(self._moment, self._height, out=np.zeros_like(self._moment), where=self._height > 0.0)
        low, high = (np.float32(end) for end in self._top_range_m)
        least, most = self._range_m
        height = np.where(self._crossed < 0.5 * least, 0.0, np.clip(self._height, least, most)).astype(np.float32)
        top: Cloud = np.clip(middle.astype(np.float32) + np.float32(0.5) * height, low, high)
        return top


@kernel()
def _look(crossed, height, moment, thickness, top, depth, row, column, low, high):  # type: ignore[no-untyped-def]
    """Add what lines of sight cross in a slice to its thickness, height and moment; those of negative rows: nothing."""
    for y in range(crossed.shape[0]):
        for x in range(crossed.shape[1]):
            i, j = row[y, x], column[y, x]
            if i < 0:
                continue
            cloud = np.float64(thickness[i, j])
            if cloud > 0.0:
                highest = np.float64(top[i, j])
                deep = np.float64(depth[i, j])
                upper, lower = min(highest, high), max(highest - deep, low)
                if upper > lower:
                    crossed[y, x] += (upper - lower) * (cloud / deep)
                    height[y, x] += upper - lower
                    moment[y, x] += 0.5 * (upper + lower) * (upper - lower)


@kernel()
def add_hanging(heights, thickness, top, depth, shifts, lowest, slice_m):  # type: ignore[no-untyped-def]
    """Add to ``heights`` (y, x) what paths cross of hanging clouds (Y, X), displaced (S, 2) in slices from the lowest.

    Each column gives to the paths that cross it: most of a sky of heaps is clear.
    """
    for i in range(thickness.shape[0]):
        for j in range(thickness.shape[1]):
            cloud = np.float64(thickness[i, j])
            if cloud > 0.0:
                highest, deep = np.float64(top[i, j]), np.float64(depth[i, j])
                low, dense = highest - deep, cloud / deep
                first = max(int((low - lowest) / slice_m) - 1, 0)
                for s in range(first, shifts.shape[0]):
                    under = lowest + s * slice_m
                    if under >= highest:
                        break
                    y, x = i - shifts[s, 0], j - shifts[s, 1]
                    inside = min(highest, under + slice_m) - max(low, under)
                    if inside > 0.0 and 0 <= y < heights.shape[0] and 0 <= x < heights.shape[1]:
                        heights[y, x] += np.float32(inside * dense)


def farthest_points(low: tuple[Array, Array], high: tuple[Array, Array]) -> float:
    """Return how many points lines move between two heights, from their places (rows, columns) there; 0 if unseen."""
    moved = np.abs(np.stack([one - other for one, other in zip(low, high, strict=True)]))
    return float(np.nanmax(moved, initial=0.0)) if np.any(np.isfinite(moved)) else 0.0
