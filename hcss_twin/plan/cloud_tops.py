"""Altitudes of cloud tops that vary within a layer: the altitudes for which there are tables.

Radiance against the altitude of the top is as smooth as the profile of the air, which is linear between its levels:
tables at few altitudes are joined by polynomials, on segments that are cut at a level where possible, until the error
between them, measured for a few columns, is small enough.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import Problem, ProviderError, ScenarioError
from hcss_twin.plan.accuracy import RequestedAccuracy
from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.axis import Axis, PlacedAxis, place
from hcss_twin.plan.combinations import Excluded, require_none
from hcss_twin.plan.effects import Effect
from hcss_twin.plan.few_columns import SAFETY_FACTOR, few_columns
from hcss_twin.providers import Sun
from hcss_twin.scenario.scenario import Scenario

SHARE = 0.2
"""Share of the accuracy for the interpolation in altitude; the tables at each altitude have the rest."""

MAX_NODES = 161

_ORDERS = (1, 2, 4)

_WAVENUMBERS = 12
"""Number of wavenumbers of each band for the error."""

_THICKNESSES = 5
_SHORTEST_M = 25.0


@dataclass(frozen=True)
class CloudTops(Effect):
    """Altitudes of the one layer's tops with tables.

    Attributes
    ----------
    placed : PlacedAxis
    """

    kind = "tops"

    placed: PlacedAxis

    def described(self) -> Mapping[str, Any]:
        """Return altitudes and error."""
        return {"cloud_tops": {"nodes_m": self.placed.nodes.tolist(), "estimated_error": self.placed.error}}


def excluded_beside_tops(assembly: Assembly) -> tuple[Excluded, ...]:
    """Return what cannot be computed with cloud tops that vary with the generator."""
    given, slant = any(layer.temperature_K is not None for layer in assembly.layers), assembly.slant
    several, air = len(assembly.layers) > 1, "that of the air at each top"
    return (
        Excluded("clouds.layers", several, f"{len(assembly.layers)} layers of cloud", "one layer"),
        Excluded("clouds.temperature", given, "a temperature of the cloud", f"without it, which is {air}"),
        Excluded("slant.shadows", slant.shadows, "shadows", "false"),
        Excluded("slant.parallax", slant.parallax, "parallax", "false"),
        Excluded("elements", bool(assembly.elements), "elements", "no elements"),
    )


def extreme_tops(assembly: Assembly) -> list[Assembly]:
    """Return the scenes with all cloud tops at the highest and at the lowest altitude.

    Raises
    ------
    ScenarioError
        Names the field.
    ProviderError
        If the range of the tops is empty, or outside the profile.
    """
    require_none("cloud tops that vary with the generator", excluded_beside_tops(assembly), "a generator without")
    (generator,), (layer,) = assembly.generators, assembly.layers
    if getattr(generator, "cloud_top_m", None) is None:
        raise ProviderError(f"the generator of '{layer.name}' has cloud_top_range_m, but no cloud_top_m")
    low, high = generator.cloud_top_range_m  # type: ignore[attr-defined]
    highest = float(assembly.profile.altitude_m[-1])
    if not layer.thickness_min_m < low < high <= highest:
        raise ProviderError(
            f"cloud_top_range_m of the generator of '{layer.name}': {low:g} to {high:g} m; allowed: ascending, "
            f"above clouds.thickness_min ({layer.thickness_min_m:g} m), up to {highest:g} m"
        )
    return [assembly.hanging_from(high), assembly.hanging_from(low)]


def plan_tops(scenario: Scenario, assembly: Assembly, accuracy: RequestedAccuracy, sun: Sun | None) -> CloudTops:
    """Choose the altitudes with tables.

    Raises
    ------
    ScenarioError
        If more than ``MAX_NODES`` are needed.
    """
    low, high = assembly.generators[0].cloud_top_range_m  # type: ignore[attr-defined]
    (layer,), levels = assembly.layers, assembly.profile.altitude_m
    thickness = np.geomspace(layer.thickness_min_m, layer.thickness_max_m, _THICKNESSES)
    columns = replace(few_columns(assembly, _WAVENUMBERS), thickness_m=thickness[:, None], clear=False)

    def at(tops_m: Array) -> Array:
        totals = []
        for hanging in map(assembly.hanging_from, tops_m.tolist()):
            thinner = np.minimum(thickness, hanging.layers[0].thickness_max_m)
            totals.append(replace(columns, thickness_m=thinner[:, None]).total(hanging, sun))
        return np.stack(totals)[:, :, None]

    axis = Axis(float(low), float(high), levels[(levels > low + _SHORTEST_M) & (levels < high - _SHORTEST_M)].tolist())
    allowed = SHARE * accuracy.relative / SAFETY_FACTOR
    placed = place(axis, at, allowed, orders=_ORDERS, cut="needed", most=MAX_NODES, fewest=True)
    if placed.missed is not None:
        message = (
            f"{scenario.accuracy}: cloud tops from {low:g} to {high:g} m need more than {MAX_NODES} tables; "
            "allowed: a lower accuracy or a smaller range of altitudes"
        )
        raise ScenarioError([Problem("accuracy", message)], scenario.origin)
    return CloudTops(replace(placed, error=SAFETY_FACTOR * placed.error))
