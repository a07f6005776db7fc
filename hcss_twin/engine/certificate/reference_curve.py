"""Reference terms as curves over the thickness of one layer, for sweeps whose points differ in their clouds only.

Each point has pixels of its own, but all their columns lie on one curve for each layer and position of the sun. The
curve is a Chebyshev series through reference columns, which share nothing with the tables but the altitudes where the
profile has kinks; columns between its nodes, of the same solution, measure its error.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.polynomial import chebyshev

from hcss_twin.core.arrays import Array
from hcss_twin.core.error_norm import largest_error
from hcss_twin.engine.tables.thickness_axis import breakpoints, total
from hcss_twin.providers import CloudLayer

NODES_PER_E_FOLD = 7.0
"""Nodes for a change of thickness by a factor e: emissivity changes from 0 to 1 within two or three of these."""

FEWEST_NODES = 5
TRIES = 3
"""The number of nodes is doubled after each try but the last."""

NODES_PER_CHECK = 4
"""Nodes of a segment for each column that checks it."""

_GOLDEN = 0.6180339887498949
"""Multiples of it, modulo 1, never come close to the nodes all at once."""

ColumnsAt = Callable[[Array], Array]
"""Maps thicknesses (N,) of the layer to terms (N, K, B)."""


@dataclass(frozen=True)
class ReferenceCurve:
    """Reference terms of one layer alone.

    Attributes
    ----------
    ends_m : ndarray (S + 1,)
        Ends of the smooth segments.
    coefficients : tuple of ndarray (N, K, B)
        Of Chebyshev polynomials of ln(thickness) in each segment.
    columns : int
        Number of columns solved for the curve, those that check it included.
    error : float
        Largest error of the checking columns relative to their total.
    """

    ends_m: Array
    coefficients: tuple[Array, ...]
    columns: int
    error: float

    def terms(self, thickness_m: Array) -> Array:
        """Return terms (N, K, B) of columns (N,) within the thickness limits of the layer."""
        segment = np.clip(np.searchsorted(self.ends_m, thickness_m) - 1, 0, len(self.coefficients) - 1)
        result = np.empty((thickness_m.size, *self.coefficients[0].shape[1:]))
        for index, coefficient in enumerate(self.coefficients):
            inside = segment == index
            if np.any(inside):
                position = _position(thickness_m[inside], self.ends_m[index], self.ends_m[index + 1])
                result[inside] = np.moveaxis(chebyshev.chebval(position, coefficient), -1, 0)
        return result


def reference_curve(columns: ColumnsAt, layer: CloudLayer, level_m: Array, tolerance: float) -> ReferenceCurve | None:
    """Return the curve of a layer, or None if it does not reach the tolerance relative to the total.

    Parameters
    ----------
    columns : callable
    level_m : ndarray
        Altitudes at which the profile has kinks.
    """
    ends = np.array(breakpoints(layer, level_m))
    for attempt in range(TRIES):
        segments = [_nodes_and_checks(low, high, 2**attempt) for low, high in pairwise(ends.tolist())]
        thickness = np.concatenate([thicknesses for segment in segments for thicknesses in segment])
        values = np.split(
            columns(thickness), np.cumsum([thicknesses.size for segment in segments for thicknesses in segment])[:-1]
        )
        coefficients = tuple(
            _series(_position(nodes, low, high), value)
            for (nodes, _), value, (low, high) in zip(segments, values[::2], pairwise(ends.tolist()), strict=True)
        )
        curve = ReferenceCurve(ends, coefficients, thickness.size, 0.0)
        checks = np.concatenate([checks for _, checks in segments])
        error = largest_error(total(curve.terms(checks)), total(np.concatenate(values[1::2])))
        if error <= tolerance:
            return ReferenceCurve(ends, coefficients, thickness.size, error)
    return None


def _nodes_and_checks(low_m: float, high_m: float, times: int) -> tuple[Array, Array]:
    """Return the thicknesses of a segment's nodes, and of columns between them."""
    width = np.log(high_m / low_m)
    count = times * max(int(np.ceil(NODES_PER_E_FOLD * width)), FEWEST_NODES)
    share = (1.0 + np.arange(-(-count // NODES_PER_CHECK))) * _GOLDEN % 1.0
    nodes, checks = (
        low_m * np.exp(0.5 * width * (1.0 + position))
        for position in (chebyshev.chebpts1(count), np.cos(np.pi * share))
    )
    return nodes, checks


def _series(position: Array, values: Array) -> Array:
    """Return the Chebyshev coefficients (N, K, B) of the polynomial through values (N, K, B)."""
    vandermonde = chebyshev.chebvander(position, position.size - 1)
    series = np.linalg.solve(vandermonde, values.reshape(position.size, -1))
    return np.asarray(series.reshape(values.shape), dtype=np.float64)


def _position(thickness_m: Array, low_m: float, high_m: float) -> Array:
    """Return the position between -1 and 1 of thicknesses within a segment."""
    position: Array = 2.0 * np.log(thickness_m / low_m) / np.log(high_m / low_m) - 1.0
    return position
