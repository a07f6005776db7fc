"""Compile a plan into radiance tables: all spectral physics happens here, once per scene."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from hcss_twin.cube.variables import TERM_PREFIX
from hcss_twin.errors import Problem, ScenarioError
from hcss_twin.providers import Sun
from hcss_twin.scene.layer_pair import LayerPair, place_pair
from hcss_twin.scene.plan import Plan
from hcss_twin.scene.tables import InstantTable, Quantities, RadianceTables
from hcss_twin.scene.thickness_axis import Columns, ThicknessAxis, place_axis
from hcss_twin.scene.wave_table import compile_waves, probe_waves

Array = NDArray[np.float64]

TABLE_SHARE = 0.1
"""Share of the scenario's accuracy that interpolation between table nodes may use."""


LARGEST_TABLE_BYTES = 128_000_000
"""Of the table of two layers at one instant; three of them are held where the sun moves."""

LONGEST_TIME_STEP_S = 3600.0
"""Time nodes are at most this far apart where the sun matters."""


def compile_tables(plan: Plan) -> RadianceTables:
    """Compute band radiance against thickness, and against time where the sun moves enough to matter.

    Nodes are added until interpolation, measured between the nodes, errs by less than
    ``accuracy`` x ``TABLE_SHARE``, relative to the total radiance of the band. There is a table for each layer
    alone, and where two can have cloud one of both.

    Raises
    ------
    ProviderError
        If a provider fails at a state the scene needs.
    ScenarioError
        If the table of two layers would be too large for the accuracy asked for.
    """
    columns = _Columns(plan)
    tolerance = plan.scenario.accuracy * TABLE_SHARE
    times, time_error = _time_nodes(columns, plan, 0.5 * tolerance)
    sun = _sun(plan, times[len(times) // 2])
    axes: tuple[ThicknessAxis | None, ...] = tuple(
        place_axis(columns.alone(index, sun), layer, plan.profile.altitude_m, 0.5 * tolerance)
        if plan.cloudy_layers[index]
        else None
        for index, layer in enumerate(plan.layers)
    )
    error = max((axis.estimated_error for axis in axes if axis is not None), default=0.0)
    pair: LayerPair | None = None
    match axes:
        case (ThicknessAxis() as low, ThicknessAxis() as high):
            pair = place_pair(
                lambda thickness: columns.cloudy(thickness, sun),
                low,
                high,
                0.5 * tolerance,
                columns.wavenumbers,
            )
            _require_room(plan, pair, len(columns.quantities.names))
            axes, error = (pair.low, pair.high), max(error, pair.estimated_error)
    tables = tuple(columns.table(axes, pair, _sun(plan, time)) for time in times)
    waves = None
    if plan.waves is not None:
        suns = tuple(_sun(plan, time) for time in times)
        waves = compile_waves(plan, plan.waves, columns.quantities, suns, 0.5 * tolerance)
        error = max(error, waves.estimated_error)
    return RadianceTables(columns.quantities, times, axes, pair, tables, time_error + error, waves)


def _require_room(plan: Plan, pair: LayerPair, quantities: int) -> None:
    """Refuse an accuracy for which the table of two layers would not fit."""
    nodes = pair.low.dense_m.size * pair.high.dense_m.size
    size = nodes * quantities * len(plan.bands) * np.dtype(np.float32).itemsize
    if size <= LARGEST_TABLE_BYTES:
        return
    # The number of nodes goes with accuracy^-1/2 along each axis, roughly.
    possible = 1.2 * plan.scenario.accuracy * size / LARGEST_TABLE_BYTES
    digit = 10.0 ** np.floor(np.log10(possible))
    closest = np.ceil(possible / digit) * digit
    message = (
        f"{plan.scenario.accuracy:g} needs a table of {size / 1e6:.0f} MB for two cloud layers, {len(plan.bands)} "
        f"bands and {quantities - 1} terms; allowed: up to {LARGEST_TABLE_BYTES / 1e6:.0f} MB; closest valid choice "
        f"is about {closest:.0e}"
    )
    raise ScenarioError([Problem("accuracy", message)], plan.scenario.origin)


def _time_nodes(columns: _Columns, plan: Plan, tolerance: float) -> tuple[tuple[float, ...], float]:
    """Choose frames whose tables are computed, so that those between are their weighted means.

    Judged on the clear column and on the thinnest and thickest clouds of each layer and of both, which bound the
    weight of the solar terms. One frame where the sun does not matter.
    """
    times = plan.frame_times_s
    middle = times.size // 2
    if not plan.sun_matters or times.size == 1:
        return (float(times[middle]),), 0.0
    known = {frame: columns.probe(_sun(plan, float(times[frame]))) for frame in (0, times.size - 1)}
    change = float(np.max(np.abs(known[times.size - 1] / known[0] - 1.0)))
    near = times[-1] - times[0] <= LONGEST_TIME_STEP_S
    if change <= tolerance and near and _is_up(plan, 0) == _is_up(plan, times.size - 1):
        return (float(times[0]),), change
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
        terms = tuple(plan.model.terms)
        wanted = {spec.name.removeprefix(TERM_PREFIX) for spec in plan.variables}
        self._known: dict[tuple[Sun | None, tuple[float, ...]], Array] = {}
        self.quantities = Quantities(terms, tuple(name for name in terms if name in wanted))

    @property
    def wavenumbers(self) -> int:
        """Wavenumbers behind each column."""
        return self._grid.wavenumber_cm1.size

    def clear(self, sun: Sun | None) -> Array:
        """Terms of the clear column, (K, B)."""
        return self._to_bands(self._plan.model.clear(self._grid.wavenumber_cm1, sun))

    def cloudy(self, thickness_m: Array, sun: Sun | None) -> Array:
        """Terms of cloudy columns, (N, K, B), from the thickness of each layer, (N, L); each is computed once."""
        keys = [(sun, tuple(row)) for row in thickness_m.tolist()]
        new = [row for row, key in enumerate(keys) if key not in self._known]
        if new:
            found = self._plan.model.cloudy(self._grid.wavenumber_cm1, thickness_m[new], sun)
            for row, terms in zip(new, self._to_bands(found), strict=True):
                self._known[keys[row]] = terms
        return np.stack([self._known[key] for key in keys])

    def alone(self, index: int, sun: Sun | None) -> Columns:
        """Columns with cloud in one layer only, as a function of its thickness (N,)."""

        def columns(thickness_m: Array) -> Array:
            layers = np.zeros((thickness_m.size, len(self._plan.layers)))
            layers[:, index] = thickness_m
            return self.cloudy(layers, sun)

        return columns

    def probe(self, sun: Sun | None) -> Array:
        """Total of a few columns that bound the scene, (N, B)."""
        clear: Array = np.sum(self.clear(sun), axis=0)[None, :]
        if self._plan.waves is not None:
            clear = np.concatenate((clear, probe_waves(self._plan, self._plan.waves, sun)))
        extremes = self._plan.extreme_thicknesses_m
        if extremes.shape[0] == 0:
            return clear
        cloudy: Array = np.sum(self.cloudy(extremes, sun), axis=1)
        return np.concatenate((clear, cloudy))

    def table(
        self, axes: tuple[ThicknessAxis | None, ...], pair: LayerPair | None, sun: Sun | None
    ) -> InstantTable:
        """Table of one instant."""
        clear = self.quantities.of(self.clear(sun))
        return InstantTable(
            clear,
            tuple(
                np.empty((0, *clear.shape))
                if axis is None
                else self.quantities.of(axis.sample(self.alone(index, sun)))
                for index, axis in enumerate(axes)
            ),
            None
            if pair is None
            else pair.exact(lambda thickness: self.cloudy(thickness, sun), self.wavenumbers),
        )

    def _to_bands(self, terms: Mapping[str, Array]) -> Array:
        """Integrate spectra (..., V) over the bands and stack the terms: (..., K, B)."""
        weights = self._grid.weights_cm1.T
        return np.stack([np.asarray(terms[name]) @ weights for name in self.quantities.terms], axis=-2)
