"""Which effect of a scene gives its points states of their own."""

from __future__ import annotations

from typing import Any

from hcss_twin.engine.tables.point_states import PointStates
from hcss_twin.plan.plan import Plan


def point_states(plan: Plan) -> PointStates[Any] | None:
    """Return the states of the points of a scene; None if all have the same."""
    if plan.surfaces is not None:
        from hcss_twin.engine.tables.over_surfaces import SurfaceStates  # not for scenes of sea alone

        return SurfaceStates(plan, plan.surfaces)
    if plan.tops is not None:
        from hcss_twin.engine.tables.over_tops import TopStates  # not for layers with tops of their own

        return TopStates(plan, plan.tops)
    return None
