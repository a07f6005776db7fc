"""Compilation of a plan to radiance tables: all spectral computation, once per scene."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

from hcss_twin.core.cache import TABLES, recall_or_compute
from hcss_twin.core.errors import Problem, ScenarioError
from hcss_twin.core.one_thread import in_one_thread
from hcss_twin.engine.tables.columns import BandColumns, ExactColumns
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
from hcss_twin.engine.tables.table_key import table_key
from hcss_twin.engine.tables.thickness_axis import Source, ThicknessAxis, place_axis
from hcss_twin.engine.tables.time_nodes import time_nodes
from hcss_twin.engine.tables.waves import compile_waves
from hcss_twin.models.radiance.spectral_grid import SpectralNodes
from hcss_twin.plan.accuracy import Budget
from hcss_twin.plan.numerics import MANY_STREAMS, for_spectra
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.views import EDGES, EXTREMES, views_over_image
from hcss_twin.providers import Sun, View

LARGEST_TABLE_BYTES = 128_000_000
"""Maximum size of the table of two layers at one instant; memory holds three of them if the sun moves."""

PLACED_SHARE = 0.5
"""Share of the tolerance in thickness for columns toward extreme views; the rest is for those derived from them."""

VIEWS_AT_ONCE = 32
"""Views whose columns are computed in one call; the memory grows with their number."""


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
    over_image = views_over_image(plan.assembly) if may_compile_together(plan) else None
    if over_image is not None and plan.views is not None:
        nodes = over_image.at(plan.views.places)
        together = _tables(plan, nodes, over_image.at(EXTREMES), over_image.at(EDGES))
        return together or tables_over_views(plan, compile_tables)
    if plan.views is not None:
        return tables_over_views(plan, compile_tables)
    alone = _tables(plan, [plan.view], [plan.view])
    assert alone is not None
    return alone


def may_compile_together(plan: Plan) -> bool:
    """Whether the views of a plan can share wavenumbers and thicknesses: one air, one sun, cloud in one layer."""
    one = plan.assembly.air_over_field is None and plan.assembly.own_suns is None
    return plan.views is not None and one and sum(plan.assembly.cloudy_layers) <= 1


def _tables(
    plan: Plan, views: Sequence[View], extreme: Sequence[View], edges: Sequence[View] = ()
) -> RadianceTables | None:
    """Return the tables of some views with one choice of wavenumbers, instants and thicknesses.

    It is made toward extreme views. Toward the others, columns are combinations of those toward the corners, the
    middles of the edges and the middle of the image, fitted at few thicknesses: toward 63 views over 250 km, five
    thicknesses leave 1.3e-5 of the radiance in any band (2e-4 from corners and middle alone).

    Returns
    -------
    RadianceTables or None
        None if the sun moves over a grid on the ground with several views.
    """
    allowed, several = plan.budget, plan.views is not None
    # The shape of spectra hardly depends on the numerical level; the certificate includes what remains.
    few_streams = dataclasses.replace(plan, assembly=for_spectra(plan.assembly))
    spectrum = choose_spectrum(few_streams, allowed.wavenumbers, extreme, edges or extreme)
    columns = BandColumns(plan, spectrum.nodes)
    times, time_error = time_nodes(columns.of(few_streams), extreme, allowed.time)
    if several and len(times) > 1 and plan.is_grid:
        return None
    suns = [plan.sun_at(time_s) for time_s in times]
    placing = columns.toward(extreme, [suns[len(suns) // 2]])
    source = Source(plan.assembly.entries["radiance"].label, columns.quantities.terms)
    # Where nodes must lie hardly depends on the numerical level, either: those of many columns are placed with few
    # streams, whose columns differ little and smoothly from those of the tables.
    many = plan.assembly.numerical_level + plan.assembly.sunlight_steps >= MANY_STREAMS
    placed = columns.of(few_streams) if many and np.count_nonzero(plan.assembly.cloudy_layers) > 1 else columns
    levels, share = plan.assembly.profile.altitude_m, (PLACED_SHARE if several else 1.0) * allowed.thickness
    axes: tuple[ThicknessAxis | None, ...] = tuple(
        place_axis(placed.alone(index, placing), layer, levels, share, source) if cloudy else None
        for index, (layer, cloudy) in enumerate(zip(plan.layers, plan.assembly.cloudy_layers, strict=True))
    )
    alone_error = max((axis.estimated_error for axis in axes if axis is not None), default=0.0)
    pair: LayerPair | None = None
    match axes:
        case (ThicknessAxis() as low, ThicknessAxis() as high):
            pair = place_pair(
                lambda h: placed.cloudy(h, placing)[0], low, high, allowed.two_layers, source, plan.layers
            )
            _require_room(plan, pair, len(columns.quantities.names))
            axes = (pair.low, pair.high)
    drift = allowed.other_instants if len(times) > 1 or placed is not columns else 0.0
    near = (*extreme, *edges)
    under = _under_suns(columns, placed, axes, pair, near, suns, drift)
    every = []
    for start in range(0, len(views), VIEWS_AT_ONCE):
        some = views[start : start + VIEWS_AT_ONCE]
        settings = columns.toward(some, suns)
        exact = [under[sun][0] for sun in suns]
        if several:
            known = [[under[sun][number] for sun in suns for _ in some] for number in range(len(near))]
            exact = columns.exact(axes, pair, settings, known, allowed.thickness - share)
        tables = columns.tables(axes, exact, settings)
        for number, view in enumerate(some):
            at = slice(number, None, len(some))
            texture = None
            if plan.texture is not None:
                texture = _texture(columns.of(plan.toward(view)), axes, pair, exact[at], settings[at])
            every.append((tables[at], texture))
    waves = None
    if plan.waves is not None:
        waves = compile_waves(plan, plan.waves, columns.quantities, tuple(suns), allowed.waves)
    shadows = None
    if plan.has_shadows:
        shadows = compile_shadows(plan, columns.quantities, times, columns.clear(columns.toward(views[:1], suns)))
    errors = Budget(
        numerics=plan.numerics.error,
        spectral_grid=plan.grid_refinement.error,
        wavenumbers=spectrum.estimated_error,
        thickness=alone_error + allowed.thickness - share if alone_error else 0.0,
        two_layers=0.0 if pair is None else pair.estimated_error,
        waves=0.0 if waves is None else waves.estimated_error,
        views=0.0 if plan.views is None else plan.views.estimated_error,
        shadows=0.0 if shadows is None else allowed.shadows,
        time=time_error,
        other_instants=drift,
        faint_sunlight=plan.faint_sunlight or 0.0,
    )
    of_views = tuple(
        RadianceTables(columns.quantities, times, axes, pair, tables, spectrum, errors, shadows, waves, texture)
        for tables, texture in every
    )
    return dataclasses.replace(of_views[0], over_views=of_views) if several else of_views[0]


def _under_suns(
    columns: BandColumns,
    placed: BandColumns,
    axes: tuple[ThicknessAxis | None, ...],
    pair: LayerPair | None,
    views: Sequence[View],
    suns: Sequence[Sun | None],
    drift: float,
) -> dict[Sun | None, list[ExactColumns]]:
    """Return the columns toward some views under each sun: of the middle instant, then others, which differ little."""
    middle, tolerance = suns[len(suns) // 2], columns.plan.budget.other_instants
    settings, others = columns.toward(views, [middle]), [sun for sun in suns if sun != middle]
    few = [placed.exact(axes, pair, settings)] if placed is not columns else []
    first = columns.exact(axes, pair, settings, few, tolerance, smooth=False)
    if not others:
        return {middle: first}
    away = columns.exact(axes, pair, columns.toward(views, others), [first * len(others)], drift)
    return {middle: first} | {sun: away[n * len(views) : (n + 1) * len(views)] for n, sun in enumerate(others)}


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
