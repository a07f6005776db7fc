"""Radiance of a frame whose pixels have views of their own: look-ups at each node, weighted pixel by pixel."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy

import numpy as np
from numba import njit
from numpy.typing import NDArray

from hcss_twin.providers import Grid
from hcss_twin.scene.footprint import Window, points_of
from hcss_twin.scene.tables.look_up import LookUp
from hcss_twin.scene.views.view_axis import ViewAxis

Thickness = NDArray[np.float32]

VALUES_AT_ONCE = 2**21
"""Pixels times channels whose sums are held together; 16 MB."""


class ViewedLookUp:
    """Look-up in the tables of one instant, toward the view of each pixel.

    Parameters
    ----------
    axis : ViewAxis
    grid : Grid
        The image, in pixels.
    look_ups : sequence of LookUp
        One for each node of the axis, in its order.
    """

    def __init__(self, axis: ViewAxis, grid: Grid, look_ups: Sequence[LookUp]) -> None:
        self._look_ups = look_ups
        self._across, self._up = axis.weights(grid)

    def of_part(self, extent: Window) -> ViewedLookUp:
        """Return the look-up of some rows and columns of the image, counted from the first of them."""
        part = copy(self)
        part._up, part._across = self._up[extent[0]], self._across[extent[1]]
        return part

    def fill(
        self,
        radiance: NDArray[np.float32],
        thickness_m: Sequence[Thickness],
        samples: int = 1,
        corner: tuple[int, int] = (0, 0),
    ) -> None:
        """Write the radiance of a window of the image, as :meth:`LookUp.fill` does; without layers of all of it."""
        if thickness_m:
            rows, columns = (size // samples for size in thickness_m[0].shape)
        else:
            rows, columns, corner = len(self._up), len(self._across), (0, 0)
        step = max(1, VALUES_AT_ONCE // (radiance.shape[0] * columns))
        for first in range(0, rows, step):
            strip = slice(first, min(first + step, rows))
            points = [each[points_of(strip, samples)] for each in thickness_m]
            self._fill_strip(
                radiance, points, samples, (corner[0] + first, corner[1]), strip.stop - first, columns
            )

    def _fill_strip(
        self,
        radiance: NDArray[np.float32],
        thickness_m: Sequence[Thickness],
        samples: int,
        corner: tuple[int, int],
        rows: int,
        columns: int,
    ) -> None:
        window = slice(corner[0], corner[0] + rows), slice(corner[1], corner[1] + columns)
        sums = np.zeros((radiance.shape[0], rows, columns))
        part = np.empty(sums.shape, dtype=np.float32)
        up, across = self._up[window[0]], self._across[window[1]]
        for node, look_up in enumerate(self._look_ups):
            look_up.fill(part, thickness_m, samples)
            row, column = divmod(node, across.shape[1])
            _add(sums, part, np.ascontiguousarray(up[:, row]), np.ascontiguousarray(across[:, column]))
        # A term that vanishes may be less than 0 between nodes.
        radiance[:, window[0], window[1]] = np.maximum(sums, 0.0)


@njit(cache=True, nogil=True)
def _add(sums, part, up, across):  # type: ignore[no-untyped-def]
    """Add a part (C, y, x) to sums, weighted by row and column."""
    for c in range(sums.shape[0]):
        for y in range(sums.shape[1]):
            weight = up[y]
            for x in range(sums.shape[2]):
                sums[c, y, x] += weight * across[x] * np.float64(part[c, y, x])
