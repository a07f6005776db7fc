"""Thickness axis of the radiance tables: exact columns, splines between them, and nodes of the linear look-up.

Radiance as a function of thickness is smooth except where the moving face of the cloud crosses a level of the
profile. Between two such breakpoints a spline of degree 5 in ln(thickness) through few exact columns meets the
tolerance; it is then sampled densely for linear look-up in each pixel. Each term of the radiance is interpolated; the
total is their sum.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.error_norm import largest_error
from hcss_twin.core.errors import ProviderError
from hcss_twin.providers import CloudLayer

TERM_TOLERANCE = 10.0
"""Tolerance of terms over that of their total, which is a tenth of the accuracy: other errors of terms are small."""


@dataclass(frozen=True)
class Source:
    """Radiance model of the tabulated columns.

    Attributes
    ----------
    model : str
        Name of the radiance model in messages.
    terms : tuple of str (K,)
        Names of its terms, in the order of the columns' second axis.
    """

    model: str
    terms: tuple[str, ...]


def worst(guess: Array, exact: Array) -> tuple[int, int]:
    """Return column and term of the largest error relative to the total; both arguments are (N, K, B)."""
    whole = np.maximum(np.abs(np.sum(exact, axis=1)), np.finfo(float).tiny)
    away = np.abs(np.sum(guess - exact, axis=1)) / whole
    column, band = np.unravel_index(np.argmax(away), away.shape)
    return int(column), int(np.argmax(np.abs(guess - exact)[column, :, band]))


def jumping(what: str, source: Source, layer: CloudLayer, thickness_m: Array, where: tuple[int, int]) -> ProviderError:
    """Return the exception for radiance that does not converge.

    Parameters
    ----------
    what : str
        Text that describes the failed convergence.
    layer : CloudLayer
        The layer with varying thickness.
    thickness_m : ndarray (N,)
        Thicknesses of the columns tested last.
    where : (int, int)
        Result of :func:`worst`.
    """
    column, term = where
    at = float(thickness_m[column])
    face = layer.base_m + at if layer.anchor == "base" else layer.top_m - at
    moving = "top" if layer.anchor == "base" else "base"
    return ProviderError(
        f"{what}: term '{source.terms[term]}' of {source.model} seems to jump near {at:.6g} m ({moving} of layer "
        f"'{layer.name}' at {face:.6g} m); it must be continuous, and so must its inputs from other providers"
    )


DEGREE = 5
"""For errors of 1e-3 a cubic needs twice as many expensive exact columns; between two levels radiance is smooth."""


def spline_through(thickness_m: Array, values: Array) -> Callable[[Array], Array]:
    """Spline through values at some thicknesses.

    Parameters
    ----------
    thickness_m : ndarray (N,)
        Ascending, above 0, m; up to ``DEGREE`` + 1 of them give the polynomial through all.
    values : ndarray (N, ...)

    Returns
    -------
    callable
        Maps ln(thickness) (M,) to (M, ...).
    """
    ln_nodes = np.log(thickness_m)
    degree = min(DEGREE, ln_nodes.size - 1)
    within = (
        ln_nodes[(degree + 1) // 2 : ln_nodes.size - (degree + 1) // 2] if ln_nodes.size > DEGREE + 1 else ln_nodes[:0]
    )
    knots = np.concatenate((np.repeat(ln_nodes[0], degree + 1), within, np.repeat(ln_nodes[-1], degree + 1)))
    # scipy's splines would bring the import of all its solvers, .4 s, into every compilation.
    coefficients = np.linalg.solve(_splines(knots, degree, ln_nodes), values.reshape(ln_nodes.size, -1))

    def evaluate(ln_thickness: Array) -> Array:
        result: Array = _splines(knots, degree, ln_thickness) @ coefficients
        return result.reshape(-1, *values.shape[1:])

    return evaluate


def _splines(knots: Array, degree: int, x: Array) -> Array:
    """Return the B-splines (M, N) of a degree at ``x`` (M,), continued beyond the ends.

    Recursion after M. G. Cox, J. Inst. Maths Applics 10, 134-149 (1972), and C. de Boor, J. Approx. Theory 6, 50-62
    (1972).
    """
    count = knots.size - degree - 1
    cell = np.clip(np.searchsorted(knots, x, side="right") - 1, degree, count - 1)[:, None]
    basis = np.ones((x.size, 1))
    for order in range(1, degree + 1):
        places = cell + np.arange(1, order + 1)
        left, right = knots[places - order], knots[places]
        share = basis / (right - left)
        basis = np.pad((right - x[:, None]) * share, ((0, 0), (0, 1)))
        basis[:, 1:] += (x[:, None] - left) * share
    result = np.zeros((x.size, count))
    np.put_along_axis(result, cell + np.arange(-degree, 1), basis, axis=1)
    return result


def curve_through(thickness_m: Array, values: Array) -> Callable[[Array], Array]:
    """Return :func:`spline_through` the values (N, ...) that does not undershoot zero.

    A term that approaches zero (the sea under a thick cloud) would otherwise become negative by less than the
    tolerance, although its exact columns do not.
    """
    spline = spline_through(thickness_m, values)
    floor = np.minimum(np.min(values, axis=0), 0.0)

    def evaluate(ln_thickness: Array) -> Array:
        result: Array = np.maximum(spline(ln_thickness), floor)
        return result

    return evaluate


ColumnsAt = Callable[[Array], Array]
"""Maps thicknesses (N,) to terms (N, K, B)."""

FIRST_NODES = 5
MAX_NODES = 4097
LINEAR_SHARE = 0.25
"""Share of the tolerance for the linear look-up; the rest is for the curve's errors at midpoints."""


