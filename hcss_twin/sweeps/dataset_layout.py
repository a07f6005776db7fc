"""Which sweeps fit into one dataset, and what its dimensions are called."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from typing import Any

from hcss_twin.errors import Problem, ScenarioError
from hcss_twin.scenario.scenario import SWEEP
from hcss_twin.sweeps.design import Design
from hcss_twin.sweeps.points import Point, value_at

OF_ALL_POINTS = (
    "image.rows",
    "image.columns",
    "image.pixel_size",
    "frames",
    "bands",
    "output.variables",
)
"""Keys that points of one dataset have in common, because its dimensions and coordinates come from them."""


def require_one_layout(design: Design, points: Sequence[Point]) -> None:
    """Check, before any point is computed, that all of them fit into one dataset.

    Raises
    ------
    ScenarioError
        Naming the key that separates them.
    """
    if design.combine != "product":
        told = "a dataset needs a dimension for each key; allowed: combine = 'product', or no dataset"
        raise ScenarioError([Problem(f"{SWEEP}.combine", told)], design.origin)
    first = _layout(points[0])
    for point in points[1:]:
        for key, value in _layout(point).items():
            if value != first[key]:
                told = f"differs between points 0 and {point.number}; a dataset needs it in common, allowed: no dataset"
                raise ScenarioError([Problem(f"{SWEEP}: {key}", told)], design.origin)


def _layout(point: Point) -> Mapping[str, Any]:
    plain = json.loads(point.scenario.to_json())
    return {key: value_at(plain, key) for key in OF_ALL_POINTS}


def dimension_of(key: str) -> str:
    """Return the name of the dimension of a swept key: ``view_zenith`` of ``view.zenith``.

    A cube has a ``time`` of its own, so that the scenario's becomes ``start_time``.
    """
    return "start_time" if key == "time" else re.sub(r"\W", "_", key, flags=re.ASCII)
