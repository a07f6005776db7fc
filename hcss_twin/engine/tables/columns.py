"""Columns of a scene, integrated over the bands, in several settings at once.

A setting is a view, a sun and a state of sea and air. Columns in another one differ little and smoothly from those in a
first one: the difference needs few nodes. Axes see the bands of all settings side by side.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import reduce
from itertools import islice, product
from typing import ClassVar

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.cube.variables import TERM_PREFIX
from hcss_twin.engine.tables.radiance_tables import InstantTable, Quantities
from hcss_twin.engine.tables.tensor_train import Indices, TensorTrain, beside, cross, spread, total
from hcss_twin.engine.tables.thickness_axis import ThicknessAxis
from hcss_twin.engine.tables.waves import probe_waves
from hcss_twin.models.radiance.spectral_grid import SpectralNodes
from hcss_twin.physics import quadrature
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import ColumnSetting, ColumnStates, RadianceModel, Sun, View
from hcss_twin.providers.column_states import spectra_of

FIRST_NODES = 5
"""Nodes along each axis for a difference from columns that are known; doubled until it is accurate."""

TRIED = 40
"""Elements of several layers by which known columns are combined, and by which the result is tested."""

DARK = 1e-12
"""Radiance beside that of known columns that counts as none: a night is no combination of days."""

SMALLEST_SHARE = 1e-8
"""Combinations of known columns that differ by less than this, relative, count as one."""

CROSS_SHARE = 0.5
"""Share of the tolerance for the elements of a tensor train that are tried: few elements miss the worst one."""

ROUNDED_SHARE = 0.01
"""Share of the tolerance by which a tensor train is rounded."""

Axes = Sequence[ThicknessAxis | None]


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

    proportional: ClassVar[bool] = False
    """Whether terms are nearly multiples of those of the columns that they are derived from."""

    def __init__(self, plan: Plan, nodes: SpectralNodes, known: KnownColumns | None = None) -> None:
        self.plan = plan
        self.nodes = nodes
        # The changes by waves are computed at all wavenumbers, so the clear column they are added to is, too.
        self._clear_grid = plan.spectral_grid.all_nodes() if plan.waves.varies else nodes
        terms = tuple(plan.assembly.model.terms)
        wanted = {spec.name.removeprefix(TERM_PREFIX) for spec in plan.computed}
        self.known = KnownColumns() if known is None else known
        self.quantities = Quantities(terms, tuple(name for name in terms if name in wanted))

    def of(self, plan: Plan) -> BandColumns:
        """Return the columns of another plan at the same wavenumbers."""
        return BandColumns(plan, self.nodes, self.known)

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
        return np.stack([np.stack([self.known.bands[model, one, row] for row in rows]) for one in settings])

    def spectra(self, thickness_m: Array, settings: Sequence[ColumnSetting]) -> Array:
        """Terms (S, N, K, V) of the same columns, which a plan keeps if those over a warmer sea follow from them."""
        self._compute(thickness_m, settings)
        model, rows = self.plan.assembly.model, list(map(tuple, thickness_m.tolist()))
        return np.stack([np.stack([self.known.spectra[model, one, row] for row in rows]) for one in settings])

    def _compute(self, thickness_m: Array, settings: Sequence[ColumnSetting]) -> None:
        """Compute the columns that are not known yet, together."""
        model, rows = self.plan.assembly.model, list(map(tuple, thickness_m.tolist()))
        keys = [(model, setting, row) for setting in dict.fromkeys(settings) for row in dict.fromkeys(rows)]
        new = [key for key in keys if key not in self.known.bands]
        if not new:
            return
        states = ColumnStates.of([setting for _, setting, _ in new], np.array([row for *_, row in new]))
        terms = model.columns(states, self.nodes.wavenumber_cm1)
        spectra = np.stack([np.asarray(terms[name]) for name in self.quantities.terms], axis=1)
        self.known.bands.update(zip(new, spectra @ self.nodes.weights_cm1.T, strict=True))
        if self.plan.texture.sea_is_proportional(self.plan.assembly):
            self.known.spectra.update(zip(new, spectra, strict=True))

    def also_in(self, settings: Sequence[ColumnSetting], before: int) -> None:
        """Compute the columns that another setting needed since ``before`` were known: together they cost less."""
        model = self.plan.assembly.model
        rows = [row for of_model, _, row in islice(self.known.bands, before, None) if of_model is model]
        if rows:
            self._compute(np.array(rows), settings)

    def along(self, index: int, settings: Sequence[ColumnSetting]) -> Callable[[Array], Array]:
        """Function from the thickness (N,) of a layer to columns (N, lines, K, S x B).

        Other layers have no cloud, clouds of medium thickness or their thickest ones.
        """
        others = np.array([layer.thickness_max_m for layer in self.plan.layers]) * self.plan.assembly.cloudy_layers
        least = np.array([layer.thickness_min_m for layer in self.plan.layers]) * self.plan.assembly.cloudy_layers
        others[index] = least[index] = 0.0
        lines = np.unique([np.zeros_like(others), np.sqrt(others * least), others], axis=0)

        def columns(thickness_m: Array) -> Array:
            layers = np.repeat(lines[None], thickness_m.size, axis=0)
            layers[:, :, index] = thickness_m[:, None]
            found = side_by_side(self.cloudy(layers.reshape(-1, layers.shape[2]), settings))
            return found.reshape(*layers.shape[:2], *found.shape[1:])

        return columns

    def probe(self, settings: Sequence[ColumnSetting]) -> Array:
        """Total radiance (S, N, B) of a few columns that bound the scene, in each setting."""
        radiance: Array = np.sum(self.clear(settings), axis=1)[:, None]
        if self.plan.waves.varies:
            waves = [probe_waves(self.plan, setting.sun) for setting in settings]
            radiance = np.concatenate((radiance, np.stack(waves)), axis=1)
        extremes = self.plan.assembly.extreme_thicknesses_m
        if extremes.shape[0] == 0:
            return radiance
        return np.concatenate((radiance, np.sum(self.cloudy(extremes, settings), axis=2)), axis=1)

    def exact(
        self,
        axes: Axes,
        settings: Sequence[ColumnSetting],
        tolerance: float,
        known: Sequence[Sequence[TensorTrain]] = (),
    ) -> list[TensorTrain]:
        """Columns in each of S settings: K x B functions of the thickness of each layer that can have cloud.

        Parameters
        ----------
        tolerance : float
            For what is not computed, of the total of any band.
        known : sequence (A) of sequence (S) of TensorTrain
            Columns from which those of each setting are derived: under other suns, toward other views or of few
            streams; of several, their combination.
        """
        elements = _Elements(self, axes, settings)
        if not elements.sizes:
            return [TensorTrain(())] * len(settings)
        if not known:
            return elements.apart(elements.computed(tolerance))
        return elements.apart(elements.derived([*map(elements.together, known)], tolerance))

    def tables(self, exact: Sequence[TensorTrain], settings: Sequence[ColumnSetting]) -> tuple[InstantTable, ...]:
        """Radiance tables of some settings."""
        clear = self.quantities.of(self.clear(settings))
        return tuple(InstantTable(of_clear, columns) for columns, of_clear in zip(exact, clear, strict=True))


class _Elements:
    """Columns of some settings at no cloud and at the exact nodes of each layer that can have cloud.

    All settings are side by side: functions are K x S x B.
    """

    def __init__(self, columns: BandColumns, axes: Axes, settings: Sequence[ColumnSetting]) -> None:
        self._columns, self._settings = columns, settings
        self._layers = [index for index, axis in enumerate(axes) if axis is not None]
        self._nodes = [np.concatenate(((0.0,), axis.exact_m)) for axis in axes if axis is not None]
        self.sizes = [nodes.size for nodes in self._nodes]
        self._terms = len(columns.quantities.terms)

    def at(self, nodes: Indices) -> Array:
        """Return columns (N, K x S x B) of elements (N, L)."""
        thickness_m = np.zeros((len(nodes), len(self._columns.plan.layers)))
        for layer, of_layer, number in zip(self._layers, self._nodes, nodes.T, strict=True):
            thickness_m[:, layer] = of_layer[number]
        return side_by_side(self._columns.cloudy(thickness_m, self._settings)).reshape(len(nodes), -1)

    def errors(self, guess: Array, exact: Array) -> Array:
        """Return the largest error (N,) of the totals of some columns."""
        totals = [np.sum(values.reshape(len(values), self._terms, -1), axis=1) for values in (guess, exact)]
        size = np.maximum(np.abs(totals[1]), np.finfo(float).tiny)
        errors: Array = np.max(np.abs(totals[0] - totals[1]) / size, axis=1)
        return errors

    def computed(self, tolerance: float) -> TensorTrain:
        """Return the columns from those along some lines."""
        return cross(self.at, self.sizes, self.errors, CROSS_SHARE * tolerance)[0]

    def derived(self, known: Sequence[TensorTrain], tolerance: float) -> TensorTrain:
        """Return the columns from a combination of known ones, and the difference from it at few nodes."""
        count = FIRST_NODES
        while True:
            few = [_nearest(nodes, count) for nodes in self._nodes]
            tried = self._tried(few)
            if len(few) == 1:  # one call costs less than two
                self.at(np.concatenate((few[0][:, None], tried)))
            near = self._combination(known, few, ROUNDED_SHARE * tolerance)
            near_few = TensorTrain(tuple(core[:, :, some] for core, some in zip(near.cores, few, strict=True)))

            def at_few(nodes: Indices, few: Sequence[Indices] = few) -> Array:
                return self.at(np.stack([some[of_layer] for some, of_layer in zip(few, nodes.T, strict=True)], axis=1))

            sizes = [some.size for some in few]
            change = cross(at_few, sizes, self.errors, CROSS_SHARE * tolerance, near_few)[0]
            if self._columns.proportional and len(few) == 1:
                spread = self._between(change.over(near_few, 0.0), few).times(near)
            else:
                spread = self._between(change, few)
            whole = total([near, spread], [1.0, 1.0]).rounded(ROUNDED_SHARE * tolerance)
            if not len(tried) or np.max(self.errors(whole.at(tried), self.at(tried))) <= tolerance:
                return whole
            count = 2 * count - 1

    def _combination(self, known: Sequence[TensorTrain], few: Sequence[Indices], tolerance: float) -> TensorTrain:
        """Return the combination of known columns whose total in each band is nearest at some elements."""
        if len(known) == 1:
            return known[0]
        every = np.array(list(product(*few)))
        some = every[np.linspace(0, len(every) - 1, min(TRIED, len(every))).astype(int)]
        goal, *totals = (
            np.sum(values.reshape(len(some), self._terms, -1), axis=1)
            for values in (self.at(some), *(train.at(some) for train in known))
        )
        every_total = np.stack(totals, axis=-1)
        darkest = np.finfo(float).tiny + DARK * np.max(np.abs(every_total), axis=(0, 2))
        shares = every_total / np.maximum(np.abs(goal), darkest)[..., None]
        factors = np.array(
            [np.linalg.lstsq(band, np.ones(len(some)), rcond=SMALLEST_SHARE)[0] for band in shares.swapaxes(0, 1)]
        )
        parts = [
            train.mixed(np.tile(of_train[:, None, None], (self._terms, 1, 1)))
            for train, of_train in zip(known, factors.T, strict=True)
        ]
        # One after another: all together would have large matrices.
        return reduce(lambda whole, part: total([whole, part], [1.0, 1.0]).rounded(tolerance), parts)

    def _between(self, change: TensorTrain, few: Sequence[Indices]) -> TensorTrain:
        """Return the change at all nodes, by the polynomials through few: without cloud it is known."""

        def at_all(which: int, values: Array) -> Array:
            ln_nodes = np.log(self._nodes[which][1:])
            weights = quadrature.lagrange(ln_nodes[few[which][1:] - 1], ln_nodes)
            return np.concatenate((values[:1], np.tensordot(weights, values[1:], 1)))

        return change.each(at_all)

    def _tried(self, few: Sequence[Indices]) -> Indices:
        """Return elements (N, L) that are not at few nodes; none if these are all."""
        if len(few) == 1:
            middle = (few[0][1:-1] + few[0][2:]) // 2
            return np.setdiff1d(middle, few[0])[:, None]
        if all(some.size == size for some, size in zip(few, self.sizes, strict=True)):
            return np.empty((0, len(few)), np.intp)
        return spread(self.sizes, 0, TRIED)

    def together(self, of_settings: Sequence[TensorTrain]) -> TensorTrain:
        """Return the columns of all settings side by side, K x S x B, from those of each, K x B."""
        settings, functions = len(of_settings), of_settings[0].cores[0].shape[0]
        number = np.arange(settings * functions).reshape(settings, self._terms, -1)
        return beside(of_settings).of(number.swapaxes(0, 1).ravel())

    def apart(self, train: TensorTrain) -> list[TensorTrain]:
        """Return the columns of each setting, K x B."""
        settings = len(self._settings)
        number = np.arange(train.cores[0].shape[0]).reshape(self._terms, settings, -1)
        return [train.of(number[:, setting].ravel()) for setting in range(settings)]


def _nearest(nodes_m: Array, count: int) -> Indices:
    """Return no cloud, and which of the nodes are nearest to so many Chebyshev points of ln(thickness)."""
    ln_nodes = np.log(nodes_m[1:])
    wanted = 0.5 * (ln_nodes[0] + ln_nodes[-1]) + 0.5 * (ln_nodes[-1] - ln_nodes[0]) * quadrature.nodes(count - 1)
    if count >= ln_nodes.size:
        return np.arange(nodes_m.size)
    return np.unique((0, *(1 + np.searchsorted(0.5 * (ln_nodes[1:] + ln_nodes[:-1]), wanted))))


ColumnKey = tuple[RadianceModel, ColumnSetting, tuple[float, ...]]


@dataclass
class KnownColumns:
    """Columns that were computed, by model, setting and thicknesses: terms (K, B), and spectra (K, V) for texture.

    ``warmer``: terms over a warmer sea toward some view, over those of the scene.
    """

    bands: dict[ColumnKey, Array] = field(default_factory=dict)
    spectra: dict[ColumnKey, Array] = field(default_factory=dict)
    warmer: TensorTrain | None = None


def side_by_side(values: Array) -> Array:
    """Put the bands of settings side by side: (S, ..., B) to (..., S x B)."""
    moved = np.moveaxis(values, 0, -2)
    return moved.reshape(*moved.shape[:-2], -1)
