"""Tables of all views over the image from one choice of wavenumbers and thicknesses, made toward extreme views.

Toward other views, columns are combinations of those toward the corners, the middles of the edges and the middle of the
image, fitted at few thicknesses: toward 63 views over 250 km, five thicknesses leave 1.3e-5 of the radiance in any band
(2e-4 from corners and middle alone, which then need more thicknesses).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from hcss_twin.engine.tables.columns import BandColumns
from hcss_twin.engine.tables.radiance_tables import RadianceTables, TextureTables
from hcss_twin.engine.tables.spectrum import choose_spectrum
from hcss_twin.engine.tables.thickness_axis import Source, place_axis
from hcss_twin.plan.accuracy import Budget
from hcss_twin.plan.numerics import for_spectra
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.views import EDGES, EXTREMES, views_over_image
from hcss_twin.providers import ColumnSetting, Sun, View

PLACED_SHARE = 0.5
"""Share of the tolerance in thickness for columns toward extreme views; the rest is for those derived from them."""

VIEWS_TOGETHER = 32
"""Views whose columns are computed in one call; the memory grows with their number."""

TimeNodes = Callable[[BandColumns, Sequence[View], float], tuple[tuple[float, ...], float]]


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
    columns = BandColumns(plan, spectrum.nodes)
    frames, time_error = time_nodes(columns, extreme, allowed.time)
    if len(frames) > 1 and plan.is_grid:
        return None
    suns = [plan.sun_at(time_s) for time_s in frames]
    middle = suns[len(suns) // 2]

    def toward(some: Sequence[View], under: Sequence[Sun | None]) -> list[ColumnSetting]:
        return [plan.assembly.setting(sun, view) for sun in under for view in some]

    source = Source(plan.assembly.entries["radiance"].label, columns.quantities.terms)
    levels, share = plan.assembly.profile.altitude_m, PLACED_SHARE * allowed.thickness
    axes = tuple(
        place_axis(columns.alone(index, toward(extreme, [middle])), layer, levels, share, source) if cloudy else None
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
    near = (*extreme, *edges)
    first = columns.exact(axes, None, toward(near, [middle]))
    of_suns, others = {middle: first}, [sun for sun in suns if sun != middle]
    if others:
        away = columns.exact(axes, None, toward(near, others), [first * len(others)], allowed.other_instants)
        of_suns |= {sun: away[n * len(near) : (n + 1) * len(near)] for n, sun in enumerate(others)}
    all_views, every = views.at(plan.views.places), list[RadianceTables]()
    for start in range(0, len(all_views), VIEWS_TOGETHER):
        some = all_views[start : start + VIEWS_TOGETHER]
        settings = toward(some, suns)
        known = [[of_suns[sun][number] for sun in suns for _ in some] for number in range(len(near))]
        exact = columns.exact(axes, None, settings, known, derived)
        tables = columns.tables(axes, exact, settings)
        for number, view in enumerate(some):
            at = slice(number, None, len(some))
            texture = None
            if plan.texture is not None:
                texture = texture_of(columns.of(plan.toward(view)), axes, None, exact[at], settings[at])
            of_view = RadianceTables(columns.quantities, frames, axes, None, tables[at], spectrum, errors)
            every.append(replace(of_view, texture=texture))
    return replace(every[0], over_views=tuple(every))
