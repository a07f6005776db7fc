"""Where there are more and where fewer of a film's clouds: an example of larger pixels decides.

Films have boxes of 10 km and are alike everywhere; what is larger is seen in images.

Scattered clouds: a pixel of the example that is s times as much colder than the clear sky as its cold clouds is covered
by 1 - exp(-a (s + f)): clouds at random places, in proportion to what is seen, and a few (f) in its clear sky, too, as
clouds smaller than pixels are not seen in images. The number a gives the sky its mean cover.

Sheets: the normal score of the example has the share m of the variance of all scores, and the film the rest. A pixel of
score e is covered by Phi((sqrt(m) e + z) / sqrt(1 - m)): cells are closed, and lanes between them open. The number z
gives the sky its mean cover.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter
from scipy.optimize import brentq
from scipy.special import ndtr, ndtri

from hcss_skies.blended import BlendedExample
from hcss_skies.distribution import ranked
from hcss_skies.example import MAX_SCORE, Example, make_example, read_example
from hcss_skies.reel import Reel
from hcss_twin.core.kernels import kernel
from hcss_twin.providers import Array

_COLD = 2.0
"""Normal score of the cold clouds of an example."""

_UNSEEN = 0.03
"""Clouds of its clear sky, in parts of those of its cold clouds."""

_FULLEST = 0.98
"""Local cover of scattered clouds that is never exceeded, unless the mean one is larger."""

_OF_EXAMPLE = 0.8
"""Share m of the variance of sheets: our choice; with less the cells are grainy, with more lanes have the edges of the
example's pixels. Spectra of water path as k^-5/3 to 50 km would give 0.7 above 8 km."""

_RAISED = 1.0
"""By how much the scores of a sheet are raised at most, so that cold places are not thicker than the film has it."""

_SMOOTH = 0.8
"""Scale in pixels over which examples are smoothed for sheets: lanes of one pixel would become strings of beads, and
their edges would be those of pixels, not of the film's clouds."""

_NODES = 0.5
"""Distance of the places at which the example is looked up, in its pixels, about; between them it is interpolated."""

_MOST = 1e4
"""Greatest number a."""


class Places:
    """The change of a film's clouds from place to place.

    Parameters
    ----------
    example : Example
        What decides; for sheets of :func:`read_smooth`.
    reel : Reel
        The film.
    coverage : float
        Mean over the sky: in the middle of it, an area as large as the example, at time 0, and over all skies.
    cell_m : float
        Side of a cell.
    seed : int
        Of the blended example: that of the generator `example`, so that both show one sky.
    """

    def __init__(self, example: Example, reel: Reel, coverage: float, cell_m: float, seed: int) -> None:
        self._blended = blended = BlendedExample(example, example.pixel_size_m, seed)
        self._cell = cell_m / example.pixel_size_m
        self._every = max(1, round(_NODES / self._cell))
        self.cover_of_scores = cover = local_cover(
            example, blended.level.heights_m[:, 0].astype(np.float64), coverage, reel
        )
        change = reel.change_of(cover)
        expected = np.ascontiguousarray(np.stack([change, np.zeros_like(change)], axis=1), dtype=np.float32)
        self._tables = ranked(expected, example.opaque.shape, self._at_start)

    def _at_start(self, out: NDArray[np.float32], y: Array, x: Array, tables: NDArray[np.float32]) -> None:
        self._blended.blend(0.0, out, y, x, tables, 1.0)

    def change(self, time_s: float, first: tuple[int, int], shape: tuple[int, int]) -> NDArray[np.float32]:
        """Return what :meth:`~hcss_skies.reel.Reel.change_of` gives (rows, columns) for cells from ``first`` on."""
        every = self._every
        low = [math.floor(cell / every) for cell in first]
        count = [
            math.floor((cell + size - 1) / every) + 2 - node for cell, size, node in zip(first, shape, low, strict=True)
        ]
        y, x = (
            (np.arange(node, node + size, dtype=np.float64) * every + 0.5) * self._cell
            for node, size in zip(low, count, strict=True)
        )
        nodes = np.empty((y.size, x.size, 1), np.float32)
        self._blended.blend(time_s, nodes, y, x, self._tables, self._cell * every)
        out = np.empty(shape, np.float32)
        _between(out, nodes[..., 0], first[0] - low[0] * every, first[1] - low[1] * every, every)
        return out


def read_smooth(path: Path) -> Example:
    """Return the example of a file for sheets: smooth."""
    example = read_example(path)
    height = np.maximum(example.opaque_m, example.clear_m)[example.opaque]
    smooth = gaussian_filter(height, _SMOOTH, mode="reflect")
    return make_example(
        smooth, None, pixel_size_m=example.pixel_size_m, clear_m=example.clear_m, kind=example.kind,
        source=example.source, licence=example.licence,
    )  # fmt: skip


def local_cover(example: Example, heights_m: Array, coverage: float, reel: Reel) -> Array:
    """Return the cover at heights p of an example, (N,) at scores from -4 to 4, with a mean."""
    scores = np.linspace(-MAX_SCORE, MAX_SCORE, heights_m.size)
    chance = np.exp(-0.5 * scores**2)
    chance /= chance.sum()
    if reel.film.sheet:
        return _cover_of_sheet(scores, chance, coverage, reel.film.coverage)
    cold_m = float(np.interp(_COLD, scores, heights_m))
    share = np.maximum(heights_m - example.clear_m, 0.0) / max(cold_m - example.clear_m, 1.0) + _UNSEEN
    fullest = max(_FULLEST, 0.5 * (1.0 + coverage))

    def cover(log_a: float) -> Array:
        return -fullest * np.expm1(-math.exp(log_a) * share)

    least, most = math.log(1e-6), math.log(_MOST)
    return cover(float(brentq(lambda log_a: float(chance @ cover(log_a)) - coverage, least, most)))


def _cover_of_sheet(scores: Array, chance: Array, coverage: float, of_film: float) -> Array:
    """Return the cover (N,) at scores of an example that have chances, with a mean."""
    fullest = max(float(ndtr(ndtri(of_film) + _RAISED)), 0.5 * (1.0 + coverage))
    of_example, others = math.sqrt(_OF_EXAMPLE), math.sqrt(1.0 - _OF_EXAMPLE)

    def cover(mean: float) -> Array:
        found: Array = np.minimum(ndtr((of_example * scores + mean) / others), fullest)
        return found

    return cover(float(brentq(lambda mean: float(chance @ cover(mean)) - coverage, -20.0, 20.0)))


@kernel(fastmath={"contract"})
def _between(out: Any, nodes: Any, row: int, column: int, every: int) -> None:
    """Write values (rows, columns) between nodes, bilinear, from a cell on that is so far from the first node."""
    for i in range(out.shape[0]):
        k, fy = (row + i) // every, np.float32((row + i) % every) / np.float32(every)
        for j in range(out.shape[1]):
            m, fx = (column + j) // every, np.float32((column + j) % every) / np.float32(every)
            low = nodes[k, m] + fx * (nodes[k, m + 1] - nodes[k, m])
            high = nodes[k + 1, m] + fx * (nodes[k + 1, m + 1] - nodes[k + 1, m])
            out[i, j] = low + fy * (high - low)
