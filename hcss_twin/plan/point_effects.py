"""Effects of points that packages bring: at how many values of each there are tables.

Radiance against the value is a polynomial between few of them, whose error is measured for a few columns.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.plan.accuracy import RequestedAccuracy
from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.axis import Axis, PlacedAxis
from hcss_twin.plan.effects import Effect
from hcss_twin.plan.few_columns import few_columns
from hcss_twin.plan.point_nodes import WAVENUMBERS, place_point_nodes
from hcss_twin.plan.section_effect import SectionEffect
from hcss_twin.providers import Sun
from hcss_twin.scenario.scenario import Scenario

MAX_NODES = 65


@dataclass(frozen=True)
class PlannedPointEffect(Effect):
    """Values of an effect with tables."""

    kind = "point effect"

    effect: SectionEffect
    placed: PlacedAxis

    def described(self) -> Mapping[str, Any]:
        """Return values and error, by the name of the section."""
        return {self.effect.name: {"nodes": self.placed.nodes.tolist(), "estimated_error": self.placed.error}}


def plan_point_effect(
    scenario: Scenario, assembly: Assembly, effect: SectionEffect, accuracy: RequestedAccuracy, sun: Sun | None
) -> PlannedPointEffect:
    """Choose the values with tables.

    Raises
    ------
    ScenarioError
        If more than ``MAX_NODES`` are needed.
    """
    columns, given = few_columns(assembly, WAVENUMBERS), effect.given

    def at(values: Array) -> Array:
        totals = [columns.total(assembly.altered(effect, value), sun) for value in values.tolist()]
        return np.stack(totals)[:, :, None]

    axis, what = Axis(given.low, given.high, given.kinks), f"'{effect.name}' from {given.low:g} to {given.high:g}"
    return PlannedPointEffect(effect, place_point_nodes(scenario, accuracy, axis, at, what, (1, 2, 4, 8), MAX_NODES))


def extremes_of(assembly: Assembly, effects: Sequence[SectionEffect]) -> list[Assembly]:
    """Return the scene with each effect alone at either end of its range."""
    return [assembly.altered(effect, value) for effect in effects for value in (effect.given.low, effect.given.high)]