@dataclass(frozen=True)
class ThicknessAxis:
    """Exact nodes of each smooth segment, and the dense nodes of the look-up.

    Attributes
    ----------
    segments : tuple of ndarray
        Thickness of the exact columns, m; neighbouring segments share an end.
    dense_m : ndarray (N,)
        Nodes of the linear look-up.
    estimated_error : float
        Relative error of the total: the largest measured between exact nodes during placement, plus the share of the
        tolerance for the dense nodes.
    """

    segments: tuple[Array, ...]
    dense_m: Array
    estimated_error: float

    @property
    def exact_m(self) -> Array:
        """Nodes of all segments, each once."""
        return np.concatenate([self.segments[0], *(segment[1:] for segment in self.segments[1:])])

    @property
    def places(self) -> tuple[slice, ...]:
        """Position of each segment's nodes in ``exact_m``."""
        first = np.cumsum([0, *(segment.size - 1 for segment in self.segments)])
        return tuple(
            slice(int(start), int(start) + segment.size) for start, segment in zip(first, self.segments, strict=False)
        )

    def interpolate(self, values: Array) -> Array:
        """Interpolate values at ``exact_m``, (E, ...), onto the dense nodes, (N, ...)."""
        return np.concatenate(
            [
                curve_through(segment, values[nodes])(np.log(self.dense_of(index)))
                for index, (segment, nodes) in enumerate(zip(self.segments, self.places, strict=True))
            ]
        )

    def dense_of(self, index: int) -> Array:
        """Dense nodes of one segment; a shared end belongs to the lower segment."""
        segment = self.segments[index]
        first = self.dense_m > segment[0] if index else self.dense_m >= segment[0]
        dense: Array = self.dense_m[first & (self.dense_m <= segment[-1])]
        return dense


def place_axis(
    columns: ColumnsAt, layer: CloudLayer, level_m: Array, tolerance: float, source: Source
) -> ThicknessAxis:
    """Place nodes so that the total and the terms meet the tolerance, measured between the nodes.

    Parameters
    ----------
    columns : callable
        Maps thicknesses (N,) to terms (N, K, B).
    level_m : ndarray
        Altitudes at which the profile has kinks.
    tolerance : float
        Relative to the total.
    source : Source
        Radiance model and terms, for error messages.

    Raises
    ------
    ProviderError
        If the radiance does not converge with the number of nodes, because a provider returns discontinuous values.
    """
    segments, dense, largest = [], [], 0.0
    for low, high in pairwise(breakpoints(layer, level_m)):
        nodes, values, error = _segment(columns, low, high, (1 - LINEAR_SHARE) * tolerance, source, layer)
        segments.append(nodes)
        dense.append(dense_nodes(nodes, values, LINEAR_SHARE * tolerance))
        largest = max(largest, error)
    return ThicknessAxis(tuple(segments), np.unique(np.concatenate(dense)), largest + LINEAR_SHARE * tolerance)


