"""Columns with cloud in two layers: exact columns on the product of two thickness axes, and look-up between them.

The matrix of radiances over the thicknesses of the two layers has a low rank, so that a few of its rows and columns
determine the rest (the skeleton or cross approximation: S. A. Goreinov, E. E. Tyrtyshnikov and N. L. Zamarashkin, *A
theory of pseudoskeleton approximations*, Linear Algebra Appl. 261, 1997). Elements outside the crosses are computed
to measure the error; if it is too large, a cross is added at the worst element.

Along each axis radiance is interpolated as for one layer: by splines in ln(thickness) between the exact nodes of each
smooth segment, and linearly between the dense nodes of the look-up. The axes of the single layers are the first
guess; below or above another cloud, a layer can need more nodes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.error_norm import largest_error
from hcss_twin.engine.tables.thickness_axis import (
    LINEAR_SHARE,
    MAX_NODES,
    ColumnsAt,
    Source,
    ThicknessAxis,
    curve_through,
    dense_nodes,
    jumping,
    worst,
)
from hcss_twin.providers import CloudLayer

Pairs = Callable[[Array], Array]
"""Maps pairs of thicknesses (N, 2), low and high, to terms (N, K, B)."""

FIRST_CROSSES = 3
"""Initial crosses, at the thinnest, the middle and the thickest cloud of both layers."""

FIRST_CROSSES_NEAR = 2
"""Initial crosses of a difference from columns that are near."""

TRIED = 24
"""Number of elements outside the crosses that are computed for each error estimate."""

_RANK = 1e-9
"""Singular values below this fraction of the largest are treated as rounding errors."""


def complete(
    columns: Pairs, low_m: Array, high_m: Array, tolerance: float, near: Array | None = None
) -> tuple[Array, float]:
    """Return the columns of all pairs of thicknesses.

    Parameters
    ----------
    low_m, high_m : ndarray (E,), (F,)
        Ascending.
    tolerance : float
        Of the total of any band, relative.
    near : ndarray (E, F, K, B), optional
        Columns that differ little, such as those of fewer streams: the difference has a lower rank.

    Returns
    -------
    ndarray (E, F, K, B)
        Computed in the crosses, completed elsewhere.
    float
        Largest relative error of the total among the elements tested last; 0 if all were computed.
    """
    size = low_m.size, high_m.size
    rows, across = (_first(count, FIRST_CROSSES if near is None else FIRST_CROSSES_NEAR) for count in size)
    by_row = {row: _line(columns, low_m[row : row + 1], high_m) for row in rows}
    by_column = {column: _line(columns, low_m, high_m[column : column + 1]) for column in across}
    start = 0
    while True:
        completed = _skeleton(by_row, by_column, near)
        tried = _elsewhere(size, by_row, by_column, start)
        if tried is None or len(by_row) >= min(size):
            return _line_by_line(columns, by_row, low_m, high_m), 0.0
        start += TRIED
        exact = columns(np.stack((low_m[tried[0]], high_m[tried[1]]), axis=1))
        total = np.sum(exact, axis=1)
        guess = np.sum(completed[tried], axis=1)
        error = np.max(np.abs(guess - total) / np.maximum(np.abs(total), np.finfo(float).tiny), axis=1)
        worst = int(np.argmax(error))
        if error[worst] <= 0.5 * tolerance:
            return completed, float(error[worst])
        row, column = int(tried[0][worst]), int(tried[1][worst])
        by_row.setdefault(row, _line(columns, low_m[row : row + 1], high_m))
        by_column.setdefault(column, _line(columns, low_m, high_m[column : column + 1]))


def _first(size: int, count: int) -> list[int]:
    return sorted(set(np.linspace(0, size - 1, count).round().astype(int).tolist()))


def _line(columns: Pairs, low_m: Array, high_m: Array) -> Array:
    """Columns (N, K, B) of one row or one column of the product."""
    return columns(np.stack(np.broadcast_arrays(low_m, high_m), axis=1))


def _line_by_line(columns: Pairs, by_row: dict[int, Array], low_m: Array, high_m: Array) -> Array:
    """Compute every missing row."""
    return np.stack(
        [by_row[row] if row in by_row else _line(columns, low_m[row : row + 1], high_m) for row in range(low_m.size)]
    )


def _skeleton(by_row: dict[int, Array], by_column: dict[int, Array], near: Array | None) -> Array:
    """Complete the product, or its difference from one that is near, from its crosses, which remain unchanged."""
    rows, across = sorted(by_row), sorted(by_column)
    lines = np.stack([by_row[row] for row in rows])  # (I, F, K, B)
    columns = np.stack([by_column[column] for column in across], axis=1)  # (E, J, K, B)
    # A term that approaches zero (the sea under both clouds) would otherwise become negative, which no column is.
    lowest = np.minimum(np.min(lines, axis=(0, 1)), np.min(columns, axis=(0, 1)))
    crosses = (lines, columns) if near is None else (lines - near[rows], columns - near[:, across])
    centre = np.moveaxis(crosses[0][:, across], (0, 1), (-2, -1))  # (K, B, I, J)
    inverse = np.linalg.pinv(centre, rcond=_RANK)
    completed: Array = np.einsum("ejkb,kbji,ifkb->efkb", crosses[1], inverse, crosses[0], optimize=True)
    if near is not None:
        completed += near
    np.maximum(completed, np.minimum(lowest, 0.0), out=completed)
    for index, column in enumerate(across):
        completed[:, column] = columns[:, index]
    for index, row in enumerate(rows):
        completed[row] = lines[index]
    return completed


def _elsewhere(
    size: tuple[int, int], by_row: dict[int, Array], by_column: dict[int, Array], start: int
) -> tuple[NDArray[np.intp], NDArray[np.intp]] | None:
    """Indices of some elements outside the crosses, spread over the product; None if there are too few."""
    free = [np.setdiff1d(np.arange(n), list(known)) for n, known in zip(size, (by_row, by_column), strict=True)]
    if free[0].size * free[1].size <= 2 * TRIED:
        return None
    # Kronecker sequence of powers of the plastic number: evenly distributed, without repetition.
    number = np.arange(start, start + TRIED) + 1.0
    share = np.mod(number[:, None] * np.array([0.7548776662466927, 0.5698402909980532]), 1.0)
    places = [indices[(share[:, axis] * indices.size).astype(int)] for axis, indices in enumerate(free)]
    return places[0], places[1]


CROSS_SHARE = 0.2
"""Share of the tolerance for the completion of the product from crosses."""

PROBES = (0.0, 0.5)
"""Positions among the other layer's nodes at which an axis is tested: its thickest clouds hide more than they add."""

