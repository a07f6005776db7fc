"""Tables of clear sky as combinations of few states, and the weights of pixels in them.

What shadows take and what waves change depends on the view and on effects of points as the radiance of columns does: it
has tables at the same nodes, and the same polynomials through them give that of a pixel. One view is one state with
weight 1.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.kernels import kernel
from hcss_twin.engine.tables.over_views import nodes_of_frame
from hcss_twin.engine.tables.point_axis import FrameAxis, PointAxis
from hcss_twin.engine.tables.tensor_train import LOST, MANY_STATES, fewest_states
from hcss_twin.physics.quadrature import weigh_row
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.windows import Window, length

WEIGHTS_AT_ONCE = 2**20
"""Pixels times nodes whose weights are in memory together, of rays that form no grid."""


@dataclass(frozen=True)
class ViewStates(ABC):
    """States of tables toward all views at an instant; by default of one view.

    Attributes
    ----------
    values : ndarray (R, ...)
        Tables of the states.
    """

    values: NDArray[Any]

    @abstractmethod
    def weights(self, window: Window) -> Array:
        """Return the weights (y, x, R) of the states in the pixels of a window of the image.

        Axes of pixels that all have the same weights may have length 1.
        """


class OneView(ViewStates):
    """The only state."""

    def weights(self, window: Window) -> Array:
        """Return 1."""
        return np.ones((1, 1, 1))


@dataclass(frozen=True)
class GridStates(ViewStates):
    """States of a grid on the ground.

    Attributes
    ----------
    shares : ndarray (Y, X, R)
        Of the states in the table toward each node of the view.
    across, up : ndarray (columns, X) and (rows, Y)
        Weights of the nodes of the view in the columns and rows of the image.
    """

    shares: Array
    across: Array
    up: Array

    def weights(self, window: Window) -> Array:
        """Return the weights of a window, row by row."""
        rows, columns = self.up[window[0]], self.across[window[1]]
        found = np.empty((len(rows), len(columns), self.shares.shape[2]))
        _weigh_rows(found, rows, columns, self.shares)
        return found


@dataclass(frozen=True)
class RayStates(ViewStates):
    """States of one frame of other rays.

    Attributes
    ----------
    shares : ndarray (N, R)
        Of the states in the table toward each node of the frame.
    axis : FrameAxis
        Views of the pixels between these nodes.
    """

    shares: Array
    axis: FrameAxis

    def weights(self, window: Window) -> Array:
        """Return the weights of a window, pixel by pixel."""
        rows, columns = window
        found = np.empty((length(rows), length(columns), self.shares.shape[1]))
        step = max(1, WEIGHTS_AT_ONCE // (length(columns) * len(self.shares)))
        for first in range(rows.start, rows.stop, step):
            strip = slice(first, min(first + step, rows.stop))
            (pixels,) = self.axis.groups((strip, columns), 1)
            of_nodes = pixels.weights[:, 0].T
            found[strip.start - rows.start : strip.stop - rows.start].reshape(-1, found.shape[2])[:] = (
                of_nodes @ self.shares
            )
        return found


@dataclass(frozen=True)
class EffectStates(ViewStates):
    """States toward all views at each value of effects of points.

    Attributes
    ----------
    of_views : ViewStates
    effects : sequence of PointAxis
        Their values are in the pixels' weights, the last one after another.
    time_s : float
        Of the frame.
    samples : int
        Points along each side of a pixel, over which weights are averaged.
    """

    of_views: ViewStates
    effects: Sequence[PointAxis[Any]]
    time_s: float
    samples: int

    def weights(self, window: Window) -> Array:
        """Return products of the weights of views and of values."""
        found = self.of_views.weights(window)
        rows, columns = (length(pixels) for pixels in window)
        for effect in self.effects:
            of_points = np.zeros((len(effect.nodes), rows * columns * self.samples**2))
            for group in effect.groups(self.time_s, window):
                at = slice(None) if group.points is None else group.points
                of_points[np.array(group.nodes)[:, None], np.arange(of_points.shape[1])[at]] = group.weights.mean(
                    axis=1
                )
            of_pixels = of_points.reshape(-1, rows, self.samples, columns, self.samples).mean(axis=(2, 4))
            of_values = np.moveaxis(of_pixels, 0, -1)
            found = (found[..., None] * of_values[:, :, None]).reshape(rows, columns, -1)
        return found


@kernel()
def _weigh_rows(found, rows, columns, shares):  # type: ignore[no-untyped-def]
    """Set the weights (y, x, R) of states from those of the nodes of the view."""
    for y in range(rows.shape[0]):
        weigh_row(found[y], rows[y], columns, shares)


def view_states(plan: Plan, tables: NDArray[Any], time_s: float) -> ViewStates:
    """Return the states of tables (K, ...) toward the nodes of the view, or toward the one view, at an instant."""
    if not plan.views.varies:
        return OneView(tables)
    every, axis = tables.reshape(len(tables), -1).astype(np.float64), None
    if not plan.is_grid:
        axis, of_plan = nodes_of_frame(plan, time_s, every, least=1.0)
        every = every if of_plan is None else of_plan @ every
    shares = np.eye(len(every))
    if len(every) > MANY_STATES and every.size:
        largest = np.max(np.abs(every), axis=0)
        shares, every = fewest_states(every, np.where(largest > 0.0, largest, 1.0), LOST)
    values = every.reshape(-1, *tables.shape[1:])
    if axis is not None:
        return RayStates(values, shares, axis)
    nodes = plan.views.order_y + 1, plan.views.order_x + 1
    return GridStates(values, shares.reshape(*nodes, -1), *plan.views.weights(plan.grid))


def point_states(plan: Plan, effects: Sequence[PointAxis[Any]], tables: NDArray[Any], time_s: float) -> ViewStates:
    """Return the states of tables (K, ...) of clear sky: at all values of effects of points, toward all views."""
    if not effects:
        return view_states(plan, tables, time_s)
    values = math.prod(len(effect.nodes) for effect in effects)
    of_views = view_states(plan, tables.reshape(values, -1, *tables.shape[1:]).swapaxes(0, 1), time_s)
    every = of_views.values.reshape(-1, *tables.shape[1:])
    return EffectStates(every, of_views, effects, time_s, plan.samples_per_pixel)
