"""Which effects of a scene are axes along which its points differ."""

from __future__ import annotations

from typing import Any

from hcss_twin.engine.tables.point_axis import PointAxis
from hcss_twin.plan.plan import Plan


def point_axes(plan: Plan) -> list[PointAxis[Any]]:
    """Return the axes of a scene but for views, in the order of ``plan.effects``; none if all points are alike."""
    axes = list[PointAxis[Any]]()
    for surfaces in plan.surfaces:
        from hcss_twin.engine.tables.over_surfaces import SurfaceStates  # not for scenes of sea alone

        axes.append(SurfaceStates(plan, surfaces))
    for tops in plan.tops:
        from hcss_twin.engine.tables.over_tops import TopStates  # not for layers with tops of their own

        axes.append(TopStates(plan, tops))
    for planned in plan.point_effects:
        from hcss_twin.engine.tables.over_point_effect import PointEffectStates  # not for scenes without

        axes.append(PointEffectStates(plan, planned))
    for air in plan.air_by_place:
        from hcss_twin.engine.tables.over_air import AirStates  # not for grids on the ground

        axes.append(AirStates(plan, air))
    return axes
