"""Compilation of a plan to radiance tables: all spectral computation, once per scene."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from hcss_twin.core.cache import TABLES, Store, recall_or_compute
from hcss_twin.core.one_thread import in_one_thread
from hcss_twin.engine.tables.columns import Axes, BandColumns
from hcss_twin.engine.tables.over_views import plans_over_views
from hcss_twin.engine.tables.radiance_tables import (
    NO_WAVES,
    InstantTable,
    Quantities,
    RadianceTables,
    ShadowTables,
    TextureTables,
    WaveTables,
    with_largest_errors,
)
from hcss_twin.engine.tables.scene_axes import point_axes
from hcss_twin.engine.tables.shadows import compile_shadows
from hcss_twin.engine.tables.spectrum import Spectrum, choose_spectrum
from hcss_twin.engine.tables.table_key import table_key
from hcss_twin.engine.tables.tensor_train import TensorTrain
from hcss_twin.engine.tables.thickness_axis import Source, ThicknessAxis, first_nodes, place_thickness
from hcss_twin.engine.tables.time_nodes import time_nodes
from hcss_twin.engine.tables.waves import compile_waves
from hcss_twin.models.radiance.spectral_grid import SpectralNodes
from hcss_twin.plan.accuracy import Budget
from hcss_twin.plan.numerics import MANY_STREAMS, for_spectra
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import ColumnSetting, Sun, View

__all__ = ["tables_of"]

COARSE_SPECTRA = 1e-4
"""Tolerance from which on wavenumbers are chosen with the fewest streams, which adds up to 5e-5."""

PLACED_SHARE = 0.5
"""Share of the tolerance in thickness for columns toward extreme views; the rest is for those derived from them."""

VIEWS_AT_ONCE = 32
"""Views whose columns are computed in one call, about; the memory grows with their number."""

CROSS_SHARE = 0.2
"""Share of the tolerance of several layers for completing their product from some of its lines."""


@in_one_thread
def compile_tables(plan: Plan) -> RadianceTables:
    """Compute band radiance as a function of thickness, and of time if the motion of the sun matters.

    Nodes are added until the interpolation error, measured between the nodes relative to the total band radiance, is
    within the plan's budget. If points differ in more than their clouds, there are such tables at each node of the axes
    along which they do.

    Raises
    ------
    ProviderError
        If a provider fails at a required state.
    """
    return _over_axes(plan, compile_tables) or _tables_of_views(plan) or _over_views(plan, compile_tables)


def _over_axes(plan: Plan, tables_of: Callable[[Plan], RadianceTables]) -> RadianceTables | None:
    """Return the tables at all nodes of the first axis; None if all points are alike but for views."""
    for axis in point_axes(plan):
        over = tuple(tables_of(axis.plan_in(plan, state)) for state in axis.nodes)
        return dataclasses.replace(with_largest_errors(over), over=over, over_error=axis.estimated_error)
    return None


def _over_views(plan: Plan, tables_of: Callable[[Plan], RadianceTables]) -> RadianceTables:
    """Return the tables toward all views, each computed alone."""
    over = tuple(tables_of(toward) for toward in plans_over_views(plan))
    largest = with_largest_errors(over)
    errors = dataclasses.replace(largest.errors, views=plan.views.estimated_error)
    return dataclasses.replace(largest, errors=errors, over=over)


def _tables_of_views(plan: Plan) -> RadianceTables | None:
    """Return the tables toward all views, computed together; None if each needs its own air or sun."""
    axis = plan.views
    if not axis.together(plan.assembly):
        return None
    views = axis.over(plan.assembly)
    of_spectra = [views.at(places) for places in axis.of_spectra]
    return _tables(plan, views.at(axis.places), views.at(axis.extremes), views.at(axis.edges), *of_spectra)


def _tables(
    plan: Plan,
    views: Sequence[View],
    extreme: Sequence[View],
    edges: Sequence[View],
    fitted: Sequence[View],
    tried: Sequence[View],
) -> RadianceTables:
    """Return the tables of some views with one choice of wavenumbers, instants and thicknesses.

    It is made toward extreme views. Toward the others, columns are combinations of those toward the corners, the
    middles of the edges and the middle of the image, fitted at few thicknesses: toward 63 views over 250 km, five
    thicknesses leave 1.3e-5 of the radiance in any band (2e-4 from corners and middle alone).
    """
    allowed, several = plan.budget, plan.views.varies
    # The shape of spectra hardly depends on the numerical level; the certificate includes what remains.
    few = for_spectra(plan.assembly)
    few_streams = dataclasses.replace(plan, assembly=few)
    if allowed.wavenumbers >= COARSE_SPECTRA:  # without finer sunlight, clouds between wavenumbers are coarse, too
        few = few.at_level(0).with_finer_sunlight(min(few.numerical_level, 1))
    spectrum = choose_spectrum(dataclasses.replace(plan, assembly=few), allowed.wavenumbers, fitted, tried)
    columns = BandColumns(plan, spectrum.nodes)
    times, time_error = time_nodes(columns.of(few_streams), extreme, allowed.time)
    suns = [plan.sun_at(time_s) for time_s in times]
    placing = columns.toward(extreme, [suns[len(suns) // 2]])
    source = Source(plan.assembly.entries["radiance"].label, columns.quantities.terms)
    # Where nodes must lie hardly depends on the numerical level, either: those of many columns are placed with few
    # streams, whose columns differ little and smoothly from those of the tables.
    many = plan.assembly.numerical_level + plan.assembly.sunlight_steps >= MANY_STREAMS
    clouds, levels = sum(plan.assembly.cloudy_layers), plan.assembly.profile.altitude_m
    whole = allowed.thickness if clouds <= 1 else min(allowed.thickness, (1.0 - CROSS_SHARE) * allowed.layers / clouds)
    share = (PLACED_SHARE if several else 1.0) * whole
    if clouds and not several and len(suns) > 1:  # a model may then solve clouds for all suns at once
        first = [first_nodes(layer, levels, share)[:, None] for layer in plan.layers]
        alone = np.concatenate([np.kron(row, of) for row, of in zip(np.eye(len(first)), first, strict=True)])
        columns.cloudy(alone[np.any(alone[:, plan.assembly.cloudy_layers], axis=1)], columns.toward(views, suns))
    placed = columns.of(few_streams) if many and clouds > 1 else columns
    axes: tuple[ThicknessAxis | None, ...] = tuple(
        place_thickness(placed.along(index, placing), layer, levels, share, source, several or clouds > 1)
        if cloudy
        else None
        for index, (layer, cloudy) in enumerate(zip(plan.layers, plan.assembly.cloudy_layers, strict=True))
    )
    cross = CROSS_SHARE * allowed.layers
    spare = allowed.other_instants + max(allowed.time - time_error, 0.0)
    drift = spare if len(times) > 1 or placed is not columns or (several and clouds > 1) else 0.0
    near = (*extreme, *edges)
    under = _under_suns(columns, placed, axes, near, suns, cross, drift)
    every = []
    for batch in np.array_split(np.arange(len(views)), max(round(len(views) / VIEWS_AT_ONCE), 1)):
        some = [views[number] for number in batch]
        settings = columns.toward(some, suns)
        exact = [under[sun][0] for sun in suns]
        if several:
            known = [[under[sun][number] for sun in suns for _ in some] for number in range(len(near))]
            exact = columns.exact(axes, settings, whole - share, known)
        tables = columns.tables(exact, settings)
        for number, view in enumerate(some):
            at = slice(number, None, len(some))
            toward = plan.toward(view) if several else plan
            before, middle = len(columns.known.bands), len(suns) // 2 * len(some)
            of_view = columns.of(toward), axes, exact[at], settings[at], times
            of_effects = {
                effect.kind: TABLES_OF_EFFECTS[effect.kind](*of_view)
                for effect in plan.effects
                if effect.kind in TABLES_OF_EFFECTS
            }
            if number > 0:  # the first texture has no other one as a guess, and may need more columns than others
                columns.also_in(settings[middle + number + 1 : middle + len(some)], before)
            every.append((tables[at], of_effects))
    waves = [NO_WAVES] * len(views)
    if plan.waves.varies:
        waves = compile_waves(plan, columns.quantities, tuple(suns), views, extreme, allowed.waves)
    alone_error = max((axis.estimated_error for axis in axes if axis is not None), default=0.0)
    errors = Budget(
        numerics=plan.numerics.error,
        spectral_grid=plan.grid_refinement.error,
        wavenumbers=spectrum.estimated_error,
        thickness=alone_error + whole - share if alone_error else 0.0,
        layers=sum(axis.estimated_error for axis in axes if axis is not None) + cross if clouds > 1 else 0.0,
        waves=max(of_view.estimated_error for of_view in waves),
        views=plan.views.estimated_error,
        shadows=allowed.shadows if plan.has_shadows else 0.0,
        time=time_error,
        other_instants=drift,
        faint_sunlight=plan.sunlight.share,
    )
    of_views = tuple(
        RadianceTables(columns.quantities, times, axes, tables, spectrum, errors, waves=of_waves, **of_effects)
        for (tables, of_effects), of_waves in zip(every, waves, strict=True)
    )
    return dataclasses.replace(of_views[0], over=of_views) if several else of_views[0]


def _under_suns(
    columns: BandColumns,
    placed: BandColumns,
    axes: tuple[ThicknessAxis | None, ...],
    views: Sequence[View],
    suns: Sequence[Sun | None],
    cross: float,
    drift: float,
) -> dict[Sun | None, list[TensorTrain]]:
    """Return the columns toward some views under each sun: of the middle instant, then others, which differ little."""
    middle = suns[len(suns) // 2]
    settings, others = columns.toward(views, [middle]), [sun for sun in suns if sun != middle]
    # Several layers have many columns: those toward other views differ little from those toward the first.
    start = settings[:1] if sum(axis is not None for axis in axes) > 1 else settings
    if placed is columns:
        first = columns.exact(axes, start, cross)
    else:
        first = columns.exact(axes, start, drift, [placed.exact(axes, start, cross)])
    if len(start) < len(settings):
        rest = settings[1:]
        first += columns.exact(axes, rest, drift, [first * len(rest)])
    if not others:
        return {middle: first}
    away = columns.exact(axes, columns.toward(views, others), drift, [first * len(others)])
    return {middle: first} | {sun: away[n * len(views) : (n + 1) * len(views)] for n, sun in enumerate(others)}


Settings = Sequence[ColumnSetting]


def _texture(
    columns: BandColumns, axes: Axes, exact: Sequence[TensorTrain], settings: Settings, _: Sequence[float]
) -> TextureTables:
    from hcss_twin.engine.tables.texture import compile_texture  # not for scenes without texture

    return compile_texture(columns, axes, exact, settings)


def _shadows(
    columns: BandColumns, axes: Axes, exact: Sequence[TensorTrain], settings: Settings, time_s: Sequence[float]
) -> ShadowTables:
    return compile_shadows(columns.plan, columns.quantities, time_s, columns.clear(settings))


TABLES_OF_EFFECTS: Mapping[str, Callable[..., Any]] = {"texture": _texture, "shadows": _shadows}
"""Tables of the effects of a plan toward one view, by :attr:`~hcss_twin.plan.effects.Effect.kind`.

