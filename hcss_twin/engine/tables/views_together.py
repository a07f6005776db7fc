"""Tables of all views over the image from one choice of wavenumbers and thicknesses, made toward extreme views.

Toward other views, columns are combinations of those toward the corners, the middles of the edges and the middle of the
image, fitted at few thicknesses: toward 63 views over 250 km, five thicknesses leave 1.3e-5 of the radiance in any band
(2e-4 from corners and middle alone, which then need more thicknesses).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from hcss_twin.engine.tables.columns import BandColumns
from hcss_twin.engine.tables.radiance_tables import RadianceTables, TextureTables
from hcss_twin.engine.tables.spectrum import choose_spectrum
from hcss_twin.engine.tables.thickness_axis import ColumnsAt, Source, place_axis
from hcss_twin.models.radiance.spectral_grid import SpectralNodes
from hcss_twin.plan.accuracy import Budget
from hcss_twin.plan.assembly import expect_views
from hcss_twin.plan.numerics import for_spectra
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.views import EDGES, EXTREMES, views_over_image
from hcss_twin.providers import Sun, View

PLACED_SHARE = 0.5
"""Share of the tolerance in thickness for columns toward extreme views; the rest is for those derived from them."""

TimeNodes = Callable[[BandColumns, Plan, float], tuple[tuple[float, ...], float]]


def may_compile_together(plan: Plan) -> bool:
    """Whether the views of a plan can share wavenumbers and thicknesses: one air, one sun, cloud in one layer."""
    one = plan.assembly.air_over_field is None and plan.assembly.own_suns is None
    return plan.views is not None and one and sum(plan.assembly.cloudy_layers) <= 1


def tables_together(
    plan: Plan, time_nodes: TimeNodes, texture_of: Callable[..., TextureTables | None]
) -> RadianceTables | None:
    """Return the tables of all views of a plan; None if the sun moves over a grid on the ground.

    Parameters
    ----------
    time_nodes : callable
        Chooses the frames with computed tables, and returns the error between them.
    texture_of : callable
        :func:`hcss_twin.engine.tables.texture.compile_texture`.

    Raises
    ------
    ProviderError
        If a provider fails at a required state.
    """
    assert plan.views is not None
    views, allowed = views_over_image(plan.assembly), plan.budget
    assert views is not None
    extreme, edges = views.at(EXTREMES), views.at(EDGES)
    few_streams = replace(plan, assembly=for_spectra(plan.assembly))
    spectrum = choose_spectrum(few_streams, allowed.wavenumbers, extreme, edges)
    all_views = views.at(plan.views.places)
    together = list(dict.fromkeys((*extreme, *edges, *all_views)))
    toward = [_columns(plan, view, together, spectrum.nodes) for view in extreme]
    times = [time_nodes(columns, columns.plan, allowed.time) for columns in toward]
    frames, time_error = max((nodes for nodes, _ in times), key=len), max(error for _, error in times)
    if len(frames) > 1 and plan.is_grid:
        return None
    suns = [plan.sun_at(time_s) for time_s in frames]
    sun = suns[len(suns) // 2]
    source = Source(plan.assembly.entries["radiance"].label, toward[0].quantities.terms)
    levels, share = plan.assembly.profile.altitude_m, PLACED_SHARE * allowed.thickness
    axes = tuple(
        place_axis(_beside(toward, index, sun), layer, levels, share, source) if cloudy else None
        for index, (layer, cloudy) in enumerate(zip(plan.layers, plan.assembly.cloudy_layers, strict=True))
    )
    placed = max((axis.estimated_error for axis in axes if axis is not None), default=0.0)
    derived = allowed.thickness - share
    errors = Budget(
        numerics=plan.numerics.error,
        spectral_grid=plan.grid_refinement.error,
        wavenumbers=spectrum.estimated_error,
        thickness=placed + derived if placed else 0.0,
        views=plan.views.estimated_error,
        time=time_error,
        other_instants=allowed.other_instants if len(suns) > 1 else 0.0,
        faint_sunlight=plan.faint_sunlight or 0.0,
    )
    toward += [_columns(plan, view, together, spectrum.nodes) for view in edges]
    first = [columns.exact(axes, None, sun) for columns in toward]
    known = [
        first
        if other == sun
        else [
            columns.exact(axes, None, other, [solved], allowed.other_instants)
            for columns, solved in zip(toward, first, strict=True)
        ]
        for other in suns
    ]
    del toward  # and the arrays of their models
    every = []
    for view in all_views:
        columns = _columns(plan, view, together, spectrum.nodes)
        exact = [columns.exact(axes, None, other, near, derived) for other, near in zip(suns, known, strict=True)]
        texture = None if plan.texture is None else texture_of(columns, axes, None, exact, suns)
        tables = tuple(columns.table(axes, solved, other) for solved, other in zip(exact, suns, strict=True))
        view_tables = RadianceTables(columns.quantities, frames, axes, None, tables, spectrum, errors, texture=texture)
        every.append(view_tables)
    return replace(every[0], over_views=tuple(every))


def _columns(plan: Plan, view: View, together: Sequence[View], nodes: SpectralNodes) -> BandColumns:
    """Return the columns toward one of several views."""
    toward = plan.toward(view)
    expect_views(toward.assembly.model, together)
    return BandColumns(toward, nodes)


def _beside(toward: Sequence[BandColumns], index: int, sun: Sun | None) -> ColumnsAt:
    """Return columns (N, K, A x B) toward A views, with cloud in one layer."""
    of_views = [columns.alone(index, sun) for columns in toward]
    return lambda thickness_m: np.concatenate([columns(thickness_m) for columns in of_views], axis=-1)
