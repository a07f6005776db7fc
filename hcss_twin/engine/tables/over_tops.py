"""Tables for several altitudes of a layer's cloud tops, and look-up with the altitude of each point."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.engine.tables.look_up import LookUp
from hcss_twin.engine.tables.over_directions import PixelViews
from hcss_twin.engine.tables.over_points import Group, PointLookUp
from hcss_twin.engine.tables.point_states import PointStates
from hcss_twin.plan.cloud_tops import SHARE, CloudTops
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.windows import Window, points_of


class TopStates(PointStates[float]):
    """Altitudes of the one layer's cloud tops."""

    def __init__(self, plan: Plan, tops: CloudTops) -> None:
        self.plan, self.axis = plan, tops
        self.nodes, self.estimated_error = tops.nodes_m, tops.estimated_error

    def plan_in(self, state: float) -> Plan:
        """Return the plan of the same scene with all cloud tops at one altitude."""
        assembly, accuracy = self.plan.assembly.hanging_from(state), self.plan.accuracy
        accuracy = replace(accuracy, relative=(1.0 - SHARE) * accuracy.relative)
        return replace(self.plan, assembly=assembly, layers=assembly.layers, accuracy=accuracy, tops=None)

    def of_pixel(self, time_s: float, row: int, column: int, thickness_m: Array) -> Sequence[float]:
        """Return the altitude at each point; clear points share one, and so one model."""
        tops = self.tops_m(time_s, (slice(row, row + 1), slice(column, column + 1)))
        cloudy = thickness_m[:, 0] > 0.0
        altitudes: list[float] = np.where(cloudy, tops.ravel().astype(np.float64), self.nodes[0]).tolist()
        return altitudes

    def look_up(self, time_s: float, of_nodes: Sequence[Sequence[LookUp]], views: PixelViews | None) -> TopLookUp:
        """Return the look-up at an instant."""
        return TopLookUp(self, of_nodes, time_s, views)

    def tops_m(self, time_s: float, window: Window) -> NDArray[np.float32]:
        """Return the altitudes of cloud tops at the points of a window of the image."""
        rows, columns = (points_of(pixels, self.plan.samples_per_pixel) for pixels in window)
        generator: Any = self.plan.assembly.generators[0]
        tops: NDArray[np.float32] = generator.cloud_top_m(time_s, rows, columns)
        return tops


class TopLookUp(PointLookUp):
    """Look-up at one instant between the tables of altitudes of cloud tops.

    Parameters
    ----------
    look_ups : sequence (altitude) of sequence (view) of LookUp
    """

    def __init__(
        self, states: TopStates, look_ups: Sequence[Sequence[LookUp]], time_s: float, views: PixelViews | None
    ) -> None:
        super().__init__(states.plan, views)
        self._states, self._look_ups, self._time_s = states, look_ups, time_s
        (layer,) = states.plan.layers
        self._thickest_m = [layer.hanging_from(top).thickness_max_m for top in states.nodes]

    def _groups(self, window: Window, samples: int) -> Iterator[Group]:
        tops = self._states.tops_m(self._time_s, window).ravel()
        segments = self._states.axis.segment_of(tops)
        for segment in np.unique(segments).tolist():
            points = np.flatnonzero(segments == segment)
            weights = self._states.axis.weights(segment, tops[points].astype(np.float64))
            nodes = slice(2 * segment, 2 * segment + 3)
            yield Group(points, self._look_ups[nodes], weights[:, None], self._thickest_m[nodes])
