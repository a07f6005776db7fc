"""Look-up in the tables of a scene at one instant, for whatever differs from pixel to pixel or point to point."""

from __future__ import annotations

from typing import Any

from hcss_twin.engine.tables.look_up import LookUp
from hcss_twin.engine.tables.over_directions import pixel_views, views_together
from hcss_twin.engine.tables.over_points import AnyLookUp
from hcss_twin.engine.tables.point_states import PointStates
from hcss_twin.engine.tables.radiance_tables import RadianceTables, TableReader
from hcss_twin.plan.plan import Plan


class FrameLookUps:
    """Look-ups of the frames of a scene; request them in the order of time, as of :class:`TableReader`.

    Parameters
    ----------
    states : PointStates or None
        Those of the points of the plan.
    """

    def __init__(self, plan: Plan, tables: RadianceTables, states: PointStates[Any] | None) -> None:
        self._plan, self._states = plan, states
        self._readers = [
            [TableReader(view) for view in node.over_views or (node,)] for node in tables.over_states or (tables,)
        ]
        self._before: list[list[LookUp | None]] = [[None] * len(views) for views in self._readers]

    def at(self, time_s: float) -> AnyLookUp:
        """Return the look-up at an instant."""
        look_ups = [
            [LookUp(reader.at(time_s), before) for reader, before in zip(views, of_views, strict=True)]
            for views, of_views in zip(self._readers, self._before, strict=True)
        ]
        self._before = [[*of_views] for of_views in look_ups]
        if self._states is None:
            return views_together(self._plan, time_s, look_ups[0])
        views = pixel_views(self._plan, time_s, [look_up.table for look_up in look_ups[0]])
        if views is not None:
            look_ups = [views.look_ups(of_views) for of_views in look_ups]
        return self._states.look_up(time_s, look_ups, views)
