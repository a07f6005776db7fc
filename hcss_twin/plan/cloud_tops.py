"""Altitudes of cloud tops that vary within layers: the altitudes for which there are tables.

Radiance against the altitude of the top is as smooth as the profile of the air, which is linear between its levels:
tables at few altitudes are joined by polynomials, on segments that are cut at a level where possible, until the error
between them, measured for a few columns, is small enough.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.cache import kept_result
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import ProviderError
from hcss_twin.plan.accuracy import RequestedAccuracy
from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.axis import Axis, PlacedAxis
from hcss_twin.plan.combinations import Excluded
from hcss_twin.plan.effects import Effect
from hcss_twin.plan.few_columns import few_columns
from hcss_twin.plan.point_nodes import WAVENUMBERS, place_point_nodes
from hcss_twin.plan.scene_analysis import inputs_of_analysis
from hcss_twin.providers import Sun
from hcss_twin.scenario.scenario import Scenario

MAX_NODES = 161

_ORDERS = (1, 2, 4)

_THICKNESSES = 5
_SHORTEST_M = 25.0


@dataclass(frozen=True)
class CloudTops(Effect):
    """Altitudes of a layer's tops with tables.

    Attributes
    ----------
    layer : int
    name : str
        Of the layer.
    placed : PlacedAxis
    """

    kind = "tops"

    layer: int
    name: str
    placed: PlacedAxis

    @property
    def nodes(self) -> dict[str, Any]:
        """Altitudes and error as plain values."""
        return {"nodes_m": self.placed.nodes.tolist(), "estimated_error": self.placed.error}


def excluded_beside_tops(assembly: Assembly) -> tuple[Excluded, ...]:
    """Return what cannot be computed with cloud tops that vary with the generator."""
    hanging = [assembly.layers[index] for index in assembly.hanging_layers]
    given, air = any(layer.temperature_K is not None for layer in hanging), "that of the air at each top"
    return (Excluded("clouds.temperature", given, "a temperature of the cloud", f"without it, which is {air}"),)


def extreme_tops(assembly: Assembly) -> list[Assembly]:
    """Return the scenes with all tops that vary at their highest and at their lowest altitudes.

    Raises
    ------
    ScenarioError
        Names the field.
    ProviderError
        If the range of the tops is empty, or outside the profile or what other layers leave.
    """
    Excluded.require_none(
        "cloud tops that vary with the generator", excluded_beside_tops(assembly), "a generator without"
    )
    highest, lowest = assembly, assembly
    for index in assembly.hanging_layers:
        low, high = _range(assembly, index)
        highest, lowest = highest.hanging_from(high, index), lowest.hanging_from(low, index)
    return [highest, lowest]


def _range(assembly: Assembly, index: int) -> tuple[float, float]:
    """Return the lowest and the highest top of a layer."""
    generator, layer = assembly.generators[index], assembly.layers[index]
    if getattr(generator, "cloud_top_m", None) is None:
        raise ProviderError(f"the generator of '{layer.name}' has cloud_top_range_m, but no cloud_top_m")
    low, high = generator.cloud_top_range_m  # type: ignore[attr-defined]
    below = _extent(assembly, index - 1)[1] if index else 0.0
    last = index + 1 == len(assembly.layers)
    above = assembly.profile.altitude_m[-1] if last else _extent(assembly, index + 1)[0]
    floor = below + (layer.thickness_max_m if index else layer.thickness_min_m)
    if not floor < low < high <= above:
        others = "" if len(assembly.layers) == 1 else ", which the layers below and above leave"
        raise ProviderError(
            f"cloud_top_range_m of the generator of '{layer.name}': {low:g} to {high:g} m; allowed: ascending, "
            f"above {floor:g} m, up to {above:g} m{others}"
        )
    return float(low), float(high)


def _extent(assembly: Assembly, index: int) -> tuple[float, float]:
    """Return where clouds of a layer may be: its lowest base and highest top."""
    layer = assembly.layers[index]
    if index not in assembly.hanging_layers:
        return layer.base_m, layer.top_m
    low, high = assembly.generators[index].cloud_top_range_m  # type: ignore[attr-defined]
    return max(low - layer.thickness_max_m, 0.0), high


@dataclass(frozen=True)
class _Nodes:
    """What is cached of a placed axis: the nodes of its segments, and the error."""

    segments: tuple[Array, ...]
    error: float


def plan_tops(
    scenario: Scenario, assembly: Assembly, which: int, accuracy: RequestedAccuracy, sun: Sun | None, catalog: Catalog
) -> CloudTops:
    """Choose the altitudes of a layer's tops with tables, from the cache if possible.

    Raises
    ------
    ScenarioError
        If more than ``MAX_NODES`` are needed.
    """
    (low, high), layer, levels = _range(assembly, which), assembly.layers[which], assembly.profile.altitude_m
    columns = few_columns(assembly, WAVENUMBERS)
    alone = np.zeros((_THICKNESSES, len(assembly.layers)))
    alone[:, which] = np.geomspace(layer.thickness_min_m, layer.thickness_max_m, _THICKNESSES)
    medium = [np.sqrt(of.thickness_min_m * of.thickness_max_m) for of in assembly.layers]
    beside = np.where(alone > 0.0, alone, np.array(medium) * assembly.cloudy_layers)
    thickness = np.unique(np.concatenate((alone, beside)), axis=0)

    def at(tops_m: Array) -> Array:
        totals = []
        for hanging in (assembly.hanging_from(top_m, which) for top_m in tops_m.tolist()):
            thinner = np.minimum(thickness, [of.thickness_max_m for of in hanging.layers])
            totals.append(replace(columns, thickness_m=thinner, clear=False).total(hanging, sun))
        return np.stack(totals)[:, :, None]

    axis = Axis(low, high, levels[(levels > low + _SHORTEST_M) & (levels < high - _SHORTEST_M)].tolist())
    what = f"cloud tops of '{layer.name}' from {low:g} to {high:g} m"

    def compute() -> _Nodes:
        placed = place_point_nodes(scenario, accuracy, axis, at, what, _ORDERS, MAX_NODES)
        return _Nodes(placed.segments, placed.error)

    parts = {"for": "cloud tops", "layer": which, "range": [low, high], "accuracy": repr(accuracy), "sun": repr(sun)}
    inputs = inputs_of_analysis(scenario, assembly, catalog)
    nodes = kept_result({**inputs, **parts}, catalog, compute, (_Nodes,))
    return CloudTops(which, layer.name, PlacedAxis(axis, nodes.segments, nodes.error))
