"""Columns of a scene, integrated over the bands, in several settings at once.

A setting is a view, a sun and a state of sea and air. Columns in another one differ little and smoothly from those in a
first one: the difference needs few nodes. Axes see the bands of all settings side by side.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.error_norm import largest_error
from hcss_twin.cube.variables import TERM_PREFIX
from hcss_twin.engine.tables.layer_pair import LayerPair
from hcss_twin.engine.tables.radiance_tables import InstantTable, Quantities
from hcss_twin.engine.tables.thickness_axis import ColumnsAt, ThicknessAxis, spline_through, total
from hcss_twin.engine.tables.waves import probe_waves
from hcss_twin.models.radiance.spectral_grid import SpectralNodes, all_nodes
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import ColumnSetting, ColumnStates, RadianceModel, Sun, View
from hcss_twin.providers.column_states import spectra_of

Places = NDArray[np.intp]

FIRST_NODES = 5

SMALLEST_SHARE = 1e-8
"""Combinations of known columns that differ by less than this, relative, count as one."""


def single_layer(columns: ColumnsAt, thickness_m: Array, known: Array, tolerance: float) -> Array:
    """Return columns at all thicknesses, of which only some are computed.

    The difference from a combination of known columns is interpolated by a spline in ln(thickness); intervals are
    halved until it predicts every new column.

    Parameters
    ----------
    columns : callable
        Maps thicknesses (N,) to terms (N, K, B).
    thickness_m : ndarray (E,)
        Ascending.
    known : ndarray (A, E, K, B)
        Terms under other suns or toward other views; a single one is subtracted as it is.
    tolerance : float
        Of the total of any band, relative.

    Returns
    -------
    ndarray (E, K, B)
    """
    places = _first_places(thickness_m.size)
    new = _between(places)
    first = columns(thickness_m[np.concatenate((places, new))])  # one call costs less than two
    values, exact = first[: places.size], first[places.size :]
    near = _combination(known, places, values)
    while new.size:
        guess = near[new] + spline_through(thickness_m[places], values - near[places])(np.log(thickness_m[new]))
        error = largest_error(total(guess), total(exact))
        order = np.argsort(np.concatenate((places, new)))
        places = np.concatenate((places, new))[order]
        values = np.concatenate((values, exact))[order]
        near = _combination(known, places, values)
        if error <= tolerance:
            break
        new = _between(places)
        exact = columns(thickness_m[new]) if new.size else exact
    difference = spline_through(thickness_m[places], values - near[places])(np.log(thickness_m))
    # Splines of a term that approaches zero would become negative.
    columns_at: Array = np.maximum(near + difference, np.minimum(np.min(values, axis=0), 0.0))
    columns_at[places] = values
    return columns_at


def _combination(known: Array, places: Places, values: Array) -> Array:
    """Return the combination (E, K, B) of known columns whose total in each band is nearest at some places."""
    if known.shape[0] == 1:
        first: Array = known[0]
        return first
    goal = np.maximum(np.abs(total(values)), np.finfo(float).tiny)
    shares = np.sum(known[:, places], axis=2) / goal
    factors = [
        np.linalg.lstsq(band_shares.T, np.ones(places.size), rcond=SMALLEST_SHARE)[0]
        for band_shares in np.moveaxis(shares, 2, 0)
    ]
    result: Array = np.einsum("ba,aekb->ekb", np.stack(factors), known)
    return result


def layer_pair(columns: ColumnsAt, low_m: Array, high_m: Array, known: Array, tolerance: float) -> Array | None:
    """Return columns with cloud in two layers (E, F, K, B), or None if the difference needs too many nodes.

    Parameters
    ----------
    columns : callable
        Maps pairs of thicknesses (N, 2), low and high, to terms (N, K, B).
    low_m, high_m : ndarray (E,), (F,)
        Ascending.
    known : ndarray (E, F, K, B)
        Terms under the first sun.
    tolerance : float
        Of the total of any band, relative.
    """
    low, high = _first_places(low_m.size), _first_places(high_m.size)
    for _ in range(2):
        if low.size == low_m.size or high.size == high_m.size:
            return None
        values = _product(columns, low_m[low], high_m[high])
        across = spline_through(high_m[high], np.moveaxis(values - known[np.ix_(low, high)], 1, 0))(np.log(high_m))
        difference = spline_through(low_m[low], np.moveaxis(across, 0, 1))(np.log(low_m))
        columns_at: Array = np.maximum(known + difference, np.minimum(np.min(values, axis=(0, 1)), 0.0))
        between = _between(low), _between(high)
        exact = _product(columns, low_m[between[0]], high_m[between[1]])
        guess = columns_at[np.ix_(*between)]
        if largest_error(np.sum(guess, axis=2), np.sum(exact, axis=2)) <= tolerance:
            return columns_at
        low, high = (np.union1d(old, new) for old, new in zip((low, high), between, strict=True))
    return None


def _first_places(size: int) -> Places:
    return np.unique(np.linspace(0, size - 1, FIRST_NODES).round().astype(np.intp))


def _between(places: Places) -> Places:
    """Middle nodes of the intervals that have one."""
    middle = (places[:-1] + places[1:]) // 2
    return np.setdiff1d(middle, places)


def _product(columns: ColumnsAt, low_m: Array, high_m: Array) -> Array:
    values = columns(np.stack(np.meshgrid(low_m, high_m, indexing="ij"), axis=-1).reshape(-1, 2))
    return values.reshape(low_m.size, high_m.size, *values.shape[1:])


@dataclass(frozen=True)
class ExactColumns:
    """Columns for one sun.

    Attributes
    ----------
    alone : tuple of ndarray (E, K, B)
        Columns with cloud in one layer only, for each layer, at the exact nodes of its axis; E = 0 for a layer
        without cloud.
    both : ndarray (E, F, K, B) or None
        Columns with cloud in both layers.
    """

    alone: tuple[Array, ...]
    both: Array | None

    def plus(self, other: ExactColumns, than: ExactColumns) -> ExactColumns:
        """Return these columns plus the difference of two others."""
        alone = tuple(values + a - b for values, a, b in zip(self.alone, other.alone, than.alone, strict=True))
        known = self.both is not None and other.both is not None and than.both is not None
        return ExactColumns(alone, self.both + other.both - than.both if known else None)  # type: ignore[operator]


class BandColumns:
    """Columns of a plan's radiance model in some settings, integrated over its bands; each column is computed once.

    Parameters
    ----------
    plan : Plan
    nodes : SpectralNodes
        Wavenumbers of cloudy columns.
    known : KnownColumns, optional
        Columns that others compute, too.
    """

    def __init__(self, plan: Plan, nodes: SpectralNodes, known: KnownColumns | None = None) -> None:
        self.plan = plan
        self.nodes = nodes
        # The changes by waves are computed at all wavenumbers, so the clear column they are added to is, too.
        self._clear_grid = nodes if plan.waves is None else all_nodes(plan.spectral_grid)
        terms = tuple(plan.assembly.model.terms)
        wanted = {spec.name.removeprefix(TERM_PREFIX) for spec in plan.computed}
        self._known = KnownColumns() if known is None else known
        self.quantities = Quantities(terms, tuple(name for name in terms if name in wanted))

    def of(self, plan: Plan) -> BandColumns:
        """Return the columns of another plan at the same wavenumbers."""
        return BandColumns(plan, self.nodes, self._known)

    def toward(self, views: Sequence[View], suns: Sequence[Sun | None]) -> list[ColumnSetting]:
        """Return the settings of the scene toward each view under the first sun, then the next."""
        return [self.plan.assembly.setting(sun, view) for sun in suns for view in views]

    def clear(self, settings: Sequence[ColumnSetting]) -> Array:
        """Terms of clear sky in each setting, (S, K, B)."""
        grid, cloudless = self._clear_grid, np.zeros((1, len(self.plan.layers)))
        spectra = spectra_of(self.plan.assembly.model, settings, grid.wavenumber_cm1, cloudless)
        return spectra[:, 0] @ grid.weights_cm1.T

    def cloudy(self, thickness_m: Array, settings: Sequence[ColumnSetting]) -> Array:
        """Terms (S, N, K, B) of cloudy columns with layers of thickness (N, L) in each of S settings."""
        self._compute(thickness_m, settings)
        model, rows = self.plan.assembly.model, list(map(tuple, thickness_m.tolist()))
        return np.stack([np.stack([self._known.bands[model, one, row] for row in rows]) for one in settings])

    def spectra(self, thickness_m: Array, settings: Sequence[ColumnSetting]) -> Array:
        """Terms (S, N, K, V) of the same columns, which a plan with texture keeps."""
        self._compute(thickness_m, settings)
        model, rows = self.plan.assembly.model, list(map(tuple, thickness_m.tolist()))
        return np.stack([np.stack([self._known.spectra[model, one, row] for row in rows]) for one in settings])

    def _compute(self, thickness_m: Array, settings: Sequence[ColumnSetting]) -> None:
        """Compute the columns that are not known yet, together."""
        model, rows = self.plan.assembly.model, list(map(tuple, thickness_m.tolist()))
        keys = [(model, setting, row) for setting in dict.fromkeys(settings) for row in dict.fromkeys(rows)]
        new = [key for key in keys if key not in self._known.bands]
        if not new:
            return
        states = ColumnStates.of([setting for _, setting, _ in new], np.array([row for *_, row in new]))
        terms = model.columns(states, self.nodes.wavenumber_cm1)
        spectra = np.stack([np.asarray(terms[name]) for name in self.quantities.terms], axis=1)
        self._known.bands.update(zip(new, spectra @ self.nodes.weights_cm1.T, strict=True))
        if self.plan.texture is not None:
            self._known.spectra.update(zip(new, spectra, strict=True))

    def alone(self, index: int, settings: Sequence[ColumnSetting]) -> ColumnsAt:
        """Function from thickness (N,) to columns (N, K, S x B) with cloud in one layer only."""

        def columns(thickness_m: Array) -> Array:
            layers = np.zeros((thickness_m.size, len(self.plan.layers)))
            layers[:, index] = thickness_m
            return beside(self.cloudy(layers, settings))

        return columns

    def probe(self, settings: Sequence[ColumnSetting]) -> Array:
        """Total radiance (S, N, B) of a few columns that bound the scene, in each setting."""
        total: Array = np.sum(self.clear(settings), axis=1)[:, None]
        if self.plan.waves is not None:
            waves = [probe_waves(self.plan, self.plan.waves, setting.sun) for setting in settings]
            total = np.concatenate((total, np.stack(waves)), axis=1)
        extremes = self.plan.assembly.extreme_thicknesses_m
        if extremes.shape[0] == 0:
            return total
        return np.concatenate((total, np.sum(self.cloudy(extremes, settings), axis=2)), axis=1)

    def exact(
        self,
        axes: tuple[ThicknessAxis | None, ...],
        pair: LayerPair | None,
        settings: Sequence[ColumnSetting],
        known: Sequence[Sequence[ExactColumns]] = (),
        tolerance: float = 0.0,
        smooth: bool = True,
    ) -> list[ExactColumns]:
        """Columns at the exact nodes of all axes, in each of S settings.

        Parameters
        ----------
        known : sequence (A) of sequence (S) of ExactColumns
            Columns from which those of each setting are derived: under other suns, toward other views or of few
            streams; of several, their combination.
        tolerance : float
            For derived columns, of the total of any band.
        smooth : bool
            Whether their difference from these is smooth in both thicknesses, where two layers have cloud.
        """
        nothing = np.empty((len(settings), 0, len(self.quantities.terms), len(self.plan.bands)))
        alone: list[Array] = []
        for index, axis in enumerate(axes):
            if axis is None:
                alone.append(nothing)
                continue
            columns = self.alone(index, settings)
            if known:
                others = [beside(np.stack([exact.alone[index] for exact in of_settings])) for of_settings in known]
                values = single_layer(columns, axis.exact_m, np.stack(others), tolerance)
            else:
                values = columns(axis.exact_m)
            alone.append(apart(values, len(settings)))
        pairs: Sequence[Array | None] = [None] * len(settings)
        if pair is not None:
            pairs = self._both(pair, settings, known, tolerance if smooth else 0.0)
        return [ExactColumns(tuple(values[n] for values in alone), both) for n, both in enumerate(pairs)]

    def _both(
        self,
        pair: LayerPair,
        settings: Sequence[ColumnSetting],
        known: Sequence[Sequence[ExactColumns]],
        tolerance: float,
    ) -> list[Array]:
        """Columns (E, F, K, B) with cloud in two layers, in each setting; by splines if the tolerance is above 0."""
        near: list[Array | None] = [None] * len(settings)
        if known:
            near = [exact.both for exact in known[0]]
        if tolerance > 0.0:
            others = beside(np.stack([values for values in near if values is not None]))
            both = layer_pair(
                lambda h: beside(self.cloudy(h, settings)), pair.low.exact_m, pair.high.exact_m, others, tolerance
            )
            if both is not None:
                return list(apart(both, len(settings)))
        return [
            pair.exact(lambda h, one=setting: self.cloudy(h, [one])[0], values)  # type: ignore[misc]
            for setting, values in zip(settings, near, strict=True)
        ]

    def table(self, axes: tuple[ThicknessAxis | None, ...], exact: ExactColumns, clear: Array) -> InstantTable:
        """Radiance table of one setting, whose clear sky has terms (K, B)."""
        quantities = self.quantities.of(clear)
        return InstantTable(
            quantities,
            tuple(
                np.empty((0, *quantities.shape)) if axis is None else self.quantities.of(axis.interpolate(values))
                for axis, values in zip(axes, exact.alone, strict=True)
            ),
            exact.both,
        )

    def tables(
        self, axes: tuple[ThicknessAxis | None, ...], exact: Sequence[ExactColumns], settings: Sequence[ColumnSetting]
    ) -> tuple[InstantTable, ...]:
        """Radiance tables of some settings."""
        clear = self.clear(settings)
        return tuple(self.table(axes, columns, of_clear) for columns, of_clear in zip(exact, clear, strict=True))


ColumnKey = tuple[RadianceModel, ColumnSetting, tuple[float, ...]]


@dataclass
class KnownColumns:
    """Columns that were computed, by model, setting and thicknesses: terms (K, B), and spectra (K, V) for texture."""

    bands: dict[ColumnKey, Array] = field(default_factory=dict)
    spectra: dict[ColumnKey, Array] = field(default_factory=dict)


def beside(values: Array) -> Array:
    """Put the bands of settings side by side: (S, ..., B) to (..., S x B)."""
    moved = np.moveaxis(values, 0, -2)
    return moved.reshape(*moved.shape[:-2], -1)


def apart(values: Array, count: int) -> Array:
    """Undo :func:`beside`: (..., S x B) to (S, ..., B)."""
    return np.ascontiguousarray(np.moveaxis(values.reshape(*values.shape[:-1], count, -1), -2, 0))
