"""What lines of sight meet of clouds whose tops vary: the first column, by its top or its side.

A straight line passes the heights of such a layer from its highest top down to its lowest base. They are divided into
slices of equal height, in each of which the line moves by at most half a point along either axis. The first column that
has cloud in the slice of its point is seen, as a whole and at its own height.
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
    """Clouds that the lines of sight of some points have met so far.

    Parameters
    ----------
    shape : (int, int)
    top_m : float
        Of points that meet none.

    Attributes
    ----------
    thickness_m, top_m : ndarray of float32 (y, x)
        Of the column that each point sees; 0 where it sees none.
    """

    def __init__(self, shape: tuple[int, ...], top_m: float) -> None:
        self.thickness_m: Cloud = np.zeros(shape, np.float32)
        self.top_m: Cloud = np.full(shape, top_m, np.float32)

    def look(
        self, thickness_m: Cloud, top_m: Cloud, at: tuple[NDArray[np.int64], NDArray[np.int64]], of: Level
    ) -> None:
        """Look at a slice of clouds (Y, X) of a part of the plane, at its points (y, x) of these rows and columns."""
        row, column = (np.broadcast_to(part, self.top_m.shape) for part in at)
        _look(self.thickness_m, self.top_m, thickness_m, top_m, row, column, of.low_m, of.high_m)


@kernel()
def _look(seen, seen_top, thickness, top, row, column, low, high):  # type: ignore[no-untyped-def]
    """Set what points see that have seen nothing; those of negative rows see nothing."""
    for y in range(seen.shape[0]):
        for x in range(seen.shape[1]):
            i, j = row[y, x], column[y, x]
            if seen[y, x] > 0.0 or i < 0:
                continue
            cloud, highest = thickness[i, j], top[i, j]
            if cloud > 0.0 and highest >= low and highest - cloud <= high:
                seen[y, x], seen_top[y, x] = cloud, highest


@kernel()
def add_hanging(heights, thickness, top, shifts, lows, slice_m):  # type: ignore[no-untyped-def]
    """Add to ``heights`` (y, x) what paths cross of hanging clouds (Y, X), displaced (S, 2) in slices from ``lows``."""
    for s in range(shifts.shape[0]):
        down, right, low = shifts[s, 0], shifts[s, 1], lows[s]
        for y in range(heights.shape[0]):
            for x in range(heights.shape[1]):
                cloud = np.float64(thickness[y + down, x + right])
                if cloud > 0.0:
                    highest = np.float64(top[y + down, x + right])
                    inside = min(highest, low + slice_m) - max(highest - cloud, low)
                    heights[y, x] += np.float32(max(inside, 0.0))


def farthest_points(low: tuple[Array, Array], high: tuple[Array, Array]) -> float:
    """Return how many points lines move between two heights, from their places (rows, columns) there; 0 if unseen."""
    moved = np.abs(np.stack([one - other for one, other in zip(low, high, strict=True)]))
    return float(np.nanmax(moved, initial=0.0)) if np.any(np.isfinite(moved)) else 0.0
