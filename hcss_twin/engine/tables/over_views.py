"""Directions of view of the pixels of a frame, and their weights in the tables toward few directions.

The tables of a pass lie at the nodes of polynomials over its rectangle of directions. A frame of a camera covers a
small part of the rectangle, where polynomials of lower order do: their tables are combinations of those of the pass.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.engine.tables.point_axis import FrameAxis, Group
from hcss_twin.engine.tables.radiance_tables import DenseTable
from hcss_twin.physics import quadrature
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.rays import Rays
from hcss_twin.plan.views import ViewAxis
from hcss_twin.plan.windows import Window
from hcss_twin.providers import Grid

LOST = 1e-5
"""Largest relative error of the polynomials of a frame, relative to those of the pass."""

LEAST = 1e-6
"""Smallest radiance, relative to the largest toward the directions of a frame, to which such errors are relative."""


def plans_over_views(plan: Plan) -> Iterator[Plan]:
    """Yield a plan for each view with tables.

    Plans are built one at a time, because the providers of each view's own air can need 60 MB.
    """
    for view in plan.views.over(plan.assembly).at(plan.views.places):
        yield plan.toward(view)


class GridViews:
    """Weights of the nodes of the view for the pixels of a grid on the ground."""

    within_pixels = False

    def __init__(self, axis: ViewAxis, grid: Grid) -> None:
        self._across, self._up = axis.weights(grid)

    def groups(self, window: Window, samples: int) -> list[Group]:
        """Return all pixels."""
        up, across = self.weights(window)
        weights = up.T[:, None, :, None] * across.T[None, :, None, :]
        number = up.shape[1] * across.shape[1]
        return [Group(None, range(number), weights.reshape(number, 1, -1))]

    def weights(self, window: Window) -> tuple[Array, Array]:
        """Return the weights of rows (y, Y) and columns (x, X) of a window."""
        return self._up[window[0]], self._across[window[1]]


@dataclass(frozen=True, eq=False)
class FrameViews:
    """Nodes of the directions of one frame.

    Attributes
    ----------
    rays : Rays
    time_s : float
        Of the frame.
    middle, half : (float, float)
        Of the frame's rectangle, in coordinates of the pass.
    orders : (int, int)
        Polynomial order along x and y.
    """

    rays: Rays
    time_s: float
    middle: tuple[float, float]
    half: tuple[float, float]
    orders: tuple[int, int]
    within_pixels = False

    def groups(self, window: Window, samples: int) -> list[Group]:
        """Return all pixels; those off the ground get the direction of the middle."""
        places = self.rays.positions(window, self.time_s)
        x, y = (np.where(np.isnan(position), at, position) for position, at in zip(places, self.middle, strict=True))
        weights = self.weights(x.ravel(), y.ravel())
        return [Group(None, range(len(weights)), weights[:, None])]

    def weights(self, x: Array, y: Array) -> Array:
        """Return the weights (N, n) of the nodes at positions x and y (n,) of the pass."""
        (at_x, at_y), (half_x, half_y) = self.middle, self.half
        across = quadrature.weights(self.orders[0], (x - at_x) / half_x)
        up = quadrature.weights(self.orders[1], (y - at_y) / half_y)
        weights: Array = (up[:, :, None] * across[:, None, :]).reshape(x.size, -1).T
        return weights


def views_of_frame(plan: Plan, time_s: float, tables: DenseTable) -> tuple[FrameAxis, Array | None]:
    """Return the views of the pixels of a frame, and the weights (N, M) of the M nodes of the plan for its N nodes.

    Parameters
    ----------
    tables : DenseTable
        Toward all nodes of the plan.

    Returns
    -------
    FrameAxis
    ndarray or None
        None if the nodes of the frame are those of the plan.
    """
    if plan.is_grid:
        return GridViews(plan.views, plan.grid), None
    ends = np.array([*product(*((0, 1, core.shape[2] - 1) for core in tables.columns.cores))], dtype=np.intp)
    sample = np.concatenate((tables.clear.T, *(tables.columns.values(ends) if tables.columns.cores else ()))).T
    return nodes_of_frame(plan, time_s, sample)


def nodes_of_frame(plan: Plan, time_s: float, sample: Array, least: float = LEAST) -> tuple[FrameViews, Array | None]:
    """Return the views of a frame of rays that form no grid, and the weights of the plan's nodes, as for tables.

    Parameters
    ----------
    sample : ndarray (M, V)
        Values at all nodes of the plan, which the polynomials of the frame must tell.
    least : float
        Smallest value, relative to the largest of a column in the frame, to which errors are relative.
    """
    orders = plan.views.order_x, plan.views.order_y
    whole = FrameViews(plan.rays, time_s, (0.0, 0.0), (1.0, 1.0), orders)
    bounds = None if max(orders) == 0 else plan.rays.bounds(time_s)
    if bounds is None:
        return whole, None
    clipped = [(max(-1.0, min(low, 1.0)), max(-1.0, min(high, 1.0))) for low, high in bounds]
    middle = tuple(0.5 * (low + high) for low, high in clipped)
    half = tuple(max(0.5 * (high - low), 1e-9) for low, high in clipped)
    test = np.linspace(-1.0, 1.0, 7)
    x, y = (coordinates.ravel() for coordinates in np.meshgrid(middle[0] + half[0] * test, middle[1] + half[1] * test))
    true = whole.weights(x, y).T @ sample
    scale = np.maximum(np.abs(true), least * np.max(np.abs(true), axis=0, initial=0.0) + 1e-300)
    for order in range(max(orders)):
        few = min(order, orders[0]), min(order, orders[1])
        if (few[0] + 1) * (few[1] + 1) >= (orders[0] + 1) * (orders[1] + 1):
            break
        at_x = middle[0] + half[0] * quadrature.nodes(few[0])
        at_y = middle[1] + half[1] * quadrature.nodes(few[1])
        node_x, node_y = (coordinates.ravel() for coordinates in np.meshgrid(at_x, at_y))
        of_plan = whole.weights(node_x, node_y).T
        guess = FrameViews(plan.rays, time_s, (middle[0], middle[1]), (half[0], half[1]), few)
        if np.max(np.abs(guess.weights(x, y).T @ (of_plan @ sample) - true) / scale) <= LOST:
            return guess, of_plan
    return whole, None
