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
    """Functions of position that are evaluated at few nodes and interpolated between them.

    Parameters
    ----------
    edges : ndarray (P + 1,)
        Edges of the panels, ascending.
    evaluate : callable
        Maps positions (N,) to values (C, N).
    components : int
        C.
    """

    def __init__(self, edges: Array, evaluate: Callable[[Array], Array], components: int) -> None:
        self._evaluate = evaluate
        # Two nodes for each panel, its lower edge and its middle, and one for the last edge.
        self._nodes = np.empty(2 * edges.size - 1)
        self._nodes[::2] = edges
        self._nodes[1::2] = 0.5 * (edges[:-1] + edges[1:])
        self._values = np.full((components, self._nodes.size), np.nan)
        self._edges = edges

    def __call__(self, position: Array) -> Array:
        """Return interpolated values (C, V) at ``position`` (V,), all within the edges."""
        panel = np.clip(np.searchsorted(self._edges, position, side="right") - 1, 0, self._edges.size - 2)
        self._fill(np.unique(2 * panel[:, np.newaxis] + np.arange(3)))
        low, high = self._edges[panel], self._edges[panel + 1]
        t = (position - low) / (high - low)
        first, middle, last = (self._values[:, 2 * panel + offset] for offset in range(3))
        result: Array = (
            first * (1.0 - t) * (1.0 - 2.0 * t) + middle * 4.0 * t * (1.0 - t) + last * t * (2.0 * t - 1.0)
        )
        return result

    def _fill(self, wanted: NDArray[np.intp]) -> None:
        """Evaluate those nodes that are not yet known."""
        missing = wanted[np.isnan(self._values[0, wanted])]
        if missing.size:
            self._values[:, missing] = self._evaluate(self._nodes[missing])
