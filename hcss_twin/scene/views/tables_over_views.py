"""Tables of a scene whose pixels have views of their own: those of each view, and their errors together."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields, replace

from hcss_twin.providers import View
from hcss_twin.scene.budget import Budget
from hcss_twin.scene.plan import Plan
from hcss_twin.scene.tables.radiance_tables import RadianceTables
from hcss_twin.scene.views.view_axis import ImageViews


def plan_toward(plan: Plan, view: View) -> Plan:
    """Return the plan of the same scene seen along parallel rays from another direction."""
    return replace(plan, assembly=plan.assembly.toward(view), views=None)


def image_views(plan: Plan) -> ImageViews:
    """Return the views over the image of a plan whose pixels have views of their own."""
    assert plan.assembly.lines_of_sight is not None
    return ImageViews(plan.grid, plan.assembly.lines_of_sight)


def plans_over_views(plan: Plan) -> tuple[Plan, ...]:
    """Return a plan for each view that has tables, which is the plan itself where one stands for all pixels."""
    if plan.views is None:
        return (plan,)
    return tuple(plan_toward(plan, view) for view in image_views(plan).at(plan.views.places))


def tables_over_views(plan: Plan, tables_of: Callable[[Plan], RadianceTables]) -> RadianceTables:
    """Return the tables of all views of a plan that has several.

    Parameters
    ----------
    tables_of : callable
        Makes the tables of a plan with one view.

    Returns
    -------
    RadianceTables
        Those that took most wavenumbers, with the largest errors of any and all of them as ``over_views``.
    """
    assert plan.views is not None
    each = tuple(tables_of(toward) for toward in plans_over_views(plan))
    largest = max(each, key=lambda tables: tables.spectrum.nodes.wavenumber_cm1.size)
    errors = Budget(
        **{field.name: max(getattr(tables.errors, field.name) for tables in each) for field in fields(Budget)}
    )
    return replace(largest, errors=replace(errors, views=plan.views.estimated_error), over_views=each)
