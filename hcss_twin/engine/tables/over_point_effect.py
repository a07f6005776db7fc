"""Tables for several values of an effect that a package brings, and the value at each point."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.engine.tables.point_axis import Group, PointAxis, groups_on
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.point_effects import PlannedPointEffect
from hcss_twin.plan.point_nodes import SHARE
from hcss_twin.plan.windows import Window


class PointEffectStates(PointAxis[float]):
    """Values of one effect."""

    in_clear_sky = True

    def __init__(self, plan: Plan, planned: PlannedPointEffect) -> None:
        self.name, self._planned, self._rays = planned.effect.name, planned, plan.rays
        self.nodes, self.estimated_error = planned.placed.nodes.tolist(), planned.placed.error

    def plan_in(self, plan: Plan, state: float) -> Plan:
        """Return the plan of the same scene with one value everywhere."""
        accuracy = replace(plan.accuracy, relative=(1.0 - SHARE) * plan.accuracy.relative)
        others = tuple(other for other in plan.point_effects if other.effect is not self._planned.effect)
        assembly = plan.assembly.altered(self._planned.effect, state)
        return replace(plan, assembly=assembly, accuracy=accuracy, point_effects=others)

    def of_pixel(self, time_s: float, row: int, column: int, thickness_m: Array) -> Sequence[float]:
        """Return the value at each point."""
        values: list[float] = self.values(time_s, (slice(row, row + 1), slice(column, column + 1))).ravel().tolist()
        return values

    def values(self, time_s: float, window: Window) -> Array:
        """Return the values at the points of a window of the image; beyond the ground, the lowest."""
        x_m, y_m = self._rays.points_m(window, time_s, 0.0)
        on_ground = np.isfinite(x_m) & np.isfinite(y_m)
        values = np.full(x_m.shape, self._planned.effect.given.low)
        values[on_ground] = self._planned.effect.values(x_m[on_ground], y_m[on_ground], time_s)
        return values

    def groups(self, time_s: float, window: Window) -> list[Group]:
        """Return the points of a window by segments of the axis."""
        return groups_on(self._planned.placed, self.values(time_s, window).ravel())
