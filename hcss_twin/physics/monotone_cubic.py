"""Monotone piecewise cubic interpolation (PCHIP) at one point per row, from the four nodes around it.

With three nodes it uses all of them, with two it is a straight line, with one a constant.

Why not ``scipy.interpolate.PchipInterpolator``: it builds coefficients for every interval before it evaluates one. Here
each row has its own nodes and its own point, and only the interval in question is computed. The result is the same.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array

WINDOW = 4


def window_start(nodes: Array, x: Array) -> NDArray[np.intp]:
    """First of the ``min(4, n)`` nodes around each point.

    Parameters
    ----------
    nodes : ndarray (n,) or (P, n)
        Ascending nodes; shared by all points or one row per point.
    x : ndarray (P,)
        Points within the nodes.
    """
    rows = np.broadcast_to(nodes, (x.size, nodes.shape[-1]))
    interval = np.sum(rows[:, 1:-1] <= x[:, None], axis=1)
    result: NDArray[np.intp] = np.clip(interval - 1, 0, max(rows.shape[1] - WINDOW, 0))
    return result


def pchip_in_window(nodes: Array, values: Array, x: Array) -> Array:
    """Evaluate the monotone cubic at one point per row.

    Parameters
    ----------
    nodes : ndarray (P, N)
        The nodes :func:`window_start` selects; N is 4, or their number where there are fewer.
    values : ndarray (P, N, ...)
        Values at these nodes.
    x : ndarray (P,)
        Points within the nodes.

    Returns
    -------
    ndarray (P, ...)

    References
    ----------
    F. N. Fritsch and J. Butland, "A method for constructing local monotone piecewise cubic interpolants", SIAM J. Sci.
    Stat. Comput. 5, 300 (1984).
    """
    count = nodes.shape[1]
    if count == 1:
        only: Array = values[:, 0]
        return only
    extra = (1,) * (values.ndim - 2)
    step = np.diff(nodes, axis=1).reshape(*nodes[:, 1:].shape, *extra)
    secant = np.diff(values, axis=1) / step
    slope = np.empty_like(values)
    if count == 2:
        slope[:] = secant
    else:
        for inner in range(1, count - 1):
            left, right = inner - 1, inner
            slope[:, inner] = _interior(step[:, left], step[:, right], secant[:, left], secant[:, right])
        slope[:, 0] = _end(step[:, 0], step[:, 1], secant[:, 0], secant[:, 1])
        slope[:, -1] = _end(step[:, -1], step[:, -2], secant[:, -1], secant[:, -2])
    row = np.arange(x.size)
    interval = np.sum(nodes[:, 1:-1] <= x[:, None], axis=1)
    width = step[row, interval]
    t = ((x - nodes[row, interval]).reshape(-1, *extra)) / width
    before, after = values[row, interval], values[row, interval + 1]
    rise_left, rise_right = slope[row, interval] * width, slope[row, interval + 1] * width
    result: Array = (
        before * (1 + 2 * t) * (1 - t) ** 2
        + rise_left * t * (1 - t) ** 2
        + after * t**2 * (3 - 2 * t)
        + rise_right * t**2 * (t - 1)
    )
    return result


def _interior(step0: Array, step1: Array, secant0: Array, secant1: Array) -> Array:
    """Weighted harmonic mean of the secants; 0 at an extremum."""
    weight0, weight1 = 2 * step1 + step0, step1 + 2 * step0
    # The inverse of a secant below 1e-300 would overflow, as would the product of two large ones; hence the signs.
    same_sign = (np.sign(secant0) * np.sign(secant1) > 0) & (np.minimum(np.abs(secant0), np.abs(secant1)) > 1e-300)
    safe0, safe1 = np.where(same_sign, secant0, 1.0), np.where(same_sign, secant1, 1.0)
    mean = (weight0 + weight1) / (weight0 / safe0 + weight1 / safe1)
    result: Array = np.where(same_sign, mean, 0.0)
    return result


def _end(step0: Array, step1: Array, secant0: Array, secant1: Array) -> Array:
    """Three-point slope at an outermost node, limited so that the interpolant stays monotone."""
    slope = ((2 * step0 + step1) * secant0 - step0 * secant1) / (step0 + step1)
    slope = np.where(np.sign(slope) != np.sign(secant0), 0.0, slope)
    overshoots = (np.sign(secant0) != np.sign(secant1)) & (np.abs(slope) > 3 * np.abs(secant0))
    result: Array = np.where(overshoots, 3 * secant0, slope)
    return result
