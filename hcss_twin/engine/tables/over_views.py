"""Tables for several views of a scene, and look-up with weights for each pixel."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from copy import copy
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.kernels import kernel
from hcss_twin.engine.tables.columns import BandColumns
from hcss_twin.engine.tables.look_up import LookUp
from hcss_twin.engine.tables.radiance_tables import RadianceTables, TextureTables, with_largest_errors
from hcss_twin.engine.tables.spectrum import choose_spectrum
from hcss_twin.engine.tables.thickness_axis import ColumnsAt, Source, place_axis
from hcss_twin.models.radiance.spectral_grid import SpectralNodes
from hcss_twin.plan.accuracy import Budget
from hcss_twin.plan.assembly import expect_views
from hcss_twin.plan.numerics import for_spectra
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.views import EDGES, EXTREMES, ViewAxis, views_over_image
from hcss_twin.plan.windows import Window, points_of
from hcss_twin.providers import Grid, Sun, View


def image_views(plan: Plan) -> Any:
    """Return the :class:`ImageViews` of a plan whose view or air varies, or the :class:`Views` of its imager."""
    views = views_over_image(plan.assembly)
    assert views is not None
    return views


def plans_over_views(plan: Plan) -> Iterator[Plan]:
    """Yield a plan for each view with tables, or the plan itself if one view is used for all pixels.

    Plans are built one at a time, because the providers of each view's own air can need 60 MB.
    """
    if plan.views is None:
        yield plan
        return
    for view in image_views(plan).at(plan.views.places):
        yield plan.toward(view)


def tables_over_views(plan: Plan, tables_of: Callable[[Plan], RadianceTables]) -> RadianceTables:
    """Return the tables of all views of a plan with several views.

    Parameters
    ----------
    tables_of : callable
        Computes the tables of a plan with one view.

    Returns
    -------
    RadianceTables
        Tables with the most wavenumbers, with the largest errors of all views, and all tables as ``over_views``.
    """
    assert plan.views is not None
    each = tuple(tables_of(toward) for toward in plans_over_views(plan))
    largest = with_largest_errors(each)
    errors = replace(largest.errors, views=plan.views.estimated_error)
    return replace(largest, errors=errors, over_views=each)


Thickness = NDArray[np.float32]

VALUES_AT_ONCE = 2**21
"""Maximum pixels times channels that are summed together; 16 MB."""


class ViewedLookUp:
    """Look-up in the tables of one instant for the view of each pixel.

    Parameters
    ----------
    grid : Grid
        The image, in pixels.
    look_ups : sequence of LookUp
        One look-up for each node of the axis, in order.
    """

    def __init__(self, axis: ViewAxis, grid: Grid, look_ups: Sequence[LookUp]) -> None:
        self._look_ups = look_ups
        self._across, self._up = axis.weights(grid)

    def of_part(self, extent: Window) -> ViewedLookUp:
        """Return the look-up of some rows and columns of the image, counted from the first of them."""
        part = copy(self)
        part._up, part._across = self._up[extent[0]], self._across[extent[1]]
        return part

    def of_points(self, extent: Window, samples: int) -> ViewedLookUp:
        """Return the look-up of the points of some rows and columns, as if each were a pixel."""
        part = self.of_part(extent)
        part._up, part._across = (np.repeat(each, samples, axis=0) for each in (part._up, part._across))
        return part

    @property
    def _shape(self) -> tuple[int, int]:
        return len(self._up), len(self._across)

    def _weights(self, y: slice, x: slice) -> Iterator[Array]:
        """Yield the weights (y, x) of each node for a window."""
        for up in self._up[y].T:
            for across in self._across[x].T:
                yield up[:, None] * across

    def fill(
        self,
        radiance: NDArray[np.float32],
        thickness_m: Sequence[Thickness],
        samples: int = 1,
        corner: tuple[int, int] = (0, 0),
    ) -> None:
        """Write the radiance of a window of the image like :meth:`LookUp.fill`; without layers, of the whole image."""
        if thickness_m:
            rows, columns = (size // samples for size in thickness_m[0].shape)
        else:
            (rows, columns), corner = self._shape, (0, 0)
        step = max(1, VALUES_AT_ONCE // (radiance.shape[0] * columns))
        for first in range(0, rows, step):
            strip = slice(first, min(first + step, rows))
            points = [each[points_of(strip, samples)] for each in thickness_m]
            y = slice(corner[0] + strip.start, corner[0] + strip.stop)
            x = slice(corner[1], corner[1] + columns)
            sums = np.zeros((radiance.shape[0], strip.stop - first, columns))
            part = np.empty(sums.shape, dtype=np.float32)
            for weight, look_up in zip(self._weights(y, x), self._look_ups, strict=True):
                look_up.fill(part, points, samples)
                _add(sums, part, weight)
            # A vanishing term can become negative between nodes.
            radiance[:, y, x] = np.maximum(sums, 0.0)


@kernel()
def _add(sums, part, weight):  # type: ignore[no-untyped-def]
    """Add a part (C, y, x) to the sums, weighted by pixel (y, x)."""
    for c in range(sums.shape[0]):
        for y in range(sums.shape[1]):
            for x in range(sums.shape[2]):
                sums[c, y, x] += weight[y, x] * np.float64(part[c, y, x])


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
    views, allowed = image_views(plan), plan.budget
    extreme, edges = views.at(EXTREMES), views.at(EDGES)
    few_streams = replace(plan, assembly=for_spectra(plan.assembly))
    spectrum = choose_spectrum(few_streams, allowed.wavenumbers, extreme, edges)
    all_views = views.at(plan.views.places)
    together = list(dict.fromkeys((*extreme, *edges, *all_views)))
    toward = [_columns(plan, view, together, spectrum.nodes) for view in extreme]
    times = [time_nodes(each, each.plan, allowed.time) for each in toward]
    frames, time_error = max((each for each, _ in times), key=len), max(error for _, error in times)
    if len(frames) > 1 and plan.imager is None:
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
    first = [each.exact(axes, None, sun) for each in toward]
    known = [
        first
        if other == sun
        else [
            columns.exact(axes, None, other, [own], allowed.other_instants)
            for columns, own in zip(toward, first, strict=True)
        ]
        for other in suns
    ]
    del toward  # and the arrays of their models
    every = []
    for view in all_views:
        columns = _columns(plan, view, together, spectrum.nodes)
        exact = [columns.exact(axes, None, other, own, derived) for other, own in zip(suns, known, strict=True)]
        texture = None if plan.texture is None else texture_of(columns, axes, None, exact, suns)
        tables = tuple(columns.table(axes, each, other) for each, other in zip(exact, suns, strict=True))
        own = RadianceTables(columns.quantities, frames, axes, None, tables, spectrum, errors, texture=texture)
        every.append(own)
    return replace(every[0], over_views=tuple(every))


def _columns(plan: Plan, view: View, together: Sequence[View], nodes: SpectralNodes) -> BandColumns:
    """Return the columns toward one of several views."""
    toward = plan.toward(view)
    expect_views(toward.assembly.model, together)
    return BandColumns(toward, nodes)


def _beside(toward: Sequence[BandColumns], index: int, sun: Sun | None) -> ColumnsAt:
    """Return columns (N, K, A x B) toward A views, with cloud in one layer."""
    each = [columns.alone(index, sun) for columns in toward]
    return lambda thickness_m: np.concatenate([columns(thickness_m) for columns in each], axis=-1)
