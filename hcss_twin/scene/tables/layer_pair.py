"""Columns with cloud in two layers: exact ones on the product of two thickness axes, and frames between them.

Along each axis radiance is interpolated as for one layer: by splines in ln(thickness) between the exact
nodes of each smooth segment, and linearly between the dense nodes of the look-up. The axes of the layers
alone are a first guess; seen through another cloud, or above one, a layer can need more nodes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hcss_twin.providers import CloudLayer
from hcss_twin.scene.tables.curve import curve_through
from hcss_twin.scene.tables.jumps import Source, jumping, worst
from hcss_twin.scene.tables.low_rank import complete
from hcss_twin.scene.tables.thickness_axis import (
    LINEAR_SHARE,
    MOST_NODES,
    ColumnsAt,
    ThicknessAxis,
    dense_nodes,
)

Array = NDArray[np.float64]

CROSS_SHARE = 0.2
"""Share of the tolerance left to the completion of the product of both axes from crosses."""

PROBES = (0.0, 0.5)
"""Where along the other layer's nodes an axis is tried: its thickest clouds hide more than they add."""

ROWS_AT_ONCE = 64
"""Rows of the dense table that are interpolated together."""


@dataclass(frozen=True)
class LayerPair:
    """Thickness axes of two layers whose product is the table of columns with cloud in both.

    Attributes
    ----------
    low, high : ThicknessAxis
        Of the lower and of the higher layer.
    cross_tolerance : float
        Relative error of the total that completing the product from crosses may cause.
    estimated_error : float
        Relative error of the total: the largest found between exact nodes of both axes, plus the shares of
        the tolerance that the dense nodes and the crosses use.
    """

    low: ThicknessAxis
    high: ThicknessAxis
    cross_tolerance: float
    estimated_error: float

    def exact(self, columns: ColumnsAt) -> Array:
        """Terms of the columns of all pairs of exact nodes, (E, F, K, B), from some of them."""
        return complete(columns, self.low.exact_m, self.high.exact_m, self.cross_tolerance)[0]

    def dense(self, exact: Array, named: Callable[[Array], Array]) -> NDArray[np.float32]:
        """Interpolate exact columns onto all pairs of dense nodes.

        Parameters
        ----------
        exact : ndarray (E, F, K, B)
            As :meth:`exact` returns them.
        named : callable
            Maps terms (..., K, B) to the quantities wanted, (..., Q, B).

        Returns
        -------
        ndarray (N, M, Q x B)
            Single precision, which halves the memory; its rounding is that of the cube.
        """
        across = np.moveaxis(self.high.interpolate(np.moveaxis(exact, 1, 0)), 0, 1)
        table: NDArray[np.float32] | None = None
        row = 0
        for index, (segment, place) in enumerate(zip(self.low.segments, self.low.places, strict=True)):
            curve, dense = curve_through(segment, across[place]), np.log(self.low.dense_of(index))
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
    """Add nodes to the axes of two layers until columns with both keep the tolerance.

    Parameters
    ----------
    columns : callable
        Maps pairs of thicknesses (N, 2), low and high, to terms (N, K, B).
    low, high : ThicknessAxis
        Axes of the layers alone; the new ones have all their nodes.
    tolerance : float
        Relative to the total; a fifth of it for the crosses, and half of the rest for each axis.
    source : Source
        Who an error names.
    layers : tuple of CloudLayer
        The low and the high one.

    Raises
    ------
    ProviderError
        If the radiance does not converge with nodes, because a provider returns values that jump.
    """
    axes, share = [low, high], 0.5 * (1.0 - CROSS_SHARE) * tolerance
    while True:
        values, _ = complete(columns, axes[0].exact_m, axes[1].exact_m, CROSS_SHARE * tolerance)
        misfits = [_misfits(columns, axes, values, which) for which in (0, 1)]
        errors = [[misfit.error for misfit in each] for each in misfits]
        coarse = [[error > (1 - LINEAR_SHARE) * share for error in each] for each in errors]
        if not any(map(any, coarse)):
            break
        axes = [_halved(axis, too_coarse) for axis, too_coarse in zip(axes, coarse, strict=True)]
        if max(axis.exact_m.size for axis in axes) > MOST_NODES:
            which = int(axes[1].exact_m.size > MOST_NODES)
            most = max(misfits[which], key=lambda misfit: misfit.error)
            raise jumping(
                f"radiance against the thickness of two cloud layers does not converge to {tolerance:g} with "
                f"{MOST_NODES} columns along one of them (error {most.error:.2g})",
                source,
                layers[which],
                most.thickness_m,
                most.place,
            )
    placed = [
        _with_dense_nodes(axis, np.moveaxis(values, which, 0), LINEAR_SHARE * share)
        for which, axis in enumerate(axes)
    ]
    largest = sum(max(each) for each in errors)
    cross = CROSS_SHARE * tolerance
    return LayerPair(placed[0], placed[1], cross, largest + 2.0 * LINEAR_SHARE * share + cross)


@dataclass(frozen=True)
class _Misfit:
    """Largest relative error of the total in the middle of the intervals of a segment, and where."""

    error: float
    thickness_m: Array
    place: tuple[int, int]


def _misfits(columns: ColumnsAt, axes: list[ThicknessAxis], values: Array, which: int) -> list[_Misfit]:
    """Compare each segment of one axis with columns in the middle of its intervals."""
    axis, other = axes[which], axes[1 - which].exact_m
    probes = np.unique((np.array(PROBES) * (other.size - 1)).round().astype(int))
    along = np.moveaxis(values, which, 0)[:, probes]
    misfits = []
    for segment, place in zip(axis.segments, axis.places, strict=True):
        middle = np.sqrt(segment[:-1]) * np.sqrt(segment[1:])
        pairs = np.stack(np.meshgrid(middle, other[probes], indexing="ij"), axis=-1).reshape(-1, 2)
        found = columns(pairs if which == 0 else pairs[:, ::-1])
        exact = found.reshape(middle.size, probes.size, *found.shape[1:])
        guess = curve_through(segment, along[place])(np.log(middle))
        error = float(np.max(np.abs(np.sum(guess, axis=2) / np.sum(exact, axis=2) - 1.0)))
        as_bands = (
            np.moveaxis(each, 1, 2).reshape(middle.size, each.shape[2], -1) for each in (guess, exact)
        )
        misfits.append(_Misfit(error, middle, worst(*as_bands)))
    return misfits


def _halved(axis: ThicknessAxis, coarse: list[bool]) -> ThicknessAxis:
    """Halve all intervals of the segments that are too coarse."""
    segments = tuple(
        np.sort(np.concatenate((segment, np.sqrt(segment[:-1]) * np.sqrt(segment[1:]))))
        if too_coarse
        else segment
        for segment, too_coarse in zip(axis.segments, coarse, strict=True)
    )
    return replace(axis, segments=segments)


def _with_dense_nodes(axis: ThicknessAxis, along: Array, tolerance: float) -> ThicknessAxis:
    """Add the dense nodes that columns with the other layer need; ``along`` (E, F, K, B) has this axis first."""
    as_bands = np.moveaxis(along, 1, 2).reshape(along.shape[0], along.shape[2], -1)
    dense = [
        dense_nodes(segment, as_bands[place], tolerance)
        for segment, place in zip(axis.segments, axis.places, strict=True)
    ]
    return replace(axis, dense_m=np.unique(np.concatenate((axis.dense_m, *dense))))
