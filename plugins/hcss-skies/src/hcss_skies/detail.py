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

from hcss_skies.hashing import hashed, normal, uniform
from hcss_twin.core.kernels import kernel
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
    children: Any, parents: Any, first: Any, deviation: Any, root: Any, halving: int, most: float, key: Any, age: float
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
    """
    value = np.empty(4)
    for i in range(1, parents.shape[0] - 1):
        row = first[0] + i
        for j in range(1, parents.shape[1] - 1):
            mean = parents[i, j]
            top, left = 2 * (i - 1), 2 * (j - 1)
            if mean <= 0.0 or mean >= most:
                for n in range(4):
                    children[top + n // 2, left + n % 2] = min(max(mean, 0.0), most)
                continue
            column = first[1] + j
            spread = deviation[(row >> halving) - root[0], (column >> halving) - root[1]]
            slope_y = (parents[i + 1, j] - parents[i - 1, j]) * 0.125
            slope_x = (parents[i, j + 1] - parents[i, j - 1]) * 0.125
            twist = (
                parents[i + 1, j + 1] - parents[i + 1, j - 1] - parents[i - 1, j + 1] + parents[i - 1, j - 1]
            ) * 0.015625
            total = 0.0
            for n in range(4):
                up, right = (1.0 if n >= 2 else -1.0), (1.0 if n % 2 else -1.0)
                smooth = max(mean + up * slope_y + right * slope_x + up * right * twist, 0.0)
                state = hashed(hashed(key, 2 * row + n // 2), 2 * column + n % 2)
                number = 0.0
                if math.isnan(age):
                    number = normal(state)
                else:
                    moment = age + uniform(hashed(state, 0))
                    turn = math.floor(moment)
                    angle = 0.5 * math.pi * (moment - turn)
                    number = math.cos(angle) * normal(hashed(state, np.int64(turn) + 1))
                    number += math.sin(angle) * normal(hashed(state, np.int64(turn) + 2))
                value[n] = smooth * math.exp(spread * number)
                total += value[n]
            scale = 4.0 * mean / total if total > 0.0 else 0.0
            reach = 1.0
            for n in range(4):
                value[n] = value[n] * scale - mean if total > 0.0 else 0.0
                if value[n] > _HEADROOM * (most - mean):
                    reach = min(reach, _HEADROOM * (most - mean) / value[n])
            for n in range(4):
                children[top + n // 2, left + n % 2] = mean + reach * value[n]


@kernel(fastmath={"contract"})
def average(out: Any, cells: Any, y: Any, x: Any) -> None:
    """Write the means (rows, columns) of cells over pixels with edges ``y`` (rows + 1,), ``x`` (columns + 1,) in cells.

    Exact for any pixel: the sum of cells by the area that they share with it.
    """
    for i in range(out.shape[0]):
        low, high = y[i], y[i + 1]
        for j in range(out.shape[1]):
            left, right = x[j], x[j + 1]
            total = 0.0
            for row in range(math.floor(low), math.ceil(high)):
                tall = min(high, row + 1.0) - max(low, float(row))
                along = 0.0
                for column in range(math.floor(left), math.ceil(right)):
                    along += (min(right, column + 1.0) - max(left, float(column))) * cells[row, column]
                total += tall * along
            out[i, j] = total / ((high - low) * (right - left))
