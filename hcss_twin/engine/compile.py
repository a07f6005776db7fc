"""Compilation of a plan to radiance tables: all spectral computation, once per scene."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.cache import TABLES, recall_or_compute, result_key
from hcss_twin.core.errors import Problem, ScenarioError
from hcss_twin.core.one_thread import in_one_thread
from hcss_twin.cube.variables import TERM_PREFIX
from hcss_twin.engine.tables.columns import BandColumns
from hcss_twin.engine.tables.layer_pair import LayerPair, place_pair
from hcss_twin.engine.tables.over_views import tables_over_views
from hcss_twin.engine.tables.radiance_tables import (
    InstantTable,
    Quantities,
    RadianceTables,
    ShadowTables,
    TextureTables,
    WaveTables,
)
from hcss_twin.engine.tables.scene_states import point_states
from hcss_twin.engine.tables.shadows import compile_shadows
from hcss_twin.engine.tables.spectrum import Spectrum, choose_spectrum
from hcss_twin.engine.tables.thickness_axis import Source, ThicknessAxis, place_axis
from hcss_twin.engine.tables.views_together import may_compile_together, tables_together
from hcss_twin.engine.tables.waves import compile_waves
from hcss_twin.models.radiance.spectral_grid import SpectralNodes
from hcss_twin.plan.accuracy import Budget
from hcss_twin.plan.air_over_field import PlacedView
from hcss_twin.plan.assembly import expect
from hcss_twin.plan.numerics import MANY_STREAMS, for_spectra
from hcss_twin.plan.plan import Plan
from hcss_twin.providers.registry.specs import Kind

LARGEST_TABLE_BYTES = 128_000_000
"""Maximum size of the table of two layers at one instant; memory holds three of them if the sun moves."""

LONGEST_TIME_STEP_S = 3600.0
"""Maximum interval between time nodes if the motion of the sun matters."""


@in_one_thread
def compile_tables(plan: Plan) -> RadianceTables:
    """Compute band radiance as a function of thickness, and of time if the motion of the sun matters.

    Nodes are added until the interpolation error, measured between the nodes relative to the total band radiance, is
    within the plan's budget. There is a table for each layer alone and, if two can have cloud, one for both; if view
    angles vary over the image, there is such a set for each of several views.

    Raises
    ------
    ProviderError
        If a provider fails at a required state.
    ScenarioError
        If the table of two layers would be too large at the requested accuracy.
    """
    states = point_states(plan)
    if states is not None:
        return states.tables(compile_tables)
    if plan.views is not None:
        together = tables_together(plan, _time_nodes, _texture) if may_compile_together(plan) else None
        return together or tables_over_views(plan, compile_tables)
    allowed = plan.budget
    # The shape of spectra hardly depends on the numerical level; the certificate includes what remains.
    few_streams = dataclasses.replace(plan, assembly=for_spectra(plan.assembly))
    spectrum = choose_spectrum(few_streams, allowed.wavenumbers)
    columns = BandColumns(plan, spectrum.nodes)
    times, time_error = _time_nodes(columns.of(few_streams), plan, allowed.time)
    placing = times[len(times) // 2]
    sun = plan.sun_at(placing)
    source = Source(plan.assembly.entries["radiance"].label, columns.quantities.terms)
    # Where nodes must lie hardly depends on the numerical level, either: those of many columns are placed with few
    # streams, whose columns differ little and smoothly from those of the tables.
    many = plan.assembly.numerical_level + plan.assembly.sunlight_steps >= MANY_STREAMS
    placed = columns.of(few_streams) if many and np.count_nonzero(plan.assembly.cloudy_layers) > 1 else columns
    axes: tuple[ThicknessAxis | None, ...] = tuple(
        place_axis(placed.alone(index, sun), layer, plan.assembly.profile.altitude_m, allowed.thickness, source)
        if plan.assembly.cloudy_layers[index]
        else None
        for index, layer in enumerate(plan.layers)
    )
    alone_error = max((axis.estimated_error for axis in axes if axis is not None), default=0.0)
    pair: LayerPair | None = None
    match axes:
        case (ThicknessAxis() as low, ThicknessAxis() as high):
            pair = place_pair(
                lambda thickness: placed.cloudy(thickness, sun), low, high, allowed.two_layers, source, plan.layers
            )
            _require_room(plan, pair, len(columns.quantities.names))
            axes = (pair.low, pair.high)
    drift = allowed.other_instants if len(times) > 1 or placed is not columns else 0.0
    few = placed.exact(axes, pair, sun) if placed is not columns else None
    first = columns.exact(axes, pair, sun, few=few, tolerance=allowed.other_instants)
    suns = tuple(plan.sun_at(time) for time in times)
    exact = [
        first if time == placing else columns.exact(axes, pair, other, [first], drift)
        for time, other in zip(times, suns, strict=True)
    ]
    tables = tuple(columns.table(axes, solved, other) for solved, other in zip(exact, suns, strict=True))
    texture = None if plan.texture is None else _texture(columns, axes, pair, exact, suns)
    waves = None
    if plan.waves is not None:
        waves = compile_waves(plan, plan.waves, columns.quantities, suns, allowed.waves)
    shadows = compile_shadows(plan, columns.quantities, times, columns.clear)
    errors = Budget(
        numerics=plan.numerics.error,
        spectral_grid=plan.grid_refinement.error,
        wavenumbers=spectrum.estimated_error,
        thickness=alone_error,
        two_layers=0.0 if pair is None else pair.estimated_error,
        waves=0.0 if waves is None else waves.estimated_error,
        shadows=0.0 if shadows is None else allowed.shadows,
        time=time_error,
        other_instants=drift,
        faint_sunlight=plan.faint_sunlight or 0.0,
    )
    return RadianceTables(columns.quantities, times, axes, pair, tables, spectrum, errors, shadows, waves, texture)


def _texture(*columns: Any) -> TextureTables | None:
    from hcss_twin.engine.tables.texture import compile_texture  # not for scenes without texture

    return compile_texture(*columns)


def _require_room(plan: Plan, pair: LayerPair, quantities: int) -> None:
    """Reject an accuracy for which the table of two layers would be too large."""
    nodes = pair.low.dense_m.size * pair.high.dense_m.size
    size = nodes * quantities * len(plan.bands) * np.dtype(np.float32).itemsize
    if size <= LARGEST_TABLE_BYTES:
        return
    # The number of nodes along each axis scales roughly as accuracy^-1/2.
    possible = 1.2 * plan.accuracy.relative * size / LARGEST_TABLE_BYTES
    digit = 10.0 ** np.floor(np.log10(possible))
    closest = np.ceil(possible / digit) * digit
    message = (
        f"{plan.accuracy.relative:g} needs a table of {size / 1e6:.0f} MB for two cloud layers, {len(plan.bands)} "
        f"bands and {quantities - 1} terms; allowed: up to {LARGEST_TABLE_BYTES / 1e6:.0f} MB; closest valid choice "
        f"is about {closest:.0e}"
    )
    raise ScenarioError([Problem("accuracy", message)], plan.scenario.origin)


def _time_nodes(columns: BandColumns, plan: Plan, tolerance: float) -> tuple[tuple[float, ...], float]:
    """Choose the frames with computed tables; those between are linearly interpolated.

    Evaluated for the clear column and for the thinnest and thickest clouds of each layer and of both, which bound the
    weight of the solar terms. Returns one frame if the sun does not matter. The columns may have few streams: how they
    change as the sun moves hardly depends on the numerical level.
    """
    times = plan.frame_times_s
    middle = times.size // 2
    if not plan.sun_matters or times.size == 1:
        return (float(times[middle]),), 0.0
    _expect(columns.plan, [0, (times.size - 1) // 2, middle, times.size - 1])
    known = {frame: columns.probe(plan.sun_at(float(times[frame]))) for frame in (0, times.size - 1)}
    change = _largest_share(known[times.size - 1] - known[0], known[0])
    near = times[-1] - times[0] <= LONGEST_TIME_STEP_S
    if 0.6 * change <= tolerance and near and _is_up(plan, 0) == _is_up(plan, times.size - 1):
        # Half the change on either side; over less than an hour the change is nearly linear.
        _expect(plan, [])
        return (float(times[middle]),), 0.6 * change
    pending, worst = [(0, times.size - 1)], 0.0
    while pending:
        intervals, pending = [(low, high) for low, high in pending if high - low > 1], []
        if len(intervals) > 1:
            _expect(columns.plan, [(low + high) // 2 for low, high in intervals])
        for low, high in intervals:
            middle = (low + high) // 2
            exact = columns.probe(plan.sun_at(float(times[middle])))
            weight = (times[middle] - times[low]) / (times[high] - times[low])
            error = _largest_share((1 - weight) * known[low] + weight * known[high] - exact, exact)
            # Over days, agreement at the middle alone proves nothing: the noons of three days agree.
            near = times[high] - times[low] <= LONGEST_TIME_STEP_S
            if error <= tolerance and near and _is_up(plan, low) == _is_up(plan, high):
                worst = max(worst, error)
                continue
            known[middle] = exact
            pending += [(low, middle), (middle, high)]
    _expect(plan, sorted(known))
    return tuple(float(times[frame]) for frame in sorted(known)), worst


def _expect(plan: Plan, frames: list[int]) -> None:
    expect(plan.assembly.model, [plan.sun_at(float(plan.frame_times_s[frame])) for frame in frames])


def _largest_share(difference: Array, whole: Array) -> float:
    """Largest difference relative to the total; infinite if the total is 0."""
    away, lit = np.abs(difference), whole != 0.0
    return float(np.max(away[lit] / np.abs(whole[lit]), initial=0.0)) if np.all(away[~lit] == 0.0) else np.inf


def _is_up(plan: Plan, frame: int) -> bool:
    return bool(plan.sun_zenith_deg[frame] < 90.0)


CLASSES = (
    RadianceTables,
    Budget,
    Quantities,
    ThicknessAxis,
    LayerPair,
    InstantTable,
    ShadowTables,
    WaveTables,
    TextureTables,
    Spectrum,
    SpectralNodes,
)
"""Dataclasses that occur in tables."""


def tables_of(plan: Plan, compiler: Callable[[Plan], RadianceTables] | None = None) -> RadianceTables:
    """Return the tables of a plan, from the cache (bit-identical) or newly compiled.

    Parameters
    ----------
    compiler : callable, optional
        Compiles new tables; replaceable, for example to count compilations.
    """
    states = point_states(plan)
    if states is not None:
        return states.tables(partial(tables_of, compiler=compiler))
    if plan.views is not None and not may_compile_together(plan):
        return tables_over_views(plan, partial(tables_of, compiler=compiler))
    compute = partial(compiler or compile_tables, plan)
    return recall_or_compute(TABLES, table_key(plan), plan.catalog, compute, CLASSES)


INDEPENDENT = ("title", "seed", "image", "clouds", "elements", "surfaces", "output", "sensor")
"""Sections of a scenario that do not affect tables, except through the plan."""


def table_key(plan: Plan) -> str:
    """Return a hash of everything the tables of a plan depend on."""
    scenario, assembly = json.loads(plan.scenario.to_json()), plan.assembly
    independent = (*INDEPENDENT, *plan.scenario.sections)
    for key in ("light", "light_profile", "light_accuracy"):  # what is added to the tables
        scenario["radiance"].pop(key)
    parts: dict[str, Any] = {
        "scenario": {name: value for name, value in scenario.items() if name not in independent},
        "accuracy": plan.accuracy.relative,
        "numerics": [
            plan.assembly.numerical_level,
            plan.numerics.sunlight_steps,
            plan.numerics.error,
            dataclasses.astuple(plan.grid_refinement),
        ],
        "view": [plan.view.zenith_deg, plan.view.azimuth_deg],
        "files": dict(plan.catalog.used),
        "terms": [spec.name for spec in plan.computed if spec.name.startswith(TERM_PREFIX)],
        "sunlight": [plan.sun_matters, plan.faint_sunlight],
        "layers": [
            dataclasses.asdict(dataclasses.replace(layer, coverage=float(cloudy), edge_taper=0.0, name=""))
            for layer, cloudy in zip(plan.layers, assembly.cloudy_layers, strict=True)
        ],
        "code": {
            name: code
            for name, code in assembly.code.items()
            if assembly.entries[name].kind not in (Kind.CLOUDS, Kind.ELEMENTS, Kind.SURFACES, Kind.VARIABLES)
        },
    }
    if assembly.between is not None:
        parts["between"] = assembly.between.nodes_K
    for effect in plan.effects:
        parts |= effect.key(scenario, assembly)
    if isinstance(plan.view, PlacedView):
        parts["place"] = [plan.view.latitude_deg, plan.view.longitude_deg]
    surface = assembly.surface
    if surface is not None:
        parts["surface"] = [surface.name, surface.temperature_K]
        if surface.boundary is not None:  # it may depend on all inputs of the provider
            parts["surfaces"] = [scenario["surfaces"], scenario["image"], assembly.code[str(Kind.SURFACES)]]
    layer_optics = [layer.get("optics") for layer in scenario["clouds"]["layers"]]
    if any(layer_optics):
        parts["optics"] = [[layer[key] for key in ("type", "base", "top")] for layer in scenario["clouds"]["layers"]]
        parts["optics"] += layer_optics
    return result_key(parts, plan.catalog.shelf)
