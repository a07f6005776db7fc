"""Axes along which the points of a scene differ beyond their clouds: tables at a few nodes, and weights of each point.

Surfaces, altitudes of cloud tops and whatever a package adds are such axes; views have nodes in two dimensions of
their own (:mod:`.over_views`). A scene has tables for
all combinations of their nodes; a point is interpolated between those around its own state. The certificate solves the
columns of each point in its exact state.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Generic, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.plan.axis import PlacedAxis
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.windows import Window

State = TypeVar("State", bound=Hashable)


@dataclass(frozen=True)
class Group:
    """Points of a window that are interpolated between the same nodes.

    Attributes
    ----------
    points : ndarray (N,) or None
        Indices of the points, or pixels, row by row; None for all of the window.
    nodes : sequence of int (n,)
    weights : ndarray (n, B, N) or (n, 1, N)
        Of each node.
    """

    points: NDArray[np.intp] | None
    nodes: Sequence[int]
    weights: Array


class FrameAxis(Protocol):
    """Where the points of a frame are on an axis."""

    @property
    def within_pixels(self) -> bool:
        """Whether points of a pixel differ."""
        ...

    def groups(self, window: Window, samples: int) -> Sequence[Group]:
        """Return all points of a window of the image, or all pixels if those of a pixel do not differ."""
        ...


class PointAxis(ABC, Generic[State]):
    """One effect's states with tables.

    Attributes
    ----------
    name : str
        Of its effect.
    nodes : sequence of State
    estimated_error : float
        Largest error of the interpolation between them, relative to the total.
    in_clear_sky : bool
        Whether its value changes what is seen of one class of surface without cloud.
    """

    in_clear_sky: ClassVar[bool] = False
    name: str
    nodes: Sequence[State]
    estimated_error: float

    @abstractmethod
    def plan_in(self, plan: Plan, state: State) -> Plan:
        """Return the plan of the same scene with one state everywhere."""

    @abstractmethod
    def of_pixel(self, time_s: float, row: int, column: int, thickness_m: Array) -> Sequence[State]:
        """Return the exact state of each point of a pixel of the image, from the thickness (points, L) there."""

    @abstractmethod
    def groups(self, time_s: float, window: Window) -> list[Group]:
        """Return the points of a window of the image at an instant, by the nodes between which they are."""

    def in_frame(self, time_s: float) -> FrameAxis:
        """Return where points are at an instant."""
        return _InFrame(self, time_s)


class PlacedStates(PointAxis[float]):
    """One number at each point, and tables for few of its values."""

    def __init__(self, placed: PlacedAxis) -> None:
        self._placed = placed
        self.nodes, self.estimated_error = placed.nodes.tolist(), placed.error

    @abstractmethod
    def values(self, time_s: float, window: Window) -> Array:
        """Return the values (y, x) at the points of a window of the image."""

    def of_pixel(self, time_s: float, row: int, column: int, thickness_m: Array) -> Sequence[float]:
        """Return the value at each point."""
        values: list[float] = self.values(time_s, (slice(row, row + 1), slice(column, column + 1))).ravel().tolist()
        return values

    def groups(self, time_s: float, window: Window) -> list[Group]:
        """Return the points of a window by segments of the axis."""
        return groups_on(self._placed, self.values(time_s, window).ravel())


@dataclass(frozen=True)
class _InFrame:
    """A point axis at one instant."""

    axis: PointAxis[Any]
    time_s: float
    within_pixels = True

    def groups(self, window: Window, samples: int) -> list[Group]:
        """Return the points of a window."""
        return self.axis.groups(self.time_s, window)


def groups_on(placed: PlacedAxis, values: Array) -> list[Group]:
    """Return points by the segment of an axis in which their values (N,) lie."""
    segments, groups = placed.segment_of(values), []
    for segment in np.unique(segments).tolist():
        points, nodes = np.flatnonzero(segments == segment), placed.slice_of(segment)
        weights = placed.weights(segment, values[points])
        groups.append(Group(points, range(nodes.start, nodes.stop), weights[:, None] if weights.ndim == 2 else weights))
    return groups


def both(before: Group, group: Group, nodes: int) -> Group:
    """Return the points that are in two groups, of axes of which the second has so many nodes."""
    number = [first * nodes + second for first in before.nodes for second in group.nodes]
    points, first, second = group.points, before.weights, group.weights
    if before.points is not None and group.points is None:
        points, second = before.points, second[..., before.points]
    elif before.points is not None and group.points is not None:
        points, *places = np.intersect1d(before.points, group.points, assume_unique=True, return_indices=True)
        first, second = first[..., places[0]], second[..., places[1]]
    weights = first[:, None] * second[None]
    return Group(points, number, weights.reshape(weights.shape[0] * weights.shape[1], *weights.shape[2:]))