ROWS_AT_ONCE = 64
"""Number of rows of the dense table that are interpolated together."""


@dataclass(frozen=True)
class LayerPair:
    """Thickness axes of two layers whose product is the table of columns with cloud in both.

    Attributes
    ----------
    low, high : ThicknessAxis
        Axes of the lower and of the higher layer.
    cross_tolerance : float
        Allowed relative error of the total due to completing the product from crosses.
    estimated_error : float
        Relative error of the total: the largest measured between exact nodes of both axes, plus the shares of the
        tolerance for dense nodes and crosses.
    """

    low: ThicknessAxis
    high: ThicknessAxis
    cross_tolerance: float
    estimated_error: float

    def exact(self, columns: ColumnsAt, near: Array | None = None) -> Array:
        """Terms of the columns of all pairs of exact nodes (E, F, K, B), computed for some of them."""
        return complete(columns, self.low.exact_m, self.high.exact_m, self.cross_tolerance, near)[0]

    def dense(self, exact: Array, named: Callable[[Array], Array]) -> NDArray[np.float32]:
        """Interpolate exact columns onto all pairs of dense nodes.

        Parameters
        ----------
        exact : ndarray (E, F, K, B)
            Result of :meth:`exact`.
        named : callable
            Maps terms (..., K, B) to the requested quantities (..., Q, B).

        Returns
        -------
        ndarray (N, M, Q x B)
            Single precision, to halve the memory; the cube has the same rounding.
        """
        across = np.moveaxis(self.high.interpolate(np.moveaxis(exact, 1, 0)), 0, 1)
        table: NDArray[np.float32] | None = None
        row = 0
        for index, (segment, nodes) in enumerate(zip(self.low.segments, self.low.places, strict=True)):
            curve, dense = curve_through(segment, across[nodes]), np.log(self.low.dense_of(index))
            for start in range(0, dense.size, ROWS_AT_ONCE):
                quantities = named(curve(dense[start : start + ROWS_AT_ONCE]))
                rows, columns = quantities.shape[:2]
                flat = quantities.reshape(rows, columns, -1)
                if table is None:
                    table = np.empty((self.low.dense_m.size, columns, flat.shape[2]), dtype=np.float32)
                table[row : row + rows] = flat
                row += rows
        assert table is not None
        return table


