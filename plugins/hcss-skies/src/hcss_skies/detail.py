"""Detail below the example's pixel: cells are halved again and again, and keep their mean.

The children of a cell get the values of a plane through its neighbours, which have its mean, times log-normal numbers.
Deviations from the mean are reduced where a child would leave the range of the layer. Each halving has its own
variance, so that the detail has a power spectrum k^-exponent along a line, and a standard deviation of the logarithm of
a sqrt(g + 0.05) in all, where g is the relative change of thickness from one pixel of the example to the next. Measured
a: 0.27 to 0.37 in images of 3 km, 0.30 in one of 30 m.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from hcss_skies.hashing import hashed, uniform
from hcss_twin.core.kernels import inner, kernel
from hcss_twin.providers import Array

MARGIN = 3
"""Cells around a window that the first halving needs: one for its slopes, one for each later one, with room."""

FLOOR = 0.05

# Relative changes above this are edges, which have no more detail than others.
_STEEPEST = 2.0

# Part of the way to the greatest thickness that one halving may take: what reaches it has no detail any more.
_HEADROOM = 0.6

# Lifetime of structures of 6 km, the shortest that was measured: 2 min per km. Below, it is that of eddies, ~ L^(2/3).
_LIFETIME_S, _LIFETIME_OF_M = 720.0, 6000.0


def lifetime_s(cell_m: float) -> float:
    """Return the lifetime of structures of two cells."""
    result: float = _LIFETIME_S * (2.0 * cell_m / _LIFETIME_OF_M) ** (2.0 / 3.0)
    return result


def steepness(cells: Array) -> Array:
    """Return the relative change of cells (rows, columns) from one to the next, without the outermost cells."""
    along = 0.5 * (cells[2:, 1:-1] - cells[:-2, 1:-1])
    across = 0.5 * (cells[1:-1, 2:] - cells[1:-1, :-2])
    inner = cells[1:-1, 1:-1]
    steep: Array = np.minimum(np.hypot(along, across) / np.maximum(inner, 1e-6), _STEEPEST)
    return steep


def deviations(steep: Array, strength: float, exponent: float, halving: int) -> Array:
    """Return the standard deviation of the logarithm that a halving, from 0, adds."""
    ratio = 2.0 ** (1.0 - exponent)
    # Children lose a quarter of the variance of their numbers to the mean of the cell.
    share = 4.0 / 3.0 * (1.0 - ratio) * ratio**halving
    result: Array = strength * np.sqrt(share * (steep + FLOOR))
    return result


@kernel(fastmath={"contract"})
def halve(
    children: Any,
    parents: Any,
    first: Any,
    deviation: Any,
    root: Any,
    halving: int,
    most: float,
    key: Any,
    age: float,
    normals: Any,
) -> None:
    """Write the children (2 rows - 4, 2 columns - 4) of cells (rows, columns) without the outermost ones.

    Parameters
    ----------
    children, parents : ndarray of float64
        Thickness in m.
    first : ndarray of int64 (2,)
        Indices of the first parent.
    deviation : ndarray of float64
        Standard deviation of the logarithm, by pixel of the example.
    root : ndarray of int64 (2,)
        Pixel of the example that the first value of ``deviation`` belongs to.
    halving : int
        From 0.
    most : float
        Greatest thickness.
    key : uint64
        Of the random numbers of this halving.
    age : float
        Time in lifetimes; NaN: nothing changes.
    normals : ndarray of float64 (4096,)
        Quantiles of the normal distribution: twelve random bits choose one.
    """
    value = np.empty(4)
    changes = not math.isnan(age)
    for i in range(1, parents.shape[0] - 1):
        of_row = hashed(key, first[0] + i)
        own_row = ((first[0] + i) >> halving) - root[0]
        for j in range(1, parents.shape[1] - 1):
            mean = parents[i, j]
            top, left = 2 * (i - 1), 2 * (j - 1)
            if mean <= 0.0 or mean >= most:
                same = min(max(mean, 0.0), most)
                children[top, left] = children[top, left + 1] = same
                children[top + 1, left] = children[top + 1, left + 1] = same
                continue
            column = first[1] + j
            spread = deviation[own_row, (column >> halving) - root[1]]
            slope_y = (parents[i + 1, j] - parents[i - 1, j]) * 0.125
            slope_x = (parents[i, j + 1] - parents[i, j - 1]) * 0.125
            twist = (
                parents[i + 1, j + 1] - parents[i + 1, j - 1] - parents[i - 1, j + 1] + parents[i - 1, j - 1]
            ) * 0.015625
            one = hashed(of_row, column)
            other, near, far = one, spread, 0.0
            if changes:
                moment = age + uniform(one)
                turn = math.floor(moment)
                phase = moment - turn
                norm = spread / math.sqrt(phase * phase + (1.0 - phase) * (1.0 - phase))
                near, far = norm * (1.0 - phase), norm * phase
                other = hashed(one, np.int64(turn) + 2)
                one = hashed(one, np.int64(turn) + 1)
            value[0] = max(mean - slope_y - slope_x + twist, 0.0)
            value[1] = max(mean - slope_y + slope_x - twist, 0.0)
            value[2] = max(mean + slope_y - slope_x - twist, 0.0)
            value[3] = max(mean + slope_y + slope_x + twist, 0.0)
            total = 0.0
            for n in range(4):
                bits = np.uint64(12 * n)
                number = near * normals[(one >> bits) & np.uint64(4095)]
                if changes:
                    number += far * normals[(other >> bits) & np.uint64(4095)]
                value[n] *= _exponential(number)
                total += value[n]
            if total <= 0.0:
                children[top, left] = children[top, left + 1] = mean
                children[top + 1, left] = children[top + 1, left + 1] = mean
                continue
            scale = 4.0 * mean / total
            largest = max(max(value[0], value[1]), max(value[2], value[3])) * scale - mean
            room = _HEADROOM * (most - mean)
            reach = room / largest if largest > room else 1.0
            base, scale = mean * (1.0 - reach), scale * reach
            children[top, left], children[top, left + 1] = base + scale * value[0], base + scale * value[1]
            children[top + 1, left], children[top + 1, left + 1] = base + scale * value[2], base + scale * value[3]


@inner(fastmath={"contract"})
def _exponential(x: float) -> float:
    """Return exp(x) with a relative error below 1e-6 for -12 < x < 12: a series of x / 32, squared five times."""
    y = x * 0.03125
    power = 1.0 + y * (1.0 + y * (1.0 / 2.0 + y * (1.0 / 6.0 + y * (1.0 / 24.0 + y * (1.0 / 120.0 + y / 720.0)))))
    for _ in range(5):
        power *= power
    return power


def normal_quantiles() -> Array:
    """Return quantiles (4096,) of the normal distribution with variance 1."""
    quantiles = ndtri((np.arange(4096) + 0.5) / 4096.0)
    result: Array = quantiles / quantiles.std()
    return result


def average(cells: Array, y: Array, x: Array) -> NDArray[np.float32]:
    """Return the means (rows, columns) of cells over pixels with edges ``y`` (rows + 1,) and ``x`` (columns + 1,).

    Edges are counted in cells. Exact for pixels of any size: the sum of cells by the area that they share with it.
    """
    out = np.empty((y.size - 1, x.size - 1), np.float32)
    _average(out, cells, *_shares(y), *_shares(x))
    return out


def _shares(edges: Array) -> tuple[NDArray[np.int64], Array]:
    """Return the first cell (N,) of each pixel, and the share (N, M) of the pixel in this and in the next cells."""
    first = np.floor(edges[:-1]).astype(np.int64)
    most = int(np.max(np.ceil(edges[1:]).astype(np.int64) - first))
    low = first[:, None] + np.arange(most)
    shared = np.minimum(edges[1:, None], low + 1.0) - np.maximum(edges[:-1, None], low)
    return first, np.maximum(shared, 0.0) / (edges[1:] - edges[:-1])[:, None]


@kernel(fastmath={"contract"})
def _average(out: Any, cells: Any, row: Any, in_rows: Any, column: Any, in_columns: Any) -> None:
    line = np.empty(cells.shape[1])
    begin, end = column[0], min(column[-1] + in_columns.shape[1], cells.shape[1])
    for i in range(out.shape[0]):
        for m in range(begin, end):
            line[m] = 0.0
        for k in range(in_rows.shape[1]):
            share = in_rows[i, k]
            if share > 0.0:
                for m in range(begin, end):
                    line[m] += share * cells[row[i] + k, m]
        for j in range(out.shape[1]):
            total = 0.0
            for k in range(in_columns.shape[1]):
                if in_columns[j, k] > 0.0:
                    total += in_columns[j, k] * line[column[j] + k]
            out[i, j] = total
