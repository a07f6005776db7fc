"""All columns with cloud in two layers from a few: crosses of rows and columns of their product.

Seen from space two layers meet in few independent ways, so that the matrix of radiances over the thickness of one and
of the other has a low rank: a handful of its rows and columns says what the rest is (the skeleton or cross
approximation: S. A. Goreinov, E. E. Tyrtyshnikov and N. L. Zamarashkin, *A theory of pseudoskeleton approximations*,
Linear Algebra Appl. 261, 1997). Elements that are in no cross are computed to find the error, and where it is too
large the worst of them gets a cross of its own.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Pairs = Callable[[Array], Array]
"""Maps pairs of thicknesses (N, 2), low and high, to terms (N, K, B)."""

FIRST_CROSSES = 3
"""Through the thinnest, the middle and the thickest of both layers."""

TRIED = 24
"""Elements outside the crosses that are computed for each judgement."""

_RANK = 1e-9
"""Singular values below this share of the largest are rounding."""


def complete(columns: Pairs, low_m: Array, high_m: Array, tolerance: float) -> tuple[Array, float]:
    """Return the columns of all pairs of thicknesses.

    Parameters
    ----------
    columns : callable
    low_m, high_m : ndarray (E,), (F,)
        Ascending.
    tolerance : float
        Of the total of any band, relative.

    Returns
    -------
    ndarray (E, F, K, B)
        Computed in the crosses, completed elsewhere.
    float
        Largest relative error of the total among the elements tried last; 0 where all were computed.
    """
    size = low_m.size, high_m.size
    rows, across = (_first(each) for each in size)
    by_row = {row: _line(columns, low_m[row : row + 1], high_m) for row in rows}
    by_column = {column: _line(columns, low_m, high_m[column : column + 1]) for column in across}
    start = 0
    while True:
        found = _skeleton(by_row, by_column)
        tried = _elsewhere(size, by_row, by_column, start)
        if tried is None or len(by_row) >= min(size):
            return _line_by_line(columns, by_row, low_m, high_m), 0.0
        start += TRIED
        exact = columns(np.stack((low_m[tried[0]], high_m[tried[1]]), axis=1))
        total = np.sum(exact, axis=1)
        guess = np.sum(found[tried], axis=1)
        error = np.max(np.abs(guess - total) / np.maximum(np.abs(total), np.finfo(float).tiny), axis=1)
        worst = int(np.argmax(error))
        if error[worst] <= 0.5 * tolerance:
            return found, float(error[worst])
        row, column = int(tried[0][worst]), int(tried[1][worst])
        by_row.setdefault(row, _line(columns, low_m[row : row + 1], high_m))
        by_column.setdefault(column, _line(columns, low_m, high_m[column : column + 1]))


def _first(size: int) -> list[int]:
    return sorted(set(np.linspace(0, size - 1, FIRST_CROSSES).round().astype(int).tolist()))


def _line(columns: Pairs, low_m: Array, high_m: Array) -> Array:
    """Columns of one row or one column of the product, (N, K, B)."""
    return columns(np.stack(np.broadcast_arrays(low_m, high_m), axis=1))


def _line_by_line(columns: Pairs, by_row: dict[int, Array], low_m: Array, high_m: Array) -> Array:
    """Compute every row that is not known yet."""
    return np.stack(
        [
            by_row[row] if row in by_row else _line(columns, low_m[row : row + 1], high_m)
            for row in range(low_m.size)
        ]
    )


def _skeleton(by_row: dict[int, Array], by_column: dict[int, Array]) -> Array:
    """Complete the product from its crosses; the crosses themselves stay as they are."""
    rows, across = sorted(by_row), sorted(by_column)
    lines = np.stack([by_row[row] for row in rows])  # (I, F, K, B)
    columns = np.stack([by_column[column] for column in across], axis=1)  # (E, J, K, B)
    centre = np.moveaxis(lines[:, across], (0, 1), (-2, -1))  # (K, B, I, J)
    inverse = np.linalg.pinv(centre, rcond=_RANK)
    found: Array = np.einsum("ejkb,kbji,ifkb->efkb", columns, inverse, lines, optimize=True)
    for index, column in enumerate(across):
        found[:, column] = columns[:, index]
    for index, row in enumerate(rows):
        found[row] = lines[index]
    return found


def _elsewhere(
    size: tuple[int, int], by_row: dict[int, Array], by_column: dict[int, Array], start: int
) -> tuple[NDArray[np.intp], NDArray[np.intp]] | None:
    """Indices of some elements that are in no cross, spread over the product; None if there are too few."""
    free = [
        np.setdiff1d(np.arange(n), list(known)) for n, known in zip(size, (by_row, by_column), strict=True)
    ]
    if free[0].size * free[1].size <= 2 * TRIED:
        return None
    # Kronecker sequence of the plastic number's powers: even, and never the same twice.
    number = np.arange(start, start + TRIED) + 1.0
    share = np.mod(number[:, None] * np.array([0.7548776662466927, 0.5698402909980532]), 1.0)
    places = [each[(share[:, axis] * each.size).astype(int)] for axis, each in enumerate(free)]
    return places[0], places[1]
