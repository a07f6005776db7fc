"""Tables for several altitudes of a layer's cloud tops, and look-up with the altitude of each point."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from hcss_twin.engine.tables.look_up import LookUp
from hcss_twin.engine.tables.over_directions import pixel_views
from hcss_twin.engine.tables.over_points import Group, PointLookUp
from hcss_twin.engine.tables.radiance_tables import RadianceTables, TableReader, with_largest_errors
from hcss_twin.plan.cloud_tops import SHARE
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.windows import Window, points_of


def plan_hanging_from(plan: Plan, top_m: float) -> Plan:
    """Return the plan of the same scene with all cloud tops at one altitude."""
    assembly = plan.assembly.hanging_from(top_m)
    accuracy = replace(plan.accuracy, relative=(1.0 - SHARE) * plan.accuracy.relative)
    return replace(plan, assembly=assembly, layers=assembly.layers, accuracy=accuracy, tops=None)


def tables_over_tops(plan: Plan, tables_of: Callable[[Plan], RadianceTables]) -> RadianceTables:
    """Return the tables of all altitudes of a plan's cloud tops.

    Parameters
    ----------
    tables_of : callable
        Computes the tables of a plan with one altitude.

    Returns
    -------
    RadianceTables
        Tables with the most wavenumbers, with the largest errors of all altitudes, and all tables as ``over_tops``.
    """
    assert plan.tops is not None
    each = tuple(tables_of(plan_hanging_from(plan, top)) for top in plan.tops.nodes_m)
    return replace(with_largest_errors(each), over_tops=each, top_error=plan.tops.estimated_error)


class TopStage:
    """Tables of a scene whose cloud tops vary."""

    def __init__(self, plan: Plan, tables: RadianceTables) -> None:
        self._plan = plan
        self._readers = [[TableReader(one) for one in each.over_views or (each,)] for each in tables.over_tops]
        self._before: list[list[LookUp | None]] = [[None] * len(views) for views in self._readers]

    def look_up(self, time_s: float) -> TopLookUp:
        """Return the look-up at an instant."""
        look_ups = [
            [LookUp(one.at(time_s), old) for one, old in zip(views, own, strict=True)]
            for views, own in zip(self._readers, self._before, strict=True)
        ]
        self._before = [[*own] for own in look_ups]
        return TopLookUp(self._plan, look_ups, time_s)


class TopLookUp(PointLookUp):
    """Look-up at one instant between the tables of altitudes of cloud tops.

    Parameters
    ----------
    look_ups : sequence (altitude) of sequence (view) of LookUp
    """

    def __init__(self, plan: Plan, look_ups: Sequence[Sequence[LookUp]], time_s: float) -> None:
        super().__init__(plan, pixel_views(plan, time_s, ()))
        assert plan.tops is not None
        self._plan, self._tops, self._look_ups, self._time_s = plan, plan.tops, look_ups, time_s
        (layer,) = plan.layers
        self._thickest_m = [layer.hanging_from(top).thickness_max_m for top in plan.tops.nodes_m]

    def _groups(self, window: Window, samples: int) -> Iterator[Group]:
        tops = cloud_tops_m(self._plan, self._time_s, window).ravel()
        segment = self._tops.segment_of(tops)
        for own in np.unique(segment).tolist():
            here = np.flatnonzero(segment == own)
            weights = self._tops.weights(own, tops[here].astype(np.float64))
            nodes = slice(2 * own, 2 * own + 3)
            yield Group(here, self._look_ups[nodes], weights[:, None], self._thickest_m[nodes])


def cloud_tops_m(plan: Plan, time_s: float, window: Window) -> NDArray[np.float32]:
    """Return the altitudes of cloud tops at the points of a window of the image."""
    rows, columns = (points_of(pixels, plan.samples_per_pixel) for pixels in window)
    tops: NDArray[np.float32] = plan.assembly.generators[0].cloud_top_m(time_s, rows, columns)  # type: ignore[attr-defined]
    return tops
