"""Columns of a scene, integrated over the bands.

Columns for another sun differ little and smoothly from those for a first sun: the difference needs few nodes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.cube.variables import TERM_PREFIX
from hcss_twin.engine.tables.layer_pair import LayerPair
from hcss_twin.engine.tables.radiance_tables import InstantTable, Quantities
from hcss_twin.engine.tables.thickness_axis import ColumnsAt, ThicknessAxis, relative, spline_through, total
from hcss_twin.engine.tables.waves import probe_waves
from hcss_twin.models.radiance.spectral_grid import SpectralNodes, all_nodes
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import Sun

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
        error = relative(total(guess), total(exact))
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
        if relative(np.sum(guess, axis=2), np.sum(exact, axis=2)) <= tolerance:
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
    """Columns of a plan's radiance model, integrated over its bands."""

    def __init__(self, plan: Plan, nodes: SpectralNodes) -> None:
        self.plan = plan
        self.nodes = nodes
        # The changes by waves are computed at all wavenumbers, so the clear column they are added to is, too.
        self._clear_grid = nodes if plan.waves is None else all_nodes(plan.spectral_grid)
        terms = tuple(plan.assembly.model.terms)
        wanted = {spec.name.removeprefix(TERM_PREFIX) for spec in plan.computed}
        self._known: dict[tuple[Sun | None, tuple[float, ...]], Array] = {}
        self._spectra: dict[tuple[Sun | None, tuple[float, ...]], Array] = {}
        self.quantities = Quantities(terms, tuple(name for name in terms if name in wanted))

    def of(self, plan: Plan) -> BandColumns:
        """Return the columns of another plan at the same wavenumbers."""
        return BandColumns(plan, self.nodes)

    def clear(self, sun: Sun | None) -> Array:
        """Terms of the clear column, (K, B)."""
        grid = self._clear_grid
        return self._to_bands(self.plan.assembly.model.clear(grid.wavenumber_cm1, sun), grid)

    def cloudy(self, thickness_m: Array, sun: Sun | None) -> Array:
        """Terms of cloudy columns (N, K, B) from the thickness of each layer (N, L); each column is computed once."""
        keys = [(sun, tuple(row)) for row in thickness_m.tolist()]
        new = [row for row, key in enumerate(keys) if key not in self._known]
        if new:
            spectra = self.plan.assembly.model.cloudy(self.nodes.wavenumber_cm1, thickness_m[new], sun)
            for row, terms in zip(new, self._to_bands(spectra, self.nodes), strict=True):
                self._known[keys[row]] = terms
            if self.plan.texture is not None:
                stacked = np.stack([np.asarray(spectra[name]) for name in self.quantities.terms], axis=1)
                self._spectra.update(zip([keys[row] for row in new], stacked, strict=True))
        return np.stack([self._known[key] for key in keys])

    def spectra(self, thickness_m: Array, sun: Sun | None) -> Array:
        """Terms (N, K, V) of the same columns, which a plan with texture keeps."""
        self.cloudy(thickness_m, sun)
        return np.stack([self._spectra[sun, tuple(row)] for row in thickness_m.tolist()])

    def alone(self, index: int, sun: Sun | None) -> ColumnsAt:
        """Function from thickness (N,) to columns with cloud in one layer only."""

        def columns(thickness_m: Array) -> Array:
            layers = np.zeros((thickness_m.size, len(self.plan.layers)))
            layers[:, index] = thickness_m
            return self.cloudy(layers, sun)

        return columns

    def probe(self, sun: Sun | None) -> Array:
        """Total radiance (N, B) of a few columns that bound the scene."""
        clear: Array = np.sum(self.clear(sun), axis=0)[None, :]
        if self.plan.waves is not None:
            clear = np.concatenate((clear, probe_waves(self.plan, self.plan.waves, sun)))
        extremes = self.plan.assembly.extreme_thicknesses_m
        if extremes.shape[0] == 0:
            return clear
        cloudy: Array = np.sum(self.cloudy(extremes, sun), axis=1)
        return np.concatenate((clear, cloudy))

    def exact(
        self,
        axes: tuple[ThicknessAxis | None, ...],
        pair: LayerPair | None,
        sun: Sun | None,
        known: Sequence[ExactColumns] = (),
        tolerance: float = 0.0,
        few: ExactColumns | None = None,
    ) -> ExactColumns:
        """Columns at the exact nodes of all axes; derived from those for other suns or views, or ``few`` streams."""
        nothing = np.empty((0, len(self.quantities.terms), len(self.plan.bands)))
        near = known or (() if few is None else (few,))
        alone: list[Array] = []
        for index, axis in enumerate(axes):
            columns = self.alone(index, sun)
            if axis is None:
                alone.append(nothing)
            elif not near:
                alone.append(columns(axis.exact_m))
            else:
                others = np.stack([exact.alone[index] for exact in near])
                alone.append(single_layer(columns, axis.exact_m, others, tolerance))

        def both_layers(thickness_m: Array) -> Array:
            return self.cloudy(thickness_m, sun)

        both: Array | None = None
        if pair is not None:
            if known and known[0].both is not None:
                both = layer_pair(both_layers, pair.low.exact_m, pair.high.exact_m, known[0].both, tolerance)
            if both is None:
                both = pair.exact(both_layers, near[0].both if near else None)
        return ExactColumns(tuple(alone), both)

    def table(self, axes: tuple[ThicknessAxis | None, ...], exact: ExactColumns, sun: Sun | None) -> InstantTable:
        """Radiance table at one instant."""
        clear = self.quantities.of(self.clear(sun))
        return InstantTable(
            clear,
            tuple(
                np.empty((0, *clear.shape)) if axis is None else self.quantities.of(axis.interpolate(values))
                for axis, values in zip(axes, exact.alone, strict=True)
            ),
            exact.both,
        )

    def _to_bands(self, terms: Mapping[str, Array], grid: SpectralNodes) -> Array:
        """Integrate spectra (..., V) over the bands and stack the terms: (..., K, B)."""
        weights = grid.weights_cm1.T
        return np.stack([np.asarray(terms[name]) @ weights for name in self.quantities.terms], axis=-2)