def place_pair(
    columns: ColumnsAt,
    low: ThicknessAxis,
    high: ThicknessAxis,
    tolerance: float,
    source: Source,
    layers: tuple[CloudLayer, ...],
) -> LayerPair:
    """Add nodes to the axes of two layers until columns with both meet the tolerance.

    Parameters
    ----------
    columns : callable
        Maps pairs of thicknesses (N, 2), low and high, to terms (N, K, B).
    low, high : ThicknessAxis
        Axes of the single layers; the new axes include all their nodes.
    tolerance : float
        Relative to the total; a fifth of it for the crosses, and half of the rest for each axis.
    source : Source
        Radiance model and terms, for error messages.
    layers : tuple of CloudLayer
        The low and the high layer.

    Raises
    ------
    ProviderError
        If the radiance does not converge with the number of nodes, because a provider returns discontinuous values.
    """
    axes, share = [low, high], 0.5 * (1.0 - CROSS_SHARE) * tolerance
    while True:
        values, _ = complete(columns, axes[0].exact_m, axes[1].exact_m, CROSS_SHARE * tolerance)
        misfits = [_misfits(columns, axes, values, which) for which in (0, 1)]
        errors = [[misfit.error for misfit in of_axis] for of_axis in misfits]
        coarse = [[error > (1 - LINEAR_SHARE) * share for error in of_axis] for of_axis in errors]
        if not any(map(any, coarse)):
            break
        axes = [_halved(axis, too_coarse) for axis, too_coarse in zip(axes, coarse, strict=True)]
        if max(axis.exact_m.size for axis in axes) > MAX_NODES:
            which = int(axes[1].exact_m.size > MAX_NODES)
            most = max(misfits[which], key=lambda misfit: misfit.error)
            raise jumping(
                f"radiance as a function of two layer thicknesses does not converge to {tolerance:g} with "
                f"{MAX_NODES} columns along one dimension (error {most.error:.2g})",
                source,
                layers[which],
                most.thickness_m,
                most.where,
            )
    placed = [
        _with_dense_nodes(axis, np.moveaxis(values, which, 0), LINEAR_SHARE * share) for which, axis in enumerate(axes)
    ]
    largest = sum(max(of_axis) for of_axis in errors)
    cross = CROSS_SHARE * tolerance
    return LayerPair(placed[0], placed[1], cross, largest + 2.0 * LINEAR_SHARE * share + cross)


@dataclass(frozen=True)
class _Misfit:
    """Largest relative error of the total in the middle of the intervals of a segment, and where."""

    error: float
    thickness_m: Array
    where: tuple[int, int]


def _misfits(columns: ColumnsAt, axes: list[ThicknessAxis], values: Array, which: int) -> list[_Misfit]:
    """Compare each segment of one axis with columns in the middle of its intervals."""
    axis, other = axes[which], axes[1 - which].exact_m
    probes = np.unique((np.array(PROBES) * (other.size - 1)).round().astype(int))
    along = np.moveaxis(values, which, 0)[:, probes]
    misfits = []
    for segment, nodes in zip(axis.segments, axis.places, strict=True):
        middle = np.sqrt(segment[:-1]) * np.sqrt(segment[1:])
        pairs = np.stack(np.meshgrid(middle, other[probes], indexing="ij"), axis=-1).reshape(-1, 2)
        computed = columns(pairs if which == 0 else pairs[:, ::-1])
        exact = computed.reshape(middle.size, probes.size, *computed.shape[1:])
        guess = curve_through(segment, along[nodes])(np.log(middle))
        error = largest_error(np.sum(guess, axis=2), np.sum(exact, axis=2))
        as_bands = (np.moveaxis(terms, 1, 2).reshape(middle.size, terms.shape[2], -1) for terms in (guess, exact))
        misfits.append(_Misfit(error, middle, worst(*as_bands)))
    return misfits


def _halved(axis: ThicknessAxis, coarse: list[bool]) -> ThicknessAxis:
    """Halve all intervals of the segments that are too coarse."""
    segments = tuple(
        np.sort(np.concatenate((segment, np.sqrt(segment[:-1]) * np.sqrt(segment[1:])))) if too_coarse else segment
        for segment, too_coarse in zip(axis.segments, coarse, strict=True)
    )
    return replace(axis, segments=segments)


def _with_dense_nodes(axis: ThicknessAxis, along: Array, tolerance: float) -> ThicknessAxis:
    """Add the dense nodes that columns with both layers need; ``along`` (E, F, K, B) has this axis first."""
    as_bands = np.moveaxis(along, 1, 2).reshape(along.shape[0], along.shape[2], -1)
    dense = [
        dense_nodes(segment, as_bands[nodes], tolerance)
        for segment, nodes in zip(axis.segments, axis.places, strict=True)
    ]
    return replace(axis, dense_m=np.unique(np.concatenate((axis.dense_m, *dense))))
