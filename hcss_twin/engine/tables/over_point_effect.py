"""Tables for several values of an effect that a package brings, and the value at each point."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.engine.tables.point_axis import PlacedStates
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.point_effects import PlannedPointEffect
from hcss_twin.plan.point_nodes import at_nodes
from hcss_twin.plan.windows import Window


class PointEffectStates(PlacedStates):
    """Values of one effect."""

    in_clear_sky = True

    def __init__(self, plan: Plan, planned: PlannedPointEffect) -> None:
        super().__init__(planned.placed)
        self.name, self._effect, self._rays = planned.effect.name, planned.effect, plan.rays

    def plan_in(self, plan: Plan, state: float) -> Plan:
        """Return the plan of the same scene with one value everywhere."""
        others = tuple(other for other in plan.point_effects if other.effect is not self._effect)
        assembly, accuracy = plan.assembly.altered(self._effect, state), at_nodes(plan.accuracy)
        return replace(plan, assembly=assembly, accuracy=accuracy, point_effects=others)

    def values(self, time_s: float, window: Window) -> Array:
        """Return the values at the points of a window of the image; beyond the ground, the lowest."""
        x_m, y_m = self._rays.points_m(window, time_s, 0.0)
        on_ground = np.isfinite(x_m) & np.isfinite(y_m)
        values = np.full(x_m.shape, self._effect.given.low)
        values[on_ground] = self._effect.values(x_m[on_ground], y_m[on_ground], time_s)
        return values
