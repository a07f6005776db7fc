"""Tables for the surfaces of a scene, and look-up with the class and temperature of each point.

Each state of a surface, a class at a temperature, has tables of its own. A point takes those of its class; in a field
of temperature it is interpolated between them (:class:`hcss_twin.plan.surfaces.TemperatureAxis`). The points of a
pixel are averaged afterwards.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import accumulate, pairwise

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.engine.ground import Ground
from hcss_twin.engine.tables.look_up import LookUp
from hcss_twin.engine.tables.over_directions import PixelViews
from hcss_twin.engine.tables.over_points import Group, PointLookUp
from hcss_twin.engine.tables.point_states import PointStates
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.surface_classes import SurfaceState
from hcss_twin.plan.surfaces import PlannedSurfaces, TemperatureAxis
from hcss_twin.plan.windows import Window


class SurfaceStates(PointStates[SurfaceState]):
    """Classes of surface at their temperatures.

    Attributes
    ----------
    ground : Ground
        Which of them lies at each point.
    of_classes : list of slice
        Nodes of each class.
    """

    def __init__(self, plan: Plan, surfaces: PlannedSurfaces) -> None:
        self._plan, self.ground = plan, Ground(plan, surfaces)
        self.nodes = [state for states in surfaces.states for state in states]
        self.estimated_error = surfaces.estimated_error
        ends = accumulate((len(states) for states in surfaces.states), initial=0)
        self.of_classes = [slice(first, last) for first, last in pairwise(ends)]
        self._axes = [
            TemperatureAxis(plan.spectral_grid, nodes) if len(nodes) > 1 else None for nodes in surfaces.nodes_K
        ]

    def plan_in(self, state: SurfaceState) -> Plan:
        """Return the plan of the same scene with one surface everywhere; only the scenario's own sea has waves."""
        assembly = self._plan.assembly.over(state)
        waves = self._plan.waves if assembly.surface is None else None
        return replace(self._plan, assembly=assembly, waves=waves, surfaces=None)

    def of_pixel(self, time_s: float, row: int, column: int, thickness_m: Array) -> Sequence[SurfaceState]:
        """Return class and temperature of each point."""
        return self.ground.states(self.ground.at(time_s, (slice(row, row + 1), slice(column, column + 1))))

    def look_up(self, time_s: float, of_nodes: Sequence[Sequence[LookUp]], views: PixelViews | None) -> SurfaceLookUp:
        """Return the look-up at an instant."""
        of_classes = [(of_nodes[nodes], axis) for nodes, axis in zip(self.of_classes, self._axes, strict=True)]
        return SurfaceLookUp(self._plan, self.ground, of_classes, time_s, views)


class SurfaceLookUp(PointLookUp):
    """Look-up at one instant in the tables of each point's surface.

    Parameters
    ----------
    of_classes : sequence of (sequence (temperature) of sequence (view) of LookUp, TemperatureAxis or None)
        Of each class; no axis for a constant temperature.
    """

    def __init__(
        self,
        plan: Plan,
        ground: Ground,
        of_classes: Sequence[tuple[Sequence[Sequence[LookUp]], TemperatureAxis | None]],
        time_s: float,
        views: PixelViews | None,
    ) -> None:
        super().__init__(plan, views)
        self._ground, self._of_classes, self._time_s = ground, of_classes, time_s

    def _groups(self, window: Window, samples: int) -> Iterator[Group]:
        surface = self._ground.at(self._time_s, window)
        number = surface.number.ravel()
        for of_class, (states, axis) in enumerate(self._of_classes):
            points = np.flatnonzero(number == of_class)
            if not points.size:
                continue
            weights: Array | None = None
            if axis is not None:
                assert surface.temperature_K is not None
                weights = axis.weights(surface.temperature_K.ravel()[points])
            yield Group(points, states, weights)
