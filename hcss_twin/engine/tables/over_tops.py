"""Tables for several altitudes of a layer's cloud tops, and the altitude of each point."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.engine.tables.point_axis import Group, PointAxis, groups_on
from hcss_twin.plan.cloud_tops import CloudTops
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.point_nodes import SHARE
from hcss_twin.plan.windows import Window, points_of


class TopStates(PointAxis[float]):
    """Altitudes of one layer's cloud tops."""

    name = "tops"

    def __init__(self, plan: Plan, tops: CloudTops) -> None:
        self.layer, self._generator = tops.layer, cast(Any, plan.assembly.generators[tops.layer])
        self._samples, self.placed = plan.samples_per_pixel, tops.placed
        self.nodes, self.estimated_error = tops.placed.nodes.tolist(), tops.placed.error

    def plan_in(self, plan: Plan, state: float) -> Plan:
        """Return the plan of the same scene with all cloud tops at one altitude."""
        assembly, accuracy = plan.assembly.hanging_from(state, self.layer), plan.accuracy
        accuracy = replace(accuracy, relative=(1.0 - SHARE) * accuracy.relative)
        others = tuple(tops for tops in plan.tops if tops.layer != self.layer)
        return replace(plan, assembly=assembly, layers=assembly.layers, accuracy=accuracy, tops=others)

    def of_pixel(self, time_s: float, row: int, column: int, thickness_m: Array) -> Sequence[float]:
        """Return the altitude at each point; clear points share one, and so one model."""
        tops = self.tops_m(time_s, (slice(row, row + 1), slice(column, column + 1)))
        cloudy = thickness_m[:, self.layer] > 0.0
        altitudes: list[float] = np.where(cloudy, tops.ravel().astype(np.float64), self.nodes[0]).tolist()
        return altitudes

    def groups(self, time_s: float, window: Window) -> list[Group]:
        """Return the points of each segment of altitude."""
        return groups_on(self.placed, self.tops_m(time_s, window).ravel().astype(np.float64))

    def tops_m(self, time_s: float, window: Window) -> NDArray[np.float32]:
        """Return the altitudes of cloud tops at the points of a window of the image."""
        tops: NDArray[np.float32] = self._generator.cloud_top_m(
            time_s, *(points_of(pixels, self._samples) for pixels in window)
        )
        return tops
