"""Detail below the example's pixel: cells are halved again and again, and keep their mean.

The children of a cell get the values of a plane through its neighbours, which have its mean, times log-normal numbers.
Numbers are shared by the four children at a corner of cells, so that structures reach over the sides of cells, with a
part of each child's own. Deviations from the mean are reduced where a child would leave the range of the layer.

Each halving has its own variance, so that the detail has a power spectrum k^-exponent along a line. The standard
deviation of the logarithm of all halvings is a sqrt(g + 0.02), where g is the relative change of thickness from one
pixel of the example to the next. Later halvings take g from the cells that they halve: detail makes more detail where
it is, and smooth cloud stays smooth. ``make/finer.py`` compares the result with an image of 1 km.
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

FLOOR = 0.02

# Relative changes above this are edges, which have no more detail than others.
_STEEPEST = 4.0

# Of the states of cells beside those of corners, and the bits that choose a normal number.
_CELLS, _BITS = np.uint64(0x9E3779B97F4A7C15), np.uint64(4095)

# Part of the variance of numbers that is each child's own: with it, changes over sides of cells are like others.
_OWN = 0.3

# Part of the way to the greatest thickness that one halving may take: what reaches it has no detail any more.
_HEADROOM = 0.6

# Lifetime of structures of 6 km, the shortest that was measured: 2 min per km. Below, it is that of eddies, ~ L^(2/3).
_LIFETIME_S, _LIFETIME_OF_M = 720.0, 6000.0


def lifetime_s(cell_m: float) -> float:
    """Return the lifetime of structures of two cells."""
    result: float = _LIFETIME_S * (2.0 * cell_m / _LIFETIME_OF_M) ** (2.0 / 3.0)
    return result


def deviations(strength: float, exponent: float, halving: int) -> tuple[float, float]:
    """Return the standard deviation of the logarithm that a halving, from 0, adds where g is 1, and what cells' g lack.

    The relative change from one cell to the next falls with their size; the second number makes it that of the pixels
    of the example.
    """
    ratio = 2.0 ** (1.0 - exponent)
    # Children lose a quarter of the variance of their numbers to the mean of the cell.
    share = 4.0 / 3.0 * (1.0 - ratio) * ratio**halving
    return strength * math.sqrt(share), ratio ** (-0.5 * halving)


@kernel(fastmath={"contract"})
def halve(
    children: Any,
    parents: Any,
    first: Any,
    deviation: float,
    rise: float,
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
    deviation, rise : float
        See :func:`deviations`.
    most : float
        Greatest thickness.
    key : uint64
        Of the random numbers of this halving.
    age : float
        Time in lifetimes; NaN: nothing changes.
    normals : ndarray of float64 (4096,)
        Quantiles of the normal distribution: twelve random bits choose one.
    """
    rows, columns = parents.shape
    # By corner above and below a row of cells, number and standard deviation; corner j is left of cell j.
    upper, lower = np.empty((columns, 2)), np.empty((columns, 2))
    for i in range(1, rows):
        upper, lower = lower, upper
        of_row, of_cells = hashed(key, first[0] + i), hashed(key + _CELLS, first[0] + i - 1)
        for j in range(1, columns):
            a, b, c, d = parents[i - 1, j - 1], parents[i - 1, j], parents[i, j - 1], parents[i, j]
            size = math.sqrt((c + d - a - b) ** 2 + (b + d - a - c) ** 2)
            steep = min(2.0 * size / max(a + b + c + d, 4e-6) * rise, _STEEPEST)
            spread = deviation * math.sqrt(steep + FLOOR)
            state, later, phase = _moment(hashed(of_row, first[1] + j), age)
            number = (1.0 - phase) * normals[state & _BITS]
            if phase > 0.0:
                number += phase * normals[later & _BITS]
            lower[j, 0], lower[j, 1] = spread * math.sqrt((1.0 - _OWN) * _faded(phase)) * number, spread
        for j in range(1, columns - 1 if i > 1 else 0):
            mean = parents[i - 1, j]
            top, left = 2 * (i - 2), 2 * (j - 1)
            if mean <= 0.0 or mean >= most:
                same = min(max(mean, 0.0), most)
                children[top, left] = children[top, left + 1] = same
                children[top + 1, left] = children[top + 1, left + 1] = same
                continue
            slope_y = (parents[i, j] - parents[i - 2, j]) * 0.125
            slope_x = (parents[i - 1, j + 1] - parents[i - 1, j - 1]) * 0.125
            twist = (parents[i, j + 1] - parents[i, j - 1] - parents[i - 2, j + 1] + parents[i - 2, j - 1]) * 0.015625
            state, later, phase = _moment(hashed(of_cells, first[1] + j), age)
            near = (1.0 - phase) * math.sqrt(12.0 * _OWN * _faded(phase)) / 65536.0
            far = near * phase / max(1.0 - phase, 1e-9)
            own = upper[j, 0] + upper[j, 1] * _of_child(state, later, near, far, 0)
            one = max(mean - slope_y - slope_x + twist, 0.0) * _exponential(own)
            own = upper[j + 1, 0] + upper[j + 1, 1] * _of_child(state, later, near, far, 1)
            two = max(mean - slope_y + slope_x - twist, 0.0) * _exponential(own)
            own = lower[j, 0] + lower[j, 1] * _of_child(state, later, near, far, 2)
            three = max(mean + slope_y - slope_x - twist, 0.0) * _exponential(own)
            own = lower[j + 1, 0] + lower[j + 1, 1] * _of_child(state, later, near, far, 3)
            four = max(mean + slope_y + slope_x + twist, 0.0) * _exponential(own)
            scale = 4.0 * mean / (one + two + three + four)
            largest = max(max(one, two), max(three, four)) * scale - mean
            room = _HEADROOM * (most - mean)
            reach = room / largest if largest > room else 1.0
            base, scale = mean * (1.0 - reach), scale * reach
            children[top, left], children[top, left + 1] = base + scale * one, base + scale * two
            children[top + 1, left], children[top + 1, left + 1] = base + scale * three, base + scale * four


@inner(fastmath={"contract"})
def _moment(one: Any, age: float) -> Any:
    """Return random bits before and after a change that takes a lifetime, and its progress, 0 where nothing changes."""
    if math.isnan(age):
        return one, one, 0.0
    moment = age + uniform(one)
    turn = math.floor(moment)
    return hashed(one, np.int64(turn) + 1), hashed(one, np.int64(turn) + 2), moment - turn


@inner(fastmath={"contract"})
def _faded(phase: float) -> float:
    """Return what makes the variance of a fading number 1 again."""
    return 1.0 / (phase * phase + (1.0 - phase) * (1.0 - phase))


@inner(fastmath={"contract"})
def _of_child(state: Any, later: Any, near: float, far: float, child: int) -> float:
    """Return a child's own number: 16 bits of two states, evenly distributed."""
    bits, mask = np.uint64(16 * child), np.uint64(0xFFFF)
    return near * (float((state >> bits) & mask) - 32767.5) + far * (float((later >> bits) & mask) - 32767.5)


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
