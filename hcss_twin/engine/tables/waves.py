"""Radiance of clear columns as a function of wave slope: compiled once per scene, added to every frame."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache, partial

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.error_norm import largest_error
from hcss_twin.core.errors import ProviderError
from hcss_twin.engine.tables.radiance_tables import Quantities, WaveTables
from hcss_twin.models.sea.wave_field import MOST_SIGMAS
from hcss_twin.physics import quadrature
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.slant_paths import sea_sun_terms
from hcss_twin.plan.waves import crosswind_sense
from hcss_twin.providers import ColumnSetting, Sun, View
from hcss_twin.providers.column_states import spectra_of

FLOOR = 1e-6
"""Fraction of the total below which a term is not interpolated logarithmically."""

ROUGHNESS = 1e-4
"""Relative error accepted if more nodes do not help: sea models use numerical quadrature (rough-sea: 4e-5)."""

AT_ONCE = 128
"""Columns that are computed in one call; the memory grows with their number."""

_COARSEST, _FINEST = 4, 64
_DENSEST = 513


def compile_waves(
    plan: Plan,
    quantities: Quantities,
    suns: tuple[Sun | None, ...],
    views: Sequence[View],
    extreme: Sequence[View],
    tolerance: float,
) -> list[WaveTables]:
    """Compute clear columns over tilted seas toward some views until interpolation meets the tolerance.

    Exact columns are computed at Chebyshev nodes of both slopes, and a polynomial interpolates the logarithm of each
    term; its order is doubled until columns between the nodes agree. Each term is then scaled so that its mean over
    the waves is the radiance of the mean sea: facets that face the sensor have a larger weight in the mean sea, but not
    in resolved waves.

    Parameters
    ----------
    quantities : Quantities
        What is looked up.
    suns : tuple of Sun or None
        Sun at each time node; the nodes are placed for the middle one.
    extreme : sequence of View
        Views for which the nodes are placed. Of a narrow field it is one, from which those of the others are derived.
    tolerance : float
        Relative to the total of the band.

    Raises
    ------
    ProviderError
        If the radiance does not converge with the number of nodes.
    """
    columns, allowed = _Columns(plan), 0.25 * tolerance
    middle = suns[len(suns) // 2 :][:1]

    def of_view(view: View) -> Callable[[Array, Array], Array]:
        return lambda upwind, crosswind: columns.toward([view], middle, upwind, crosswind)[0, 0]

    placed = [_place(of_view(view), allowed) for view in extreme]
    orders = max(up for (up, _), _ in placed), max(across for (_, across), _ in placed)
    error = max(found for _, found in placed)
    nodes = quadrature.nodes(orders[0]), quadrature.nodes(orders[1])
    exact = dict(zip(extreme, columns.toward(extreme, suns, *nodes), strict=True))
    others = [view for view in views if view not in exact]
    if others:
        derived = _derived(columns, exact[extreme[0]], others, suns, nodes, allowed) if len(extreme) == 1 else None
        error += allowed if derived is not None else 0.0
        every = columns.toward(others, suns, *nodes) if derived is None else derived
        exact |= zip(others, every, strict=True)
    return [_tables(plan, quantities, exact[view], columns.level(view, suns), error, allowed) for view in views]


def _derived(
    columns: _Columns,
    known: Array,
    views: Sequence[View],
    suns: Sequence[Sun | None],
    nodes: tuple[Array, Array],
    tolerance: float,
) -> Array | None:
    """Return columns (views, S, N, M, K, B) toward some views from those (S, N, M, K, B) toward one near them.

    The glint of another view lies at another slope, not far from its own: the logarithm of each term changes by a
    polynomial of low order. None if columns between its nodes differ.
    """
    some = [np.linspace(0, at.size - 1, 3).astype(np.intp) for at in nodes]
    few = [at[which] for at, which in zip(nodes, some, strict=True)]
    near, exact = known[:, some[0][:, None], some[1]], columns.toward(views, suns, *few)
    floor = FLOOR * np.mean(np.sum(known, axis=-2), axis=(1, 2))[:, None, None, None]
    followed = (np.min(known, axis=(1, 2)) > 0.0) & (np.min(exact, axis=(0, 2, 3)) > 0.0)
    followed = followed[:, None, None]

    def turned(values: Array) -> Array:
        return np.where(followed, np.log(np.where(followed, values, 1.0) + floor), values)

    up, across = (quadrature.lagrange(of_few, at) for of_few, at in zip(few, nodes, strict=True))
    change = np.einsum("nu,ma,vsuakb->vsnmkb", up, across, turned(exact) - turned(near), optimize=True)
    whole = turned(known) + change
    found: Array = np.where(followed, np.maximum(np.exp(np.where(followed, whole, 0.0)) - floor, 0.0), whole)
    tried = [np.array([1, at.size - 2]) for at in nodes]
    between = columns.toward(views, suns, *(at[which] for at, which in zip(nodes, tried, strict=True)))
    error = _difference(found[:, :, tried[0][:, None], tried[1]], between)
    return found if error <= tolerance else None


def _tables(
    plan: Plan, quantities: Quantities, values: Array, level: Array, error: float, tolerance: float
) -> WaveTables:
    """Return the tables toward one view from columns (S, N, M, K, B) at nodes, and (S, K, B) over the mean sea."""
    sizes, rest = _dense(values[len(values) // 2], tolerance)
    changes, levels = zip(*(_change(*under, sizes) for under in zip(values, level, strict=True)), strict=True)

    def tables(of_terms: Array) -> tuple[NDArray[np.float32], ...]:
        """Tables of the changes of all terms, or of some."""
        wanted = (quantities.of(change * of_terms) for change in changes)
        return tuple(np.ascontiguousarray(table.reshape(*sizes, -1), np.float32) for table in wanted)

    every, of_sun = np.ones((len(quantities.terms), 1)), sea_sun_terms(plan.assembly.model)
    direct = np.array([[float(name in of_sun)] for name in quantities.terms])
    weakened = plan.has_shadows or plan.texture.changes_sunlight
    return WaveTables(plan.waves.reach, tables(every), levels, error + rest, tables(direct) if weakened else ())


def probe_waves(plan: Plan, sun: Sun | None) -> Array:
    """Totals (4, B) of clear columns at two standard deviations of either slope; they change with the sun."""
    columns, far, still = _Columns(plan), np.array([-2.0, 2.0]) / MOST_SIGMAS, np.zeros(1)
    upwind, crosswind = (columns.toward([plan.view], [sun], *slopes)[0, 0] for slopes in ((far, still), (still, far)))
    total: Array = np.sum(np.concatenate((upwind[:, 0], crosswind[0])), axis=1)
    return total


class _Columns:
    """Cached clear columns over tilted seas, integrated over the bands.

    Those of one call are computed together: all views and suns share a sea.
    """

    def __init__(self, plan: Plan) -> None:
        self._plan = plan
        self._tilted = cache(partial(plan.waves.tilted, plan.assembly))
        self._reach = plan.waves.reach
        self._known: dict[tuple[View, Sun | None, float, float], Array] = {}

    def toward(self, views: Sequence[View], suns: Sequence[Sun | None], upwind: Array, crosswind: Array) -> Array:
        """Terms (views, S, N, M, K, B) at slopes (N,) and (M,) relative to the table limits.

        Crosswind is clockwise from upwind.
        """
        keys = [(view, sun, float(u), float(c)) for u in upwind for c in crosswind for view in views for sun in suns]
        new = [key for key in dict.fromkeys(keys) if key not in self._known]
        for first in range(0, len(new), AT_ONCE):
            some = new[first : first + AT_ONCE]
            self._known.update(zip(some, self._clear([self._setting(*key) for key in some]), strict=True))
        found = np.stack([self._known[key] for key in keys])
        found = found.reshape(upwind.size, crosswind.size, len(views), len(suns), *found.shape[1:])
        return np.moveaxis(found, (2, 3), (0, 1))

    def level(self, view: View, suns: Sequence[Sun | None]) -> Array:
        """Terms (S, K, B) over the mean sea."""
        return self._clear([self._plan.assembly.setting(sun, view) for sun in suns])

    def _setting(self, view: View, sun: Sun | None, upwind: float, crosswind: float) -> ColumnSetting:
        slope = upwind * self._reach[0], crosswind_sense(view, sun) * crosswind * self._reach[1]
        return self._tilted(slope).setting(sun, view)

    def _clear(self, settings: Sequence[ColumnSetting]) -> Array:
        """Terms (N, K, B) of clear sky in some settings."""
        grid, assembly = self._plan.spectral_grid, self._plan.assembly
        spectra = spectra_of(assembly.model, settings, grid.wavenumber_cm1, np.zeros((1, len(assembly.layers))))
        terms: Array = spectra[:, 0] @ grid.weights_cm1.T
        return terms


def _place(columns: Callable[[Array, Array], Array], tolerance: float) -> tuple[tuple[int, int], float]:
    """Double the order for either slope until the polynomial meets the tolerance.

    The error is measured halfway between the nodes of that slope, at the ends and the middle of the other slope.
    Errors below the sea model's own quadrature error are accepted if they no longer decrease.
    """
    orders, error = [_COARSEST, _COARSEST], 0.0
    lines = np.array([-1.0, 0.0, 1.0])
    for axis in (0, 1):
        found = np.inf
        while True:
            between = quadrature.between(orders[axis])
            places = (between, lines) if axis == 0 else (lines, between)
            values = columns(quadrature.nodes(orders[0]), quadrature.nodes(orders[1]))
            before, found = found, _difference(_interpolate(values, places), columns(*places))
            if found <= tolerance or (found <= ROUGHNESS and found > 0.25 * before):
                break
            if 2 * orders[axis] == _FINEST:
                raise ProviderError(
                    f"clear radiance over tilted seas does not converge: {found:.1e} with {orders[axis] + 1} slopes, "
                    f'allowed {tolerance:.1e}; allowed: sea.waves = "off", larger pixels or a lower accuracy'
                )
            orders[axis] *= 2
        error += found
    return (orders[0], orders[1]), error


def _difference(guess: Array, exact: Array) -> float:
    """Largest relative difference of totals, of terms (..., K, B)."""
    return largest_error(np.sum(guess, axis=-2), np.sum(exact, axis=-2))


def _interpolate(values: Array, places: tuple[Array, ...]) -> Array:
    """Interpolate terms (n, m, K, B) from the nodes to positions (N,), (M,) in [-1, 1]: (N, M, K, B)."""
    floor = FLOOR * np.mean(np.sum(values, axis=2), axis=(0, 1))
    constant = np.all(values == values[:1, :1], axis=(0, 1))
    followed = ~constant & (floor > 0) & (np.min(values, axis=(0, 1)) > -0.5 * floor)
    turned = np.where(followed, np.log(np.where(followed, values + floor, 1.0)), values)
    rows, columns = (quadrature.weights(size - 1, x) for size, x in zip(values.shape[:2], places, strict=True))
    found = np.tensordot(rows, np.tensordot(columns, turned, (1, 1)), (1, 1))
    back = np.exp(np.where(followed, found, 0.0)) - floor
    return np.where(constant, values[0, 0], np.where(followed, np.maximum(back, 0.0), found))


def _dense(values: Array, tolerance: float) -> tuple[tuple[int, int], float]:
    """Sizes of a uniform grid on which cubic interpolation meets the tolerance, along either slope."""
    sizes, error = [], 0.0
    for axis in (0, 1):
        size, found = 9, np.inf
        while found > tolerance:
            if size >= _DENSEST:
                raise ProviderError(f"clear radiance over tilted seas needs more than {size} slopes")
            size = 2 * size - 1
            places = [quadrature.nodes(count - 1) for count in values.shape[:2]]
            places[axis] = np.linspace(-1.0, 1.0, size)
            exact = np.moveaxis(_interpolate(values, (places[0], places[1])), axis, 0)
            known, between = exact[::2], exact[3:-3:2]
            cubic = (9.0 * (known[1:-2] + known[2:-1]) - known[:-3] - known[3:]) / 16.0
            # With half the step the error of cubics is a sixteenth.
            found = _difference(np.moveaxis(cubic, 0, axis), np.moveaxis(between, 0, axis)) / 16.0
        sizes.append(size)
        error += found
    return (sizes[0], sizes[1]), error


def _change(values: Array, clear: Array, sizes: tuple[int, int]) -> tuple[Array, Array]:
    """Change (N, M, K, B) of each term of the clear column (K, B), with mean 0 over the waves, and its scale."""
    places = [np.linspace(-1.0, 1.0, size) for size in sizes]
    dense = _interpolate(values, tuple(places))
    upwind, crosswind = (np.exp(-0.5 * (MOST_SIGMAS * slopes) ** 2) for slopes in places)
    mean = np.einsum("n,m,nmkb->kb", upwind / upwind.sum(), crosswind / crosswind.sum(), dense)
    scale = np.divide(clear, mean, out=np.ones_like(mean), where=mean > 0)
    return np.asarray(dense * scale - clear, dtype=np.float64), scale