From the columns of the view, the axes of thickness, and exact columns, settings and time at the nodes of time.
"""


CLASSES = (
    RadianceTables,
    Budget,
    Quantities,
    ThicknessAxis,
    TensorTrain,
    InstantTable,
    ShadowTables,
    WaveTables,
    TextureTables,
    Spectrum,
    SpectralNodes,
)
"""Dataclasses that occur in tables."""


def tables_of(plan: Plan, new: Callable[[Plan], object] | None = None) -> RadianceTables:
    """Return the tables of a plan, from the cache (bit-identical) or newly compiled.

    Parameters
    ----------
    new : callable, optional
        Called with each plan whose tables are compiled: one per view, if each needs its own air or sun.
    """
    again = partial(tables_of, new=new)
    over = _over_axes(plan, again)
    if over is not None:
        return over
    if not plan.views.together(plan.assembly):
        return _over_views(plan, again)

    def compute() -> RadianceTables:
        if new is not None:
            new(plan)
        return compile_tables(plan)

    return recall_or_compute(TABLES, table_key(plan), plan.catalog, compute, CLASSES)


def tables_are_kept(plan: Plan) -> bool:
    """Return whether the cache has the tables of a plan, of which those of the first view and state stand for all."""
    for axis in point_axes(plan):
        return tables_are_kept(axis.plan_in(plan, axis.nodes[0]))
    if not plan.views.together(plan.assembly):
        return tables_are_kept(next(iter(plans_over_views(plan))))
    return Store(*TABLES).find(table_key(plan)) is not None
