"""How far the sun shines through the clouds of one layer on its straight way to points of the sea.

The layer is cut into slices of equal height, in each of which the sun's path moves by at most one point along either
axis. Each slice is met at the point, rounded, where the path passes its middle height, and its cloud lies there between
the layer's flat side and the thickness away from it. Under a sheet the slices add up to the sheet's thickness.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from hcss_twin.providers import CloudGenerator, CloudLayer, Sun
from hcss_twin.scene.slant.slant_paths import displacement_m

Thickness = NDArray[np.float32]


@dataclass(frozen=True)
class SunPaths:
    """Slices of one layer as the sun's paths at one instant meet them.

    Attributes
    ----------
    shifts : ndarray of int64 (S, 2)
        Rows and columns of points from the sea point to where its path meets each slice.
    from_flat_m : ndarray (S,)
        Height between the layer's flat side and the near face of the slice.
    slice_m : float
        Height of each slice.
    """

    shifts: NDArray[np.int64]
    from_flat_m: NDArray[np.float64]
    slice_m: float

    def stay_at(self, shift: tuple[int, int]) -> bool:
        """Whether all slices are met at one displacement."""
        return bool(np.all(self.shifts == np.array(shift)))

    def heights_m(
        self, generator: CloudGenerator, time_s: float, rows: slice, columns: slice
    ) -> NDArray[np.float32]:
        """Return the height (y, x) in cloud of the sun's paths to the points of a window of the image.

        Divided by the cosine of the sun's zenith it is the length of the path in cloud.

        Parameters
        ----------
        generator : CloudGenerator
            With the method ``displaced_m`` of :class:`hcss_twin.scene.slant.displaced_clouds.DisplacedClouds`.
        """
        first, last = self.shifts.min(axis=0), self.shifts.max(axis=0)
        wide = (
            slice(window.start, window.stop + int(high - low))
            for window, low, high in zip((rows, columns), first, last, strict=True)
        )
        start = int(first[0]), int(first[1])
        thickness = generator.displaced_m(time_s, *wide, start)  # type: ignore[attr-defined]
        heights = np.zeros((rows.stop - rows.start, columns.stop - columns.start), dtype=np.float32)
        _add_slices(
            heights, np.ascontiguousarray(thickness), self.shifts - first, self.from_flat_m, self.slice_m
        )
        return heights


def sun_paths(layer: CloudLayer, sun: Sun, point_m: float) -> SunPaths:
    """Cut a layer into slices for the sun at one instant."""
    moved = displacement_m(layer.thickness_max_m, sun.zenith_deg, sun.azimuth_deg)
    count = max(1, math.ceil(float(np.max(np.abs(moved))) / point_m))
    middle = layer.base_m + layer.thickness_max_m * (np.arange(count) + 0.5) / count
    away = np.stack([displacement_m(height, sun.zenith_deg, sun.azimuth_deg) for height in middle])
    from_base = layer.thickness_max_m * np.arange(count) / count
    from_flat = from_base if layer.anchor == "base" else from_base[::-1]
    shifts = np.rint(away / point_m).astype(np.int64)
    return SunPaths(shifts, from_flat, layer.thickness_max_m / count)


@njit(cache=True, nogil=True)
def _add_slices(heights, thickness, shifts, from_flat, slice_m):  # type: ignore[no-untyped-def]
    """Add to ``heights`` the cloud of each slice, in single precision as thickness has it."""
    full, nothing = np.float32(slice_m), np.float32(0.0)
    for s in range(shifts.shape[0]):
        down, right, near = shifts[s, 0], shifts[s, 1], np.float32(from_flat[s])
        for y in range(heights.shape[0]):
            for x in range(heights.shape[1]):
                inside = thickness[y + down, x + right] - near
                heights[y, x] += min(max(inside, nothing), full)
