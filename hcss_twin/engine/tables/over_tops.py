"""Tables for several altitudes of a layer's cloud tops, and the altitude of each point."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.engine.clouds import FrameClouds
from hcss_twin.engine.tables.point_axis import PlacedStates
from hcss_twin.plan.cloud_tops import CloudTops
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.point_nodes import at_nodes
from hcss_twin.plan.windows import Window


class TopStates(PlacedStates):
    """Altitudes of one layer's cloud tops."""

    name = "tops"

    def __init__(self, plan: Plan, tops: CloudTops) -> None:
        super().__init__(tops.placed)
        self.layer, self._plan = tops.layer, plan
        self._clouds: tuple[Hashable, FrameClouds] | None = None

    def plan_in(self, plan: Plan, state: float) -> Plan:
        """Return the plan of the same scene with all cloud tops at one altitude."""
        assembly, accuracy = plan.assembly.hanging_from(state, self.layer), at_nodes(plan.accuracy)
        others = tuple(tops for tops in plan.tops if tops.layer != self.layer)
        return replace(plan, assembly=assembly, layers=assembly.layers, accuracy=accuracy, tops=others)

    def of_pixel(self, time_s: float, row: int, column: int, thickness_m: Array) -> Sequence[float]:
        """Return the altitude at each point; clear points share one, and so one model."""
        altitudes = super().of_pixel(time_s, row, column, thickness_m)
        cloudy: list[float] = np.where(thickness_m[:, self.layer] > 0.0, altitudes, self.nodes[0]).tolist()
        return cloudy

    def values(self, time_s: float, window: Window) -> Array:
        """Return the altitudes of cloud tops at the points of a window of the image."""
        return self.tops_m(time_s, window).astype(np.float64)

    def tops_m(self, time_s: float, window: Window) -> NDArray[np.float32]:
        """Return the same in single precision, as the truth has them."""
        key = time_s, self._plan.rays.frame_key(time_s)
        if self._clouds is None or self._clouds[0] != key:
            self._clouds = key, FrameClouds(self._plan, time_s)
        return self._clouds[1].tops_m(self.layer, window)
