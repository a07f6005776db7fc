"""Altitudes of cloud tops that vary within a layer: the altitudes for which there are tables.

Radiance against the altitude of the top is as smooth as the profile of the air, which is linear between its levels:
tables at the ends and the middle of segments are joined by parabolas. Segments are halved, at a level where possible,
until the error between their nodes, measured for a few columns, is small enough.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.error_norm import largest_error
from hcss_twin.core.errors import Problem, ProviderError, ScenarioError
from hcss_twin.plan.accuracy import RequestedAccuracy
from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.combinations import Excluded, require_none
from hcss_twin.plan.effects import Effect
from hcss_twin.plan.few_columns import SAFETY_FACTOR, few_columns
from hcss_twin.providers import Sun
from hcss_twin.scenario.scenario import Scenario

SHARE = 0.2
"""Share of the accuracy for the interpolation in altitude; the tables at each altitude have the rest."""

MAX_NODES = 161

_BETWEEN = (0.125, 0.25, 0.375, 0.625, 0.75, 0.875)
"""Tested places of a segment."""

_WAVENUMBERS = 12
"""Number of wavenumbers of each band for the error."""

_THICKNESSES = 5
_SHORTEST_M = 25.0


@dataclass(frozen=True)
class CloudTops(Effect):
    """Altitudes of the one layer's tops with tables.

    Attributes
    ----------
    nodes_m : tuple of float (2 S + 1,)
        Ascending: ends and middles of S segments.
    estimated_error : float
        Largest error between them, relative to the total.
    """

    kind = "tops"

    nodes_m: tuple[float, ...]
    estimated_error: float

    def described(self) -> Mapping[str, Any]:
        """Return altitudes and error."""
        return {"cloud_tops": vars(self)}

    def segment_of(self, top_m: NDArray[np.float32]) -> NDArray[np.intp]:
        """Return the segment of each altitude, same shape."""
        inner = np.array(self.nodes_m[2:-1:2], dtype=np.float32)
        return np.searchsorted(inner, top_m, side="right")

    def weights(self, segment: int, top_m: Array) -> Array:
        """Return the weights (3, N) of the nodes of a segment at altitudes (N,) within it."""
        low, _, high = self.nodes_m[2 * segment : 2 * segment + 3]
        return parabola((top_m - low) / (high - low))


def parabola(position: Array) -> Array:
    """Return the weights (3, N) of values at 0, 1/2 and 1 in their parabola at positions (N,)."""
    return np.stack(
        (
            (1.0 - position) * (1.0 - 2.0 * position),
            4.0 * position * (1.0 - position),
            position * (2.0 * position - 1.0),
        )
    )


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
        Excluded("surfaces", assembly.surfaces is not None, "a map of the ground", "sea everywhere"),
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
    known: dict[float, Array] = {}

    def at(top_m: float) -> Array:
        if top_m not in known:
            hanging = assembly.hanging_from(top_m)
            thinner = np.minimum(thickness, hanging.layers[0].thickness_max_m)
            known[top_m] = replace(columns, thickness_m=thinner[:, None]).total(hanging, sun)
        return known[top_m]

    pending, nodes, worst = [(float(low), float(high))], [float(low)], 0.0
    while pending:
        bottom, top = pending.pop()
        middle = 0.5 * (bottom + top)
        ends = np.stack([at(altitude_m) for altitude_m in (bottom, middle, top)])
        guess = np.einsum("np,ncb->pcb", parabola(np.array(_BETWEEN)), ends)
        exact = np.stack([at(bottom + position * (top - bottom)) for position in _BETWEEN])
        error = SAFETY_FACTOR * largest_error(guess, exact)
        if error <= SHARE * accuracy.relative:
            nodes += [middle, top]
            worst = max(worst, error)
            continue
        inside = levels[(levels > bottom + _SHORTEST_M) & (levels < top - _SHORTEST_M)]
        split = float(inside[np.argmin(np.abs(inside - middle))]) if inside.size else middle
        pending += [(split, top), (bottom, split)]
        if len(nodes) + 2 * len(pending) > MAX_NODES or top - bottom < _SHORTEST_M:
            message = (
                f"{scenario.accuracy}: cloud tops from {low:g} to {high:g} m need more than {MAX_NODES} tables; "
                "allowed: a lower accuracy or a smaller range of altitudes"
            )
            raise ScenarioError([Problem("accuracy", message)], scenario.origin)
    return CloudTops(tuple(nodes), worst)
