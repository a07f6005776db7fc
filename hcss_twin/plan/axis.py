"""Axes of radiance: where nodes must lie on what columns depend on, so that polynomials between them are accurate.

Radiance is smooth in thickness, altitude, temperature, time and direction, except at known kinks. On each segment of an
axis it is a polynomial through Chebyshev points in a coordinate in which it bends little. The order is doubled until
columns halfway between the nodes agree; a segment that no order follows is cut at a kink, or in its middle.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.error_norm import error_of_columns
from hcss_twin.physics import quadrature

Columns = Callable[[Array], Array]
"""Maps values (N,) of what columns depend on to their terms (N, ..., K, B)."""

NARROWEST = 1e-5
"""Relative width of segments that are not cut: where columns jump, there is nothing to interpolate."""

SMALLEST_REDUCED = 4
"""Orders from which on fewer nodes than those of a tried order are looked for."""

ORDERS = (4, 8, 16, 32)
"""Orders that are tried, one after another."""

EVERYWHERE = 129
"""Number of positions at which polynomials are compared."""


Coordinate = Callable[[Array], Array]
"""Maps values (N,) to ascending ones in which radiance is nearly a straight line: (N,), or (B, N) for each band."""


def itself(values: Array) -> Array:
    """Return the values: the coordinate where there is no better one."""
    return values


@dataclass(frozen=True)
class Axis:
    """What columns depend on, in the range of a scene.

    Attributes
    ----------
    low, high : float
        Range of values; high may equal low.
    kinks : sequence of float
        Values within it at which radiance may have kinks, ascending.
    coordinate : Coordinate
    ratios : bool
        Whether halfway between two values, both above 0, is their geometric mean.
    """

    low: float
    high: float
    kinks: Sequence[float] = ()
    coordinate: Coordinate = itself
    ratios: bool = False

    @property
    def ends(self) -> Array:
        """Ends of the range and kinks, ascending."""
        return np.array([self.low, *self.kinks, self.high])

    def within(self, low: float, high: float, positions: Array) -> Array:
        """Return the values at positions -1 to 1 of a segment."""
        share = 0.5 * (1.0 + positions)
        values = low * (high / low) ** share if self.ratios else low + share * (high - low)
        return np.where(positions == -1.0, low, np.where(positions == 1.0, high, values))


@dataclass(frozen=True)
class PlacedAxis:
    """Nodes of an axis.

    Attributes
    ----------
    axis : Axis
    segments : tuple of ndarray (n,)
        Nodes of each segment, ascending; neighbouring segments share an end.
    error : float
        Largest error of the polynomials, found between the nodes.
    missed : tuple of (ndarray (N,), ndarray (N, ...), ndarray (N, ...)), optional
        Values, guessed and exact columns of a segment where it exceeds what was allowed.
    """

    axis: Axis
    segments: tuple[Array, ...]
    error: float = 0.0
    missed: tuple[Array, Array, Array] | None = field(default=None, compare=False, repr=False)

    @property
    def nodes(self) -> Array:
        """Nodes of all segments (E,), each once."""
        return np.concatenate([self.segments[0], *(segment[1:] for segment in self.segments[1:])])

    def slice_of(self, segment: int) -> slice:
        """Return where the nodes of a segment are among all nodes."""
        first = sum(nodes.size - 1 for nodes in self.segments[:segment])
        return slice(first, first + self.segments[segment].size)

    def segment_of(self, values: NDArray[np.floating]) -> NDArray[np.intp]:
        """Return the segment of each value, same shape; a shared end belongs to the lower one."""
        ends = np.array([nodes[0] for nodes in self.segments[1:]])
        return np.searchsorted(ends, values, side="left")

    def weights(self, segment: int, values: Array) -> Array:
        """Return the weights (n, N), or (n, B, N), of the nodes of a segment at values (N,) within it."""
        return _weights(self.axis, self.segments[segment], values)

    def interpolate(self, of_nodes: Array, values: Array) -> Array:
        """Return (N, ...) at any values (N,) what has the values (E, ...) at the nodes."""
        of_segment, result = self.segment_of(values), np.empty((values.size, *of_nodes.shape[1:]))
        for segment in np.unique(of_segment).tolist():
            inside = of_segment == segment
            weights = self.weights(segment, values[inside])
            result[inside] = through(of_nodes[self.slice_of(segment)], weights)
        return result


def through(of_nodes: Array, weights: Array) -> Array:
    """Return columns (N, ..., B) from those of the nodes (n, ..., B) and weights (n, N), or (n, B, N)."""
    if weights.ndim == 3:
        columns: Array = np.einsum("nbt,n...b->t...b", weights, of_nodes)
        return columns
    return np.tensordot(weights, of_nodes, ((0,), (0,)))


def _weights(axis: Axis, nodes: Array, values: Array) -> Array:
    at_nodes, at = np.atleast_2d(axis.coordinate(nodes)), np.atleast_2d(axis.coordinate(values))
    weights = np.stack([quadrature.lagrange(*of_band).T for of_band in zip(at_nodes, at, strict=True)], axis=1)
    return weights[:, 0] if axis.coordinate(nodes).ndim == 1 else weights


def place(
    axis: Axis,
    columns: Columns,
    tolerance: float,
    *,
    orders: Sequence[int] = ORDERS,
    most: int = 1025,
    cut: Literal["never", "needed", "kinks"] = "kinks",
    fewest: bool = False,
    nearest: Array | None = None,
    most_tested: int = 1025,
    curve: Callable[[Array, Array], Array] = through,
) -> PlacedAxis:
    """Place nodes so that polynomials between them meet a tolerance, measured halfway between the nodes.

    Parameters
    ----------
    columns : callable
        Each value is asked for once.
    tolerance : float
        Of the total, relative; of a term, ten times as much.
    orders : sequence of int
        Orders of the polynomials that are tried, one after another.
    most : int
        Number of nodes; with more the error may remain too large.
    cut : {"never", "needed", "kinks"}
        Whether segments that no order follows are cut in two; or all kinks before anything else.
    fewest : bool
        Whether nodes cost more than columns: those between which columns were compared are not nodes, then.
    nearest : ndarray, optional
        Values of which nodes are the nearest, ascending.
    most_tested : int
        Number of values halfway between the nodes of a segment at which columns are compared. Where there are more, so
        many are spread evenly over them; they are no nodes.
    curve : callable
        Returns columns from those of the nodes and weights.

    Returns
    -------
    PlacedAxis
        With the largest error that remains, and where.
    """
    placing = _Placing(axis, columns, nearest, most_tested, curve)
    ends = [axis.low, *(axis.kinks if cut == "kinks" else ()), axis.high]
    pending = [(low, high, 0) for low, high in pairwise(ends)]
    done, worst, missed = dict[float, Array](), 0.0, None
    while pending:
        tried = [placing.nodes_and_test(low, high, orders[number]) for low, high, number in pending]
        placing.of(np.concatenate([values for both in tried for values in both]))  # one call costs less than many
        count = sum(nodes.size for nodes in done.values()) + sum(nodes.size + test.size for nodes, test in tried)
        segments, pending = pending, []
        for (low, high, number), (nodes, test) in zip(segments, tried, strict=True):
            guess, exact = placing.guess(nodes, test), placing.of(test)
            error = error_of_columns(guess, exact)
            if error > tolerance and number + 1 < len(orders):
                pending.append((low, high, number + 1))
            elif error > tolerance and cut != "never" and count < most and high - low > NARROWEST * high:
                where = placing.cut(low, high)
                pending += [(low, where, 0), (where, high, 0)]
            else:
                if error > max(tolerance, worst):
                    missed = test, guess, exact
                if not fewest and test.size < most_tested:
                    nodes = np.union1d(nodes, test)
                elif fewest and error <= tolerance:
                    nodes, error = placing.fewer(low, high, orders[number], error, tolerance)
                done[low], worst = nodes, max(worst, error)
    return PlacedAxis(axis, tuple(done[low] for low in sorted(done)), worst, missed)


class _Placing:
    """Columns of an axis that are known, and the polynomials through them."""

    def __init__(
        self,
        axis: Axis,
        columns: Columns,
        nearest: Array | None,
        most_tested: int,
        curve: Callable[[Array, Array], Array],
    ) -> None:
        self._axis, self._columns, self._nearest, self._curve = axis, columns, nearest, curve
        self._most_tested = most_tested
        self._known: dict[float, Array] = {}

    def of(self, values: Array) -> Array:
        """Return the columns at values (N,)."""
        new = [value for value in dict.fromkeys(values.tolist()) if value not in self._known]
        if new:
            self._known.update(zip(new, self._columns(np.array(new)), strict=True))
        some = next(iter(self._known.values()))
        return np.array([self._known[value] for value in values.tolist()]).reshape(values.size, *some.shape)

    def nodes_and_test(self, low: float, high: float, order: int) -> tuple[Array, Array]:
        """Return the nodes of an order in a segment, and values between them."""
        nodes = np.unique(self._at(low, high, quadrature.nodes(order)))
        test = np.setdiff1d(self._at(low, high, quadrature.between(order)), nodes)
        some = np.unique(np.linspace(0, test.size - 1, min(test.size, self._most_tested)).round().astype(np.intp))
        return nodes, test[some]

    def guess(self, nodes: Array, values: Array) -> Array:
        """Return columns between the nodes."""
        return self._curve(self.of(nodes), _weights(self._axis, nodes, values))

    def cut(self, low: float, high: float) -> float:
        """Return where a segment is cut: at the kink nearest its middle, or there."""
        middle = float(self._at(low, high, np.zeros(1))[0])
        inside = [kink for kink in self._axis.kinks if low < kink < high]
        return min(inside, key=lambda kink: abs(kink - middle), default=middle)

    def fewer(self, low: float, high: float, order: int, error: float, tolerance: float) -> tuple[Array, float]:
        """Return the fewest nodes of an order above half of one, with their error; columns are those of all known."""
        nodes, test = self.nodes_and_test(low, high, order)
        finest = np.union1d(nodes, test)
        everywhere = self._at(low, high, np.linspace(-1.0, 1.0, EVERYWHERE))
        true = self.guess(finest, everywhere)
        for few in range(order // 2 + 1, order if order >= SMALLEST_REDUCED else 0):
            some = self._at(low, high, quadrature.nodes(few))
            guess = self._curve(self.guess(finest, some), _weights(self._axis, some, everywhere))
            more = error_of_columns(guess, true)
            if error + more <= tolerance:
                return some, error + more
        return nodes, error

    def _at(self, low: float, high: float, positions: Array) -> Array:
        values = self._axis.within(low, high, positions)
        if self._nearest is None:
            return values
        return self._nearest[np.searchsorted(0.5 * (self._nearest[1:] + self._nearest[:-1]), values)]
