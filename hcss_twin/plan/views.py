"""The directions of view for which a scene has tables, and what each counts in a pixel.

Radiance of one column is a smooth function of where in the image it lies. It is known at Chebyshev's nodes of x and of
y, from edge to edge of the image; a pixel has the value of the polynomial through them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.physics import quadrature
from hcss_twin.physics.viewing import LinesOfSight
from hcss_twin.providers import Grid, View


@dataclass(frozen=True)
class ViewAxis:
    """Nodes over the image.

    Attributes
    ----------
    order_x, order_y : int
        Of the polynomial along columns and rows; 0: the view along the middle stands for all.
    estimated_error : float
        Relative to the total, measured between the nodes while they were placed.
    """

    order_x: int
    order_y: int
    estimated_error: float

    @property
    def places(self) -> tuple[tuple[float, float], ...]:
        """Places (x, y) of the nodes, -1 to 1 from edge to edge; x runs first."""
        x, y = quadrature.nodes(self.order_x).tolist(), quadrature.nodes(self.order_y).tolist()
        return tuple((across, up) for up in y for across in x)

    def weights(self, grid: Grid) -> tuple[Array, Array]:
        """Return what each node counts: (columns, X) along x and (rows, Y) along y."""
        return (
            quadrature.weights(self.order_x, _centres(grid.columns)),
            quadrature.weights(self.order_y, _centres(grid.rows)),
        )


@dataclass(frozen=True)
class ImageViews:
    """The view from any place of an image.

    Attributes
    ----------
    grid : Grid
        The image, in pixels.
    lines : LinesOfSight
    """

    grid: Grid
    lines: LinesOfSight

    def at(self, places: Iterable[tuple[float, float]]) -> list[View]:
        """Return the view from places (x, y), -1 to 1 from edge to edge.

        Azimuths are counted from the plane's y axis, as those of sun and wind at the image centre are.
        """
        x, y = np.array(list(places), dtype=np.float64).reshape(-1, 2).T
        size = 0.5 * self.grid.pixel_size_m
        seen = self.lines.from_points(x * size * self.grid.columns, y * size * self.grid.rows)
        return [
            View(zenith, azimuth)
            for zenith, azimuth in zip(seen.zenith_deg.tolist(), seen.plane_azimuth_deg.tolist(), strict=True)
        ]

    def of_pixels(self, row: Sequence[int], column: Sequence[int]) -> list[View]:
        """Return the view from the centres of pixels."""
        x, y = _centres(self.grid.columns)[list(column)], _centres(self.grid.rows)[list(row)]
        return self.at(zip(x.tolist(), y.tolist(), strict=True))


Values = Callable[[float, float], Array]
"""Radiance (N, K, B) of columns by term, seen from a place (x, y) of the image."""

LINES = (-1.0, 0.0, 1.0)
"""Of the other axis, along which nodes are tried: the edges and the middle of the image."""


EVERYWHERE = 129
"""Places at which polynomials are compared."""


def place_axis(values: Values, along_x: bool, tolerance: float, most: int) -> tuple[int, float]:
    """Double the order along one axis until halfway places agree with the polynomial, and take fewer if these do.

    Parameters
    ----------
    tolerance : float
        Relative to the total; of every term.
    most : int
        Largest order; what is found with it may exceed the tolerance.

    Returns
    -------
    order : int
    error : float
        The largest found between its nodes.
    """

    def along(line: float, places: Array) -> Array:
        return np.stack([values(*((place, line) if along_x else (line, place))) for place in places.tolist()])

    order = 0
    while True:
        halfway = quadrature.between(order)
        weights = quadrature.weights(order, halfway)
        error = max(
            difference(np.tensordot(weights, along(line, quadrature.nodes(order)), 1), along(line, halfway))
            for line in LINES
        )
        if error <= tolerance or order >= most:
            break
        order = 2 * order or 1
    if error > tolerance or order < 4:
        return order, error
    known = [along(line, quadrature.nodes(2 * order)) for line in LINES]
    for fewer in range(order // 2 + 1, order):
        more = max(_lost(values, fewer) for values in known)
        if error + more <= tolerance:
            return fewer, error + more
    return order, error


def _lost(values: Array, order: int) -> float:
    """Greatest difference between the polynomial through values (n, ...) at nodes and one of fewer nodes."""
    everywhere = np.linspace(-1.0, 1.0, EVERYWHERE)
    finest = values.shape[0] - 1
    few = np.tensordot(quadrature.weights(finest, quadrature.nodes(order)), values, 1)
    guess = np.tensordot(quadrature.weights(order, everywhere), few, 1)
    return difference(guess, np.tensordot(quadrature.weights(finest, everywhere), values, 1))


def difference(guess: Array, exact: Array) -> float:
    """Greatest difference of totals and terms (..., K, B), relative to the total."""
    total = np.sum(exact, axis=-2, keepdims=True)
    off = np.maximum(
        np.max(np.abs(guess - exact), axis=-2, keepdims=True), np.abs(np.sum(guess, axis=-2, keepdims=True) - total)
    )
    return float(np.max(np.divide(off, total, out=np.zeros_like(off), where=total > 0.0), initial=0.0))


def _centres(count: int) -> Array:
    """Places of pixel centres along one axis."""
    return (2.0 * np.arange(count) + 1.0 - count) / count
