"""Tables in the air of several places, and the place of each pixel."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.engine.tables.point_axis import Group, PointAxis, both, groups_on
from hcss_twin.plan.air_by_place import AirByPlace
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.point_nodes import at_nodes
from hcss_twin.plan.windows import Window, pixel_sums


class AirStates(PointAxis[tuple[float, float]]):
    """Places, eastward and northward of the centre in metres; all points of a pixel have the air of its middle."""

    name, in_clear_sky = "air by place", True

    def __init__(self, plan: Plan, planned: AirByPlace) -> None:
        self._planned, self._rays, self._samples = planned, plan.rays, plan.samples_per_pixel
        self.nodes = [(x, y) for y in planned.along_y.nodes.tolist() for x in planned.along_x.nodes.tolist()]
        self.estimated_error = planned.estimated_error

    def plan_in(self, plan: Plan, state: tuple[float, float]) -> Plan:
        """Return the plan of the same scene in the air of one place."""
        assembly = self._planned.airs.at(plan.assembly, *state)
        return replace(plan, assembly=assembly, accuracy=at_nodes(plan.accuracy), air_by_place=())

    def of_pixel(self, time_s: float, row: int, column: int, thickness_m: Array) -> Sequence[tuple[float, float]]:
        """Return the place of the pixel, for each point."""
        x_m, y_m = self._places_m(time_s, (slice(row, row + 1), slice(column, column + 1)))
        return list(zip(x_m.tolist(), y_m.tolist(), strict=True))

    def groups(self, time_s: float, window: Window) -> list[Group]:
        """Return the points of a window by segments of both axes."""
        x_m, y_m = self._places_m(time_s, window)
        across, up = groups_on(self._planned.along_x, x_m), groups_on(self._planned.along_y, y_m)
        found = (both(of_y, of_x, self._planned.along_x.nodes.size) for of_y in up for of_x in across)
        return [group for group in found if group.points is None or group.points.size]

    def _places_m(self, time_s: float, window: Window) -> tuple[Array, Array]:
        """Return the places of the pixels of a window, for each point (N,); the centre where there is no ground."""
        samples, of_points_m = self._samples, self._rays.points_m(window, time_s, 0.0)
        middles = (pixel_sums(of_points, samples) / samples**2 for of_points in of_points_m)
        x_m, y_m = (np.nan_to_num(of_pixels).repeat(samples, 0).repeat(samples, 1).ravel() for of_pixels in middles)
        return x_m, y_m
