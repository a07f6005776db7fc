"""Tables toward all views of a grid as combinations of few states, and the weights of pixels in them.

What shadows take and what waves change depends on the view as the radiance of columns does: it has tables at the same
nodes, and the same polynomials through them give that of a pixel. One view is one state with weight 1.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.windows import Window, length

MANY_STATES = 4
"""States from which on it pays to look for fewer."""

LOST = 1e-5
"""Largest relative error of fewer states."""


def fewest_states(every: Array, size: Array, lost: float) -> tuple[Array, Array]:
    """Return the fewest states (R, V) and weights (S, R) whose combinations equal tables (S, V) within an error.

    Radiance is nearly a sum of few products of a function of the cloud and one of the direction: of the 16 tables
    toward a frame of a camera 4 or 5 combinations tell all of them within 1e-5. They are the singular vectors of the
    table of all tables.

    Parameters
    ----------
    size : ndarray (S, V) or (V,)
        To which the error ``lost`` is relative.
    """
    largest = np.max(np.abs(every), axis=0)
    scale = np.where(largest > 0.0, largest, 1.0)
    of_table, strength, of_column = np.linalg.svd(every / scale, full_matrices=False)
    for count in range(1, strength.size + 1):
        weights, states = of_table[:, :count], strength[:count, None] * of_column[:count] * scale
        if np.max(np.abs(weights @ states - every) / size) <= lost:
            break
    return weights, states


@dataclass(frozen=True)
class ViewStates:
    """States of tables toward all views.

    Attributes
    ----------
    values : ndarray (R, ...)
        Tables of the states.
    shares : ndarray (Y, X, R)
        Of the states in the table toward each node of the view.
    """

    values: NDArray[Any]
    shares: Array


def view_states(plan: Plan, tables: NDArray[Any]) -> ViewStates:
    """Return the states of tables (K, ...) toward the nodes of the view, or toward the one view."""
    if plan.views is None:
        return ViewStates(tables, np.ones((1, 1, 1)))
    weights, every = np.eye(len(tables)), tables.reshape(len(tables), -1).astype(np.float64)
    if len(tables) > MANY_STATES and every.size:
        largest = np.max(np.abs(every), axis=0)
        weights, every = fewest_states(every, np.where(largest > 0.0, largest, 1.0), LOST)
    nodes = plan.views.order_y + 1, plan.views.order_x + 1
    return ViewStates(every.reshape(-1, *tables.shape[1:]), weights.reshape(*nodes, -1))


def weights_of_nodes(plan: Plan, window: Window) -> tuple[Array, Array]:
    """Return the weights of the nodes of the view in a window of the image: of its rows (y, Y) and columns (x, X)."""
    if plan.views is None:
        rows, columns = (np.ones((length(pixels), 1)) for pixels in window)
        return rows, columns
    across, up = plan.views.weights(plan.grid)
    return up[window[0]], across[window[1]]
