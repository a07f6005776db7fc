"""Thickness axis of the radiance tables: exact columns, polynomials between them, and nodes of the linear look-up.

Radiance as a function of thickness is smooth except where the moving face of the cloud crosses a level of the
profile. Between two such breakpoints a polynomial in ln(thickness) through few exact columns meets the tolerance; it is
then sampled densely for linear look-up in each pixel. Each term of the radiance is interpolated; the total is their
sum.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.error_norm import TERM_TOLERANCE
from hcss_twin.core.errors import ProviderError
from hcss_twin.physics import quadrature
from hcss_twin.plan.axis import ORDERS, Axis, PlacedAxis, place, through
from hcss_twin.providers import CloudLayer


@dataclass(frozen=True)
class Source:
    """Radiance model of the tabulated columns.

    Attributes
    ----------
    model : str
        Name of the radiance model in messages.
    terms : tuple of str (K,)
        Names of its terms, in the order of the columns' second last axis.
    """

    model: str
    terms: tuple[str, ...]


ColumnsAt = Callable[[Array], Array]
"""Maps thicknesses (N,) to terms (N, ..., K, B)."""

MOST_NODES = 1025

MOST_TESTED = 6
"""Columns between the nodes of a segment that test its polynomial."""

COARSE_TOLERANCE, ORDERS_ACROSS = 5e-4, (4, 8)
"""Tolerance from which on polynomials of these orders are tried across kinks first: where the cloud's face crosses a
level, radiance bends by less in most profiles."""

LINEAR_SHARE = 0.25
"""Share of the tolerance for the linear look-up; the rest is for the polynomials."""


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
        return self._placed.nodes

    @property
    def _placed(self) -> PlacedAxis:
        ends = [float(segment[0]) for segment in self.segments]
        return PlacedAxis(_of_thickness(ends[0], float(self.segments[-1][-1]), ends[1:]), self.segments)

    def linear(self, values: Array) -> Array:
        """Interpolate values at ``exact_m``, (E, ...), onto the dense nodes, (N, ...): a linear map."""
        return self._placed.interpolate(values, self.dense_m)

    def interpolate(self, values: Array) -> Array:
        """Interpolate radiance, which does not become negative where it approaches zero."""
        found: Array = np.maximum(self.linear(values), np.minimum(np.min(values, axis=0), 0.0))
        return found


def _of_thickness(low_m: float, high_m: float, kinks_m: Sequence[float]) -> Axis:
    return Axis(low_m, high_m, kinks_m, np.log, ratios=True)


def axis_of(layer: CloudLayer, level_m: Array) -> Axis:
    """Return the range of a layer's thickness, which has kinks where the cloud's moving face crosses a level (m)."""
    low, high = layer.thickness_min_m, layer.thickness_max_m
    # All clouds may have nearly the same thickness; an axis needs some width.
    low = min(low, high * (1 - 1e-6))
    crossing = level_m - layer.base_m if layer.anchor == "base" else layer.top_m - level_m[::-1]
    return _of_thickness(low, high, crossing[(crossing > low * 1.001) & (crossing < high * 0.999)].tolist())


def first_nodes(layer: CloudLayer, level_m: Array, tolerance: float) -> Array:
    """Return the thicknesses (N,) of the columns for which the first segment of a layer's axis is tried."""
    axis = axis_of(layer, level_m)
    end = -1 if _across_kinks(tolerance) else 1
    return axis.within(float(axis.ends[0]), float(axis.ends[end]), quadrature.nodes(ORDERS[0]))


def _across_kinks(tolerance: float) -> bool:
    return (1 - LINEAR_SHARE) * tolerance >= COARSE_TOLERANCE


