"""Tables for the surfaces of a scene: each class at a few temperatures.

A point takes the tables of its class; in a field of temperature it is interpolated between them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import accumulate, pairwise

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.engine.ground import Ground
from hcss_twin.engine.tables.point_axis import Group, PointAxis, groups_on
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.surface_classes import SurfaceState
from hcss_twin.plan.surfaces import PlannedSurfaces
from hcss_twin.plan.waves import MEAN_SEA
from hcss_twin.plan.windows import Window


class SurfaceStates(PointAxis[SurfaceState]):
    """Classes of surface at their temperatures.

    Attributes
    ----------
    ground : Ground
        Which of them lies at each point.
    of_classes : list of slice
        Nodes of each class.
    """

    name = "surfaces"

    def __init__(self, plan: Plan, surfaces: PlannedSurfaces) -> None:
        self.surfaces, self.ground = surfaces, Ground(plan, surfaces)
        self.nodes = [state for states in surfaces.states for state in states]
        self.estimated_error = surfaces.estimated_error
        ends = accumulate((len(states) for states in surfaces.states), initial=0)
        self.of_classes = [slice(first, last) for first, last in pairwise(ends)]

    def plan_in(self, plan: Plan, state: SurfaceState) -> Plan:
        """Return the plan of the same scene with one surface everywhere; only the scenario's own sea has waves."""
        assembly = plan.assembly.over(state)
        waves = plan.waves if assembly.surface is None else MEAN_SEA
        return replace(plan, assembly=assembly, waves=waves, surfaces=())

    def of_pixel(self, time_s: float, row: int, column: int, thickness_m: Array) -> Sequence[SurfaceState]:
        """Return class and temperature of each point."""
        return self.ground.states(self.ground.at(time_s, (slice(row, row + 1), slice(column, column + 1))))

    def groups(self, time_s: float, window: Window) -> list[Group]:
        """Return the points of each class."""
        surface, groups = self.ground.at(time_s, window), []
        number = surface.number.ravel()
        for of_class, (nodes, axis) in enumerate(zip(self.of_classes, self.surfaces.axes, strict=True)):
            points = np.flatnonzero(number == of_class)
            if not points.size:
                continue
            if nodes.stop == nodes.start + 1:
                groups.append(Group(points, [nodes.start], np.ones((1, 1, points.size))))
                continue
            assert surface.temperature_K is not None
            for group in groups_on(axis, surface.temperature_K.ravel()[points]):
                number_of = [nodes.start + node for node in group.nodes]
                groups.append(Group(points[group.points], number_of, group.weights))
        return groups
