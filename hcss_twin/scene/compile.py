"""Compile a plan into radiance tables: all spectral physics happens here, once per scene."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from hcss_twin.cube.variables import TERM_PREFIX
from hcss_twin.providers import Sun
from hcss_twin.scene.plan import Plan
from hcss_twin.scene.tables import TOTAL, RadianceTables, ThicknessTable
from hcss_twin.scene.thickness_axis import ThicknessAxis, place_axis

Array = NDArray[np.float64]

TABLE_SHARE = 0.1
"""Share of the scenario's accuracy that interpolation between table nodes may use."""

SHORTEST_TIME_STEP_S = 1.0
"""Time nodes are never closer: in a second the sun moves by 0.004 deg."""


def compile_tables(plan: Plan) -> RadianceTables:
    """Compute band radiance against thickness, and against time where the sun moves enough to matter.

    Nodes are added until interpolation, measured between the nodes, errs by less than
    ``accuracy`` x ``TABLE_SHARE``, relative to the total radiance of the band.

    Raises
    ------
    ProviderError
        If a provider fails at a state the scene needs.
    """
    columns = _Columns(plan)
    tolerance = plan.scenario.accuracy * TABLE_SHARE
    first, last = float(plan.frame_times_s[0]), float(plan.frame_times_s[-1])
    sun = _sun(plan, 0.5 * (first + last))
    axis = None
    if plan.layer is not None:
        axis = place_axis(
            lambda thickness: columns.cloudy(thickness, sun),
            TOTAL,
            plan.layer,
            plan.profile.altitude_m,
            0.5 * tolerance,
        )
    times, error = _time_nodes(columns, plan, first, last, 0.5 * tolerance)
    tables = tuple(columns.table(axis, _sun(plan, time)) for time in times)
    return RadianceTables(times, tables, error + (axis.estimated_error if axis else 0.0))


def _time_nodes(
    columns: _Columns, plan: Plan, first_s: float, last_s: float, tolerance: float
) -> tuple[tuple[float, ...], float]:
    """Place time nodes so that radiance between two of them is their weighted mean.

    Judged on the clear column and on the thinnest and thickest clouds, which bound the weight of the
    solar terms. One node where the sun does not matter.
    """
    if not plan.sun_matters or first_s == last_s:
        return (0.5 * (first_s + last_s),), 0.0
    known: dict[float, Array] = {time: columns.probe(_sun(plan, time)) for time in (first_s, last_s)}
    pending, worst = [(first_s, last_s)], 0.0
    while pending:
        low, high = pending.pop()
        middle = 0.5 * (low + high)
        exact = columns.probe(_sun(plan, middle))
        error = float(np.max(np.abs(0.5 * (known[low] + known[high]) / exact - 1.0)))
        if error <= tolerance or high - low <= SHORTEST_TIME_STEP_S:
            worst = max(worst, error)
            continue
        known[middle] = exact
        pending += [(low, middle), (middle, high)]
    return tuple(sorted(known)), worst


def _sun(plan: Plan, time_s: float) -> Sun | None:
    """Sun at a time, None below the horizon."""
    if not plan.sun_matters:
        return None
    sun = plan.sun_track.at(time_s)
    return sun if sun.is_up else None


class _Columns:
    """Columns of a plan's radiance model, integrated over its bands."""

    def __init__(self, plan: Plan) -> None:
        self._plan = plan
        self._grid = plan.spectral_grid
        self._terms = [
            spec.name.removeprefix(TERM_PREFIX)
            for spec in plan.variables
            if spec.name.startswith(TERM_PREFIX)
        ]

    def clear(self, sun: Sun | None) -> dict[str, Array]:
        """Total and requested terms of the clear column, (B,)."""
        return self._to_bands(self._plan.model.clear(self._grid.wavenumber_cm1, sun))

    def cloudy(self, thickness_m: Array, sun: Sun | None) -> dict[str, Array]:
        """Total and requested terms of cloudy columns, (N, B)."""
        return self._to_bands(self._plan.model.cloudy(self._grid.wavenumber_cm1, thickness_m, sun))

    def probe(self, sun: Sun | None) -> Array:
        """Total of a few columns that bound the scene, (N, B)."""
        clear = self.clear(sun)[TOTAL][None, :]
        layer = self._plan.layer
        if layer is None:
            return clear
        extremes = np.array([layer.thickness_min_m, layer.thickness_max_m])
        return np.concatenate((clear, self.cloudy(extremes, sun)[TOTAL]))

    def table(self, axis: ThicknessAxis | None, sun: Sun | None) -> ThicknessTable:
        """Table of one instant."""
        clear = self.clear(sun)
        if axis is None:
            return ThicknessTable(np.empty(0), clear, {})
        return ThicknessTable(axis.dense_m, clear, axis.sample(lambda thickness: self.cloudy(thickness, sun)))

    def _to_bands(self, terms: Mapping[str, Array]) -> dict[str, Array]:
        weights = self._grid.weights_cm1.T
        bands = {name: np.asarray(spectrum) @ weights for name, spectrum in terms.items()}
        result = {TOTAL: np.sum(np.stack(list(bands.values())), axis=0)}
        result.update({name: bands[name] for name in self._terms})
        return result
