"""Nodes of what differs from point to point, each with tables of its own: few, or the scene is refused."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from hcss_twin.core.errors import Problem, ScenarioError
from hcss_twin.plan.accuracy import RequestedAccuracy
from hcss_twin.plan.axis import Axis, Columns, PlacedAxis, place
from hcss_twin.plan.few_columns import SAFETY_FACTOR
from hcss_twin.scenario.scenario import Scenario

SHARE = 0.2
"""Share of the accuracy for the interpolation between them; the tables at each have the rest."""

WAVENUMBERS = 12
"""Number of wavenumbers of each band for the error."""


def place_point_nodes(
    scenario: Scenario,
    accuracy: RequestedAccuracy,
    axis: Axis,
    columns: Columns,
    what: str,
    orders: Sequence[int],
    most: int,
) -> PlacedAxis:
    """Place nodes between which a few columns are within the share of the accuracy.

    Parameters
    ----------
    what : str
        What varies, with its range, for the message.

    Raises
    ------
    ScenarioError
        If more than ``most`` are needed.
    """
    allowed = SHARE * accuracy.relative / SAFETY_FACTOR
    placed = place(axis, columns, allowed, orders=orders, cut="needed", most=most, fewest=True)
    if placed.missed is not None:
        message = (
            f"{scenario.accuracy}: {what}: more than {most} tables would be needed; allowed: a lower accuracy or a "
            "smaller range"
        )
        raise ScenarioError([Problem("accuracy", message)], scenario.origin)
    return replace(placed, error=SAFETY_FACTOR * placed.error)


def at_nodes(accuracy: RequestedAccuracy) -> RequestedAccuracy:
    """Return the accuracy that is left for the tables at each node."""
    return replace(accuracy, relative=(1.0 - SHARE) * accuracy.relative)
