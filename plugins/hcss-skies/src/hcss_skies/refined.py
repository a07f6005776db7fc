"""Pixels of a scene in cells of a sky: where they are, and their means over cells with detail below their size."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hcss_skies.blended import key_of
from hcss_skies.detail import average, deviation_of, lifetime_s, moments_of
from hcss_skies.example import Detail
from hcss_skies.fibres import textures
from hcss_skies.pace import Pace
from hcss_skies.refining import MARGIN, STAGE, refine
from hcss_twin.providers import Array, Grid, ProviderError


class RefinedCells:
    """Pixels over cells; the middle of the scene is where the four middle cells of the sky meet.

    Parameters
    ----------
    grid : Grid
        Pixels.
    cell_m : float
        Side of a cell.
    pace : Pace
        Motion of the scene over the sky, and how fast detail changes.
    seed : int
        Of the detail.
    detail : Detail
        Its strength and exponent.

    Attributes
    ----------
    pixel : float
        Side of a pixel in cells.
    halvings : int
        How often cells are halved until they are no larger than pixels.
    """

    def __init__(self, grid: Grid, cell_m: float, pace: Pace, seed: int, detail: Detail) -> None:
        self._grid, self._cell_m, self._pace, self._seed, self._detail = grid, cell_m, pace, seed, detail
        self.pixel = grid.pixel_size_m / cell_m
        if not 1e-6 <= self.pixel <= 1e6:
            raise ProviderError(
                f"example: pixels of {grid.pixel_size_m:g} m; allowed: {1e-6 * cell_m:g} to "
                f"{1e6 * cell_m:g} m with this example"
            )
        self.halvings = max(0, math.ceil(-math.log2(self.pixel) - 1e-9))
        if self.halvings == 1:  # pixels of half a cell are means of smaller ones, so that all sensors see one sky
            self.halvings = STAGE
        self._textures = textures() if self.halvings else None

    def edges(self, shape: tuple[int, ...], time_s: float, row: int, column: int) -> list[Array]:
        """Return the edges of pixels along y and x, in cells from the middle of the sky."""
        grid = self._grid
        return [
            self.pixel
            * (np.arange(first, first + size + 1, dtype=np.float64) - 0.5 * total + self._drift(speed, time_s))
            for first, size, total, speed in zip(
                (row, column), shape[:2], (grid.rows, grid.columns), self._pace.speed_m_s, strict=True
            )
        ]

    def regions(self, edges: list[Array]) -> list[tuple[tuple[int, ...], tuple[int, ...]]]:
        """Return the first and last cell (y, x) that each stage of the detail needs, MARGIN cells around."""
        scale = 2.0 ** ((self.halvings - 1) // STAGE * STAGE)
        low = tuple(math.floor(edge[0] * scale) - MARGIN for edge in edges)
        high = tuple(math.ceil(edge[-1] * scale) + MARGIN for edge in edges)
        regions = [(low, high)]
        for _ in range((self.halvings - 1) // STAGE):
            low = tuple((cell >> STAGE) - MARGIN for cell in low)
            high = tuple(-(-cell >> STAGE) + MARGIN for cell in high)
            regions.insert(0, (low, high))
        return regions

    def means(
        self, cells: NDArray[np.float32], first: list[int], edges: list[Array], time_s: float, most_m: float,
        visible_m: float,
    ) -> NDArray[np.float32]:  # fmt: skip
        """Return the mean thickness of pixels: cells are halved until they are no larger.

        Parameters
        ----------
        cells : ndarray of float32
            Thickness of the cells of the first of the :meth:`regions`, which begin at ``first``.
        most_m, visible_m : float
            Greatest thickness, and the one with an optical thickness of about 1.
        """
        for done, (low, high) in zip(range(0, self.halvings, STAGE), self.regions(edges), strict=True):
            halvings = range(done, min(done + STAGE, self.halvings))
            part = np.ascontiguousarray(
                cells[low[0] - first[0] : high[0] - first[0], low[1] - first[1] : high[1] - first[1]]
            )
            parts = 2 ** len(halvings)
            finer = np.empty(tuple(parts * (size - 2 * MARGIN) for size in part.shape), np.float32)
            law = np.array([deviation_of(self._detail.exponent, halving) for halving in halvings])
            cell_m = [self._cell_m / 2.0 ** (halving + 1) for halving in halvings]
            moments = moments_of(
                [key_of(self._seed, halving) for halving in halvings],
                [time_s * self._pace.rate / lifetime_s(size_m) for size_m in cell_m],
            )
            refine(
                finer, part, np.array(low), self._detail.strength, law, most_m, visible_m, self._textures, *moments
            )  # fmt: skip
            cells, first = finer, [parts * (first_cell + MARGIN) for first_cell in low]
        scale = 2.0**self.halvings
        return average(cells, *(edge * scale - low for edge, low in zip(edges, first, strict=True)))

    def _drift(self, speed_m_s: float, time_s: float) -> float:
        """Return a displacement in pixels, without rounding errors where it is a multiple of 1/1024."""
        pixels = speed_m_s * time_s / self._grid.pixel_size_m
        rounded = round(pixels * 1024.0) / 1024.0
        return rounded if abs(pixels - rounded) <= 2e-15 * abs(pixels) else pixels