def place_thickness(
    columns: ColumnsAt, layer: CloudLayer, level_m: Array, tolerance: float, source: Source, fewest: bool = False
) -> ThicknessAxis:
    """Place nodes so that the total and the terms meet the tolerance, measured between the nodes.

    Parameters
    ----------
    columns : callable
        Maps thicknesses (N,) to terms (N, ..., K, B).
    level_m : ndarray
        Altitudes at which the profile has kinks.
    tolerance : float
        Relative to the total.
    source : Source
        Radiance model and terms, for error messages.
    fewest : bool
        Whether other columns than these are computed at the nodes.

    Raises
    ------
    ProviderError
        If the radiance does not converge with the number of nodes, because a provider returns discontinuous values.
    """
    known = dict[float, Array]()

    def kept(thickness_m: Array) -> Array:
        values = columns(thickness_m)
        known.update(zip(thickness_m.tolist(), values, strict=True))
        return values

    allowed = (1 - LINEAR_SHARE) * tolerance
    # With one layer columns of the default model are dear, and few of them tell whether a polynomial follows.
    tests = MOST_NODES if fewest else MOST_TESTED
    axis = axis_of(layer, level_m)
    trial = partial(place, columns=kept, tolerance=allowed, most_tested=tests, curve=not_below_zero, fewest=fewest)
    placed = None
    if _across_kinks(tolerance):
        placed = trial(axis, orders=ORDERS_ACROSS, cut="never")
    if placed is None or placed.missed is not None:
        placed = trial(axis, most=MOST_NODES)
    if placed.missed is not None:
        raise _jumping(placed, allowed, layer, source)
    new = np.array([thickness for thickness in placed.nodes.tolist() if thickness not in known])
    if new.size:
        kept(new)
    exact = np.stack([known[thickness] for thickness in placed.nodes.tolist()])
    dense = [
        _dense_nodes(placed, segment, exact[placed.slice_of(segment)], LINEAR_SHARE * tolerance)
        for segment in range(len(placed.segments))
    ]
    return ThicknessAxis(placed.segments, np.unique(np.concatenate(dense)), placed.error + LINEAR_SHARE * tolerance)


def not_below_zero(of_nodes: Array, weights: Array) -> Array:
    """Return columns between nodes; a term that approaches zero does not become negative.

    The polynomial of the sea under a thick cloud would, by less than the tolerance, although exact columns do not.
    """
    columns: Array = np.maximum(through(of_nodes, weights), np.minimum(np.min(of_nodes, axis=0), 0.0))
    return columns


def _jumping(placed: PlacedAxis, allowed: float, layer: CloudLayer, source: Source) -> ProviderError:
    """Return the exception for radiance that does not converge."""
    assert placed.missed is not None
    thickness_m, guess, exact = placed.missed
    whole = np.maximum(np.abs(np.sum(exact, axis=-2)), np.finfo(float).tiny)
    away = np.abs(np.sum(guess - exact, axis=-2)) / whole
    where = [int(index) for index in np.unravel_index(np.argmax(away), away.shape)]
    term = int(np.argmax(np.abs(np.moveaxis(guess - exact, -2, -1))[tuple(where)]))
    at = float(thickness_m[where[0]])
    face, moving = (layer.base_m + at, "top") if layer.anchor == "base" else (layer.top_m - at, "base")
    ends = [*placed.axis.kinks, placed.axis.high]
    high = next(end for end in ends if at <= end)
    low = max(end for end in (placed.axis.low, *placed.axis.kinks) if end < at)
    return ProviderError(
        f"radiance against cloud thickness between {low:g} and {high:g} m does not converge to {allowed:g} with "
        f"{placed.nodes.size} columns (error {placed.error:.2g}): term '{source.terms[term]}' of {source.model} seems "
        f"to jump near {at:.6g} m ({moving} of layer '{layer.name}' at {face:.6g} m); it must be continuous, and so "
        "must its inputs from other providers"
    )


def _dense_nodes(placed: PlacedAxis, segment: int, values: Array, tolerance: float) -> Array:
    """Halve intervals of the linear look-up where it deviates from the curve through ``values`` (n, ..., K, B).

    Returns
    -------
    ndarray (D,)
        Old and new nodes.
    """

    def curve(thickness_m: Array) -> Array:
        terms = not_below_zero(values, placed.weights(segment, thickness_m))
        return np.concatenate((np.sum(terms, axis=-2, keepdims=True), terms / TERM_TOLERANCE), axis=-2)

    dense = placed.segments[segment]
    suspect = np.ones(dense.size - 1, dtype=bool)
    while np.any(suspect):
        left = np.flatnonzero(suspect)
        middle = 0.5 * (dense[left] + dense[left + 1])
        ends, exact = [curve(dense[left + end]) for end in (0, 1)], curve(middle)
        # Not divided by the exact total, which may be 0 if terms are omitted.
        away = np.abs(0.5 * (ends[0] + ends[1]) - exact) > tolerance * np.abs(exact[..., :1, :])
        coarse = np.any(away.reshape(middle.size, -1), axis=1)
        position = left[coarse] + 1
        dense = np.insert(dense, position, middle[coarse])
        suspect = np.zeros(dense.size - 1, dtype=bool)
        inserted = position + np.arange(position.size)
        suspect[inserted - 1] = True
        suspect[inserted] = True
    return dense
