"""Piecewise quadratic interpolation over wavelength on nodes that do not depend on the request.

The panels end at the rows of the refractive-index table, where bulk properties have kinks, and
are subdivided to a widest relative step. Nodes belong to the table alone, so the value at a
wavenumber does not depend on which others are asked for; they are computed when first needed.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def panel_edges(kinks: Array, step: float) -> Array:
    """Split the intervals between ``kinks`` (T,), ascending ln wavelengths, into panels of at most ``step``.

    Returns
    -------
    ndarray (P + 1,)
        Edges of the panels, ascending; every kink is one.
    """
    pieces = [
        np.linspace(low, high, max(1, int(np.ceil((high - low) / step))), endpoint=False)
        for low, high in pairwise(kinks)
    ]
    return np.concatenate([*pieces, kinks[-1:]])


class PanelTable:
    """Functions of position that are known at some nodes and interpolated between them.

    Parameters
    ----------
    edges : ndarray (P + 1,)
        Edges of the panels, ascending.
    components : int
        Number C of functions.

    Attributes
    ----------
    nodes : ndarray (2 P + 1,)
        Positions: the edges and the middles of the panels.
    values : ndarray (C, 2 P + 1)
        Values there, NaN where they are not yet known.
    """

    def __init__(self, edges: Array, components: int) -> None:
        self.nodes = np.empty(2 * edges.size - 1)
        self.nodes[::2] = edges
        self.nodes[1::2] = 0.5 * (edges[:-1] + edges[1:])
        self.values = np.full((components, self.nodes.size), np.nan)
        self._edges = edges

    def missing(self, position: Array) -> NDArray[np.intp]:
        """Nodes (N,) without values that ``position`` (V,) needs."""
        wanted = np.unique(2 * self._panel(position)[:, np.newaxis] + np.arange(3))
        result: NDArray[np.intp] = wanted[np.isnan(self.values[0, wanted])]
        return result

    def fill(self, nodes: NDArray[np.intp], evaluate: Callable[[Array], Array]) -> None:
        """Set the values of ``nodes`` (N,) from ``evaluate``, which maps positions (N,) to values (C, N)."""
        if nodes.size:
            self.values[:, nodes] = evaluate(self.nodes[nodes])

    def adopt(self, values: Array) -> None:
        """Take over values (C, 2 P + 1) of another table at the same nodes where this one has none."""
        unknown = np.isnan(self.values[0])
        self.values[:, unknown] = values[:, unknown]

    def __call__(self, position: Array) -> Array:
        """Return interpolated values (C, V) at ``position`` (V,), all within the edges and none of them missing."""
        panel = self._panel(position)
        low, high = self._edges[panel], self._edges[panel + 1]
        t = (position - low) / (high - low)
        first, middle, last = (self.values[:, 2 * panel + offset] for offset in range(3))
        result: Array = (
            first * (1.0 - t) * (1.0 - 2.0 * t) + middle * 4.0 * t * (1.0 - t) + last * t * (2.0 * t - 1.0)
        )
        return result

    def _panel(self, position: Array) -> NDArray[np.intp]:
        last = self._edges.size - 2
        return np.clip(np.searchsorted(self._edges, position, side="right") - 1, 0, last)
