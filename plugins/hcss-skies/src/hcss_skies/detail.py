"""Laws of the detail below the example's pixel, and means over pixels; ``refining.py`` makes the detail.

Each halving of a pixel adds an octave with its own variance, so that the detail has a power spectrum k^-exponent along
a line. The standard deviation of the logarithm of thickness is strength x sqrt(g + 0.02), where g is the relative
change of thickness from one pixel to the next: smooth cloud stays smooth. ``make/scores.md`` compares the result with
an image of 1 km.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_skies.fibres import SIDE
from hcss_twin.core.kernels import kernel
from hcss_twin.providers import Array

# Lifetime of structures of 6 km, the shortest that was measured: 2 min per km. Below, it is that of eddies, ~ L^(2/3).
_LIFETIME_S, _LIFETIME_OF_M = 720.0, 6000.0


def lifetime_s(cell_m: float) -> float:
    """Return the lifetime of structures of two cells."""
    result: float = _LIFETIME_S * (2.0 * cell_m / _LIFETIME_OF_M) ** (2.0 / 3.0)
    return result


def deviation_of(exponent: float, halving: int) -> float:
    """Return the standard deviation of the octave of a halving, from 0, in parts of the strength."""
    ratio = 2.0 ** (1.0 - exponent)
    # Parts lose a quarter of the variance of their numbers to the mean of the cell.
    share = 4.0 / 3.0 * (1.0 - ratio) * ratio**halving
    return math.sqrt(share)


def moments_of(keys: Sequence[int], ages: Sequence[float]) -> tuple[NDArray[np.int64], Array]:
    """Return where textures begin (octaves, 2, 2), and their parts (octaves, 2), at times in lifetimes; NaN: frozen.

    A texture fades into one from another place in a lifetime; the squares of their parts sum to 1.
    """
    places, parts = np.zeros((len(keys), 2, 2), np.int64), np.zeros((len(keys), 2))
    for octave, (key, age) in enumerate(zip(keys, ages, strict=True)):
        moment = 0.0 if math.isnan(age) else age + (_mixed(key) >> 11) / 2.0**53
        turn = math.floor(moment)
        phase = moment - turn
        parts[octave] = np.array([1.0 - phase, phase]) / math.hypot(1.0 - phase, phase)
        for use in range(2):
            drawn = _mixed(_mixed(key) ^ (turn + use) % 2**64)
            places[octave, use] = drawn % SIDE, (drawn >> 32) % SIDE
    return places, parts


def _mixed(number: int) -> int:
    """Return 64 random bits of a number (SplitMix64, as in ``hashing``)."""
    value = (number + 0x9E3779B97F4A7C15) % 2**64
    value = (value ^ value >> 30) * 0xBF58476D1CE4E5B9 % 2**64
    value = (value ^ value >> 27) * 0x94D049BB133111EB % 2**64
    return value ^ value >> 31


def average(cells: NDArray[np.float32], y: Array, x: Array) -> NDArray[np.float32]:
    """Return the means (rows, columns) of cells over pixels with edges ``y`` (rows + 1,) and ``x`` (columns + 1,).

    Edges are counted in cells. Exact for pixels of any size: the sum of cells by the area that they share with it.
    """
    out = np.empty((y.size - 1, x.size - 1), np.float32)
    column, in_columns = _shares(x)
    _average(out, cells, *_shares(y), column, np.ascontiguousarray(in_columns.T))
    return out


def _shares(edges: Array) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
    """Return the first cell (N,) of each pixel, and the share (N, M) of the pixel in this and in the next cells."""
    first = np.floor(edges[:-1]).astype(np.int64)
    most = int(np.max(np.ceil(edges[1:]).astype(np.int64) - first))
    low = first[:, None] + np.arange(most)
    shared = np.minimum(edges[1:, None], low + 1.0) - np.maximum(edges[:-1, None], low)
    return first, (np.maximum(shared, 0.0) / (edges[1:] - edges[:-1])[:, None]).astype(np.float32)


@kernel(fastmath={"contract"})
def _average(out: Any, cells: Any, row: Any, in_rows: Any, column: Any, in_columns: Any) -> None:
    """Write means; shares of the rows (rows, M), and of the columns (N, columns)."""
    zero, width = np.float32(0.0), cells.shape[1]
    line = np.zeros(width + in_columns.shape[0], np.float32)
    for i in range(out.shape[0]):
        for m in range(width):
            line[m] = zero
        for k in range(in_rows.shape[1]):
            share, cell_row = in_rows[i, k], row[i] + k
            if share > zero:
                for m in range(width):
                    line[m] += share * cells[cell_row, m]
        for j in range(out.shape[1]):
            out[i, j] = zero
        for k in range(in_columns.shape[0]):
            for j in range(out.shape[1]):
                out[i, j] += in_columns[k, j] * line[np.uint64(column[j] + k)]