def _segment(
    columns: ColumnsAt, low: float, high: float, tolerance: float, source: Source, layer: CloudLayer
) -> tuple[Array, Array, float]:
    """Halve all intervals of one segment until the curve predicts every new column."""
    nodes = np.geomspace(low, high, FIRST_NODES)
    nodes[0], nodes[-1] = low, high
    middle = _middles(nodes)
    first = columns(np.concatenate((nodes, middle)))  # one call costs less than two
    values, exact = first[: nodes.size], first[nodes.size :]
    while True:
        guess = curve_through(nodes, values)(np.log(middle))
        with_total = total_and_terms(exact)
        error = largest_error(total_and_terms(guess), with_total, with_total[:, :1])
        order = np.argsort(np.concatenate((nodes, middle)))
        nodes = np.concatenate((nodes, middle))[order]
        values = np.concatenate((values, exact))[order]
        if error <= tolerance:
            return nodes, values, error
        if nodes.size >= MAX_NODES:
            raise jumping(
                f"radiance against cloud thickness between {low:g} and {high:g} m does not converge to "
                f"{tolerance:g} with {nodes.size} columns (error {error:.2g})",
                source,
                layer,
                middle,
                worst(guess, exact),
            )
        middle = _middles(nodes)
        exact = columns(middle)


def _middles(nodes: Array) -> Array:
    result: Array = np.sqrt(nodes[:-1]) * np.sqrt(nodes[1:])
    return result


def dense_nodes(nodes: Array, values: Array, tolerance: float) -> Array:
    """Halve intervals of the linear look-up where it deviates from the curve through ``values`` (N, K, B).

    Returns
    -------
    ndarray (D,)
        Old and new nodes.
    """
    curve = curve_through(nodes, values)
    dense = nodes
    suspect = np.ones(dense.size - 1, dtype=bool)
    while np.any(suspect):
        left = np.flatnonzero(suspect)
        middle = 0.5 * (dense[left] + dense[left + 1])
        ends = [total_and_terms(curve(np.log(dense[left + end]))) for end in (0, 1)]
        exact = total_and_terms(curve(np.log(middle)))
        # Not divided by the exact total, which may be 0 if terms are omitted.
        coarse = np.any(np.abs(0.5 * (ends[0] + ends[1]) - exact) > tolerance * np.abs(exact[:, :1]), axis=(1, 2))
        position = left[coarse] + 1
        dense = np.insert(dense, position, middle[coarse])
        suspect = np.zeros(dense.size - 1, dtype=bool)
        inserted = position + np.arange(position.size)
        suspect[inserted - 1] = True
        suspect[inserted] = True
    return dense


def breakpoints(layer: CloudLayer, level_m: Array) -> list[float]:
    """Ends of the thickness range, and thicknesses at which the cloud's moving face crosses a level."""
    low, high = layer.thickness_min_m, layer.thickness_max_m
    # All clouds may have nearly the same thickness; an axis needs some width.
    low = min(low, high * (1 - 1e-6))
    crossing = level_m - layer.base_m if layer.anchor == "base" else layer.top_m - level_m[::-1]
    inner: list[float] = crossing[(crossing > low * 1.001) & (crossing < high * 0.999)].tolist()
    return [low, *inner, high]


def total(terms: Array) -> Array:
    """Sum over terms: (N, K, B) to (N, B)."""
    result: Array = np.sum(terms, axis=1)
    return result


def total_and_terms(terms: Array) -> Array:
    """Return what must meet the tolerance (N, 1 + K, B), from terms (N, K, B): the total, and a tenth of each term.

    Where cloud is as bright as what it hides, terms change and their sum does not. All terms count, so that radiance
    does not depend on those that are written.
    """
    return np.concatenate((total(terms)[:, None], terms / TERM_TOLERANCE), axis=1)
