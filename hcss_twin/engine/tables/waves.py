"""Radiance of clear columns as a function of wave slope: compiled once per scene, added to every frame."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.error_norm import largest_error
from hcss_twin.core.errors import ProviderError
from hcss_twin.engine.tables.radiance_tables import Quantities, WaveTables
from hcss_twin.models.sea.wave_field import MOST_SIGMAS
from hcss_twin.physics import quadrature
from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.slant_paths import sea_sun_terms
from hcss_twin.plan.waves import PlannedWaves
from hcss_twin.providers import Sun, View
from hcss_twin.providers.column_states import spectra_of

FLOOR = 1e-6
"""Fraction of the total below which a term is not interpolated logarithmically."""

ROUGHNESS = 1e-4
"""Relative error accepted if more nodes do not help: sea models use numerical quadrature (rough-sea: 4e-5)."""

_COARSEST, _FINEST = 4, 64
_DENSEST = 513


def compile_waves(
    plan: Plan,
    waves: PlannedWaves,
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
        Views for which the nodes are placed.
    tolerance : float
        Relative to the total of the band.

    Raises
    ------
    ProviderError
        If the radiance does not converge with the number of nodes.
    """

    def toward(view: View, sun: Sun | None) -> _Columns:
        return _Columns(plan if plan.views is None else plan.toward(view), waves, sun)

    middle = len(suns) // 2
    near = {view: toward(view, suns[middle]) for view in extreme}
    placed = [_place(columns, 0.25 * tolerance) for columns in near.values()]
    orders = max(up for (up, _), _ in placed), max(across for (_, across), _ in placed)
    error = max(found for _, found in placed)
    every = []
    for view in views:
        columns = [toward(view, sun) for sun in suns]
        columns[middle] = near.get(view, columns[middle])
        every.append(_tables(plan, waves, quantities, columns, orders, error, 0.25 * tolerance))
    return every


def _tables(
    plan: Plan,
    waves: PlannedWaves,
    quantities: Quantities,
    columns: Sequence[_Columns],
    orders: tuple[int, int],
    error: float,
    tolerance: float,
) -> WaveTables:
    """Return the tables toward one view, with nodes of some orders, from the columns under each sun."""
    nodes = quadrature.nodes(orders[0]), quadrature.nodes(orders[1])
    sizes, rest = _dense(columns[len(columns) // 2](*nodes), tolerance)
    changes, levels = zip(*(_change(column(*nodes), column.level(), sizes) for column in columns), strict=True)

    def tables(of_terms: Array) -> tuple[NDArray[np.float32], ...]:
        """Tables of the changes of all terms, or of some."""
        wanted = (quantities.of(change * of_terms) for change in changes)
        return tuple(np.ascontiguousarray(table.reshape(*sizes, -1), np.float32) for table in wanted)

    every, of_sun = np.ones((len(quantities.terms), 1)), sea_sun_terms(plan.assembly.model)
    direct = np.array([[float(name in of_sun)] for name in quantities.terms])
    return WaveTables(waves.reach, tables(every), levels, error + rest, tables(direct) if plan.has_shadows else ())


def probe_waves(plan: Plan, waves: PlannedWaves, sun: Sun | None) -> Array:
    """Totals (4, B) of clear columns at two standard deviations of either slope; they change with the sun."""
    columns, far = _Columns(plan, waves, sun), np.array([-2.0, 2.0]) / MOST_SIGMAS
    still = np.zeros(1)
    total: Array = np.sum(np.concatenate((columns(far, still)[:, 0], columns(still, far)[0])), axis=1)
    return total


class _Columns:
    """Cached clear columns over tilted seas, integrated over the bands."""

    def __init__(self, plan: Plan, waves: PlannedWaves, sun: Sun | None) -> None:
        self._plan, self._waves, self._sun = plan, waves, sun
        self._known: dict[tuple[float, float], Array] = {}

    def __call__(self, upwind: Array, crosswind: Array) -> Array:
        """Terms (N, M, K, B) at slopes (N,) and (M,) relative to the table limits, crosswind clockwise from upwind."""
        keys = [(float(u), float(c)) for u in upwind for c in crosswind]
        new = [key for key in dict.fromkeys(keys) if key not in self._known]
        self._known.update(zip(new, self._clear([self._tilted(*key) for key in new]), strict=True))
        found = np.stack([self._known[key] for key in keys])
        terms: Array = found.reshape(upwind.size, crosswind.size, *found.shape[1:])
        return terms

    def level(self) -> Array:
        """Terms (K, B) over the mean sea."""
        terms: Array = self._clear([self._plan.assembly])[0]
        return terms

    def _tilted(self, upwind: float, crosswind: float) -> Assembly:
        slope = upwind * self._waves.reach[0], crosswind * self._waves.reach[1]
        return self._waves.tilted(self._plan.assembly, slope, self._plan.view, self._sun)

    def _clear(self, scenes: Sequence[Assembly]) -> Array:
        """Terms (N, K, B) of clear sky over each sea."""
        grid, assembly = self._plan.spectral_grid, self._plan.assembly
        settings, cloudless = [scene.setting(self._sun) for scene in scenes], np.zeros((1, len(assembly.layers)))
        spectra = spectra_of(assembly.model, settings, grid.wavenumber_cm1, cloudless)[:, 0]
        terms: Array = spectra @ grid.weights_cm1.T
        return terms


def _place(columns: _Columns, tolerance: float) -> tuple[tuple[int, int], float]:
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
    """Largest relative difference of totals."""
    return largest_error(np.sum(guess, axis=2), np.sum(exact, axis=2))


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
