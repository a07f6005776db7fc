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


LONGEST_TIME_STEP_S = 3600.0
"""Time nodes are at most this far apart where the sun matters."""


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
    sun = _sun(plan, float(plan.frame_times_s[plan.frame_times_s.size // 2]))
    axis = None
    if plan.layer is not None and plan.has_cloud:
        axis = place_axis(
            lambda thickness: columns.cloudy(thickness, sun),
            plan.layer,
            plan.profile.altitude_m,
            0.5 * tolerance,
        )
    times, error = _time_nodes(columns, plan, 0.5 * tolerance)
    tables = tuple(columns.table(axis, _sun(plan, time)) for time in times)
    return RadianceTables(times, tables, error + (axis.estimated_error if axis else 0.0))


def _time_nodes(columns: _Columns, plan: Plan, tolerance: float) -> tuple[tuple[float, ...], float]:
    """Choose frames whose tables are computed, so that those between are their weighted means.

    Judged on the clear column and on the thinnest and thickest clouds, which bound the weight of the
    solar terms. One frame where the sun does not matter.
    """
    times = plan.frame_times_s
    middle = times.size // 2
    if not plan.sun_matters or times.size == 1:
        return (float(times[middle]),), 0.0
    known = {frame: columns.probe(_sun(plan, float(times[frame]))) for frame in (0, times.size - 1)}
    pending, worst = [(0, times.size - 1)], 0.0
    while pending:
        low, high = pending.pop()
        if high - low < 2:
            continue
        middle = (low + high) // 2
        exact = columns.probe(_sun(plan, float(times[middle])))
        weight = (times[middle] - times[low]) / (times[high] - times[low])
        error = float(np.max(np.abs(((1 - weight) * known[low] + weight * known[high]) / exact - 1.0)))
        # One agreement in the middle proves nothing over a day: noon, noon and noon agree.
        near = times[high] - times[low] <= LONGEST_TIME_STEP_S
        if error <= tolerance and near and _is_up(plan, low) == _is_up(plan, high):
            worst = max(worst, error)
            continue
        known[middle] = exact
        pending += [(low, middle), (middle, high)]
    return tuple(float(times[frame]) for frame in sorted(known)), worst


def _is_up(plan: Plan, frame: int) -> bool:
    return bool(plan.sun_zenith_deg[frame] < 90.0)


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
        self._terms = tuple(plan.model.terms)
        wanted = {spec.name.removeprefix(TERM_PREFIX) for spec in plan.variables}
        self._requested = [name for name in self._terms if name in wanted]

    def clear(self, sun: Sun | None) -> Array:
        """Terms of the clear column, (K, B)."""
        return self._to_bands(self._plan.model.clear(self._grid.wavenumber_cm1, sun))

    def cloudy(self, thickness_m: Array, sun: Sun | None) -> Array:
        """Terms of cloudy columns, (N, K, B)."""
        return self._to_bands(self._plan.model.cloudy(self._grid.wavenumber_cm1, thickness_m, sun))

    def probe(self, sun: Sun | None) -> Array:
        """Total of a few columns that bound the scene, (N, B)."""
        clear: Array = np.sum(self.clear(sun), axis=0)[None, :]
        layer = self._plan.layer
        if layer is None or not self._plan.has_cloud:
            return clear
        extremes = np.array([layer.thickness_min_m, layer.thickness_max_m])
        cloudy: Array = np.sum(self.cloudy(extremes, sun), axis=1)
        return np.concatenate((clear, cloudy))

    def table(self, axis: ThicknessAxis | None, sun: Sun | None) -> ThicknessTable:
        """Table of one instant."""
        clear = self._named(self.clear(sun))
        if axis is None:
            return ThicknessTable(np.empty(0), clear, {})
        cloudy = axis.sample(lambda thickness: self.cloudy(thickness, sun))
        return ThicknessTable(axis.dense_m, clear, self._named(cloudy))

    def _named(self, terms: Array) -> dict[str, Array]:
        """Total and requested terms by name, from (..., K, B) to (..., B)."""
        named = {TOTAL: np.sum(terms, axis=-2)}
        named.update({name: terms[..., self._terms.index(name), :] for name in self._requested})
        return named

    def _to_bands(self, terms: Mapping[str, Array]) -> Array:
        """Integrate spectra (..., V) over the bands and stack the terms: (..., K, B)."""
        weights = self._grid.weights_cm1.T
        return np.stack([np.asarray(terms[name]) @ weights for name in self._terms], axis=-2)
