"""Columns of a pixel of the certificate that is the mean of many points with thicknesses of their own."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.physics import quadrature

MANY_COLUMNS = 12
"""Columns of which all are solved."""

ORDER, HALF_ORDER_SHARE = 8, 0.3
"""Order of the polynomial through few columns, and the share of the accuracy by which half that order may differ
from it: the error of the whole order is about the square of this difference."""


def solve_many(solved: Callable[[Array], Array], columns: Array, accuracy: float) -> Array:
    """Return values (N, Q, B) of columns (N, L): those of many from few, along the logarithm of thickness.

    Parameters
    ----------
    solved : callable
        Returns the values of columns. It is asked for all if there are few, if two layers have cloud, or if the
        polynomial through few is not accurate enough.
    accuracy : float
        Relative to the first quantity, the total.
    """
    layers = np.flatnonzero(np.any(columns > 0.0, axis=0))
    cloudy = np.any(columns > 0.0, axis=1)
    if layers.size != 1 or np.count_nonzero(cloudy) <= MANY_COLUMNS:
        return solved(columns)
    depth = np.log(columns[cloudy, layers[0]])
    middle, half = 0.5 * (depth.max() + depth.min()), 0.5 * (depth.max() - depth.min())
    nodes = np.zeros((ORDER + 1 + int(not cloudy.all()), columns.shape[1]))
    nodes[: ORDER + 1, layers[0]] = np.exp(middle + half * quadrature.nodes(ORDER))
    known = solved(nodes)
    at = (depth - middle) / half
    fine, coarse = (
        np.tensordot(quadrature.weights(order, at), known[: ORDER + 1 : ORDER // order], 1)
        for order in (ORDER, ORDER // 2)
    )
    if np.any(np.abs(fine - coarse) > HALF_ORDER_SHARE * accuracy * fine[:, :1]):
        return solved(columns)
    result = np.repeat(known[-1:], columns.shape[0], axis=0)
    result[cloudy] = fine
    return result
