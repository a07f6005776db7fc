"""States of points: effects whose state differs from point to point, each state with tables of its own.

Surfaces and altitudes of cloud tops are such effects. A scene with one of them has tables for a few states; a point
looks up those of its own state, or interpolates between them. The certificate solves the columns of each point in its
exact state.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Hashable, Sequence
from dataclasses import replace
from typing import Generic, TypeVar

from hcss_twin.core.arrays import Array
from hcss_twin.engine.tables.look_up import LookUp
from hcss_twin.engine.tables.over_directions import PixelViews
from hcss_twin.engine.tables.over_points import PointLookUp
from hcss_twin.engine.tables.radiance_tables import RadianceTables, with_largest_errors
from hcss_twin.plan.plan import Plan

State = TypeVar("State", bound=Hashable)


class PointStates(ABC, Generic[State]):
    """States of one effect of a scene.

    Attributes
    ----------
    nodes : sequence of State
        The states with tables.
    estimated_error : float
        Largest error of the interpolation between them, relative to the total.
    """

    nodes: Sequence[State]
    estimated_error: float

    @abstractmethod
    def plan_in(self, state: State) -> Plan:
        """Return the plan of the same scene with one state everywhere."""

    @abstractmethod
    def of_pixel(self, time_s: float, row: int, column: int, thickness_m: Array) -> Sequence[State]:
        """Return the exact state of each point of a pixel of the image, from the thickness (points, L) there."""

    @abstractmethod
    def look_up(self, time_s: float, of_nodes: Sequence[Sequence[LookUp]], views: PixelViews | None) -> PointLookUp:
        """Return the look-up at an instant.

        Parameters
        ----------
        of_nodes : sequence (node) of sequence (view) of LookUp
        views : PixelViews or None
            Weights of the nodes of the view at each pixel; None for one view.
        """

    def tables(self, tables_of: Callable[[Plan], RadianceTables]) -> RadianceTables:
        """Return the tables of all nodes, as ``over_states`` of those with the most wavenumbers and largest errors.

        Parameters
        ----------
        tables_of : callable
            Computes the tables of a plan with one state.
        """
        of_nodes = tuple(tables_of(self.plan_in(state)) for state in self.nodes)
        return replace(with_largest_errors(of_nodes), over_states=of_nodes, state_error=self.estimated_error)
