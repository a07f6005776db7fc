"""Radiance tables: band radiance as a function of cloud-layer thickness (and of time if the sun moves)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.cached_method import cached_method
from hcss_twin.engine.tables.layer_pair import LayerPair
from hcss_twin.engine.tables.spectrum import Spectrum
from hcss_twin.engine.tables.thickness_axis import ThicknessAxis
from hcss_twin.plan.accuracy import Budget

TOTAL = "radiance"


@dataclass(frozen=True)
class Quantities:
    """Quantities of the look-up: total radiance and requested terms.

    Attributes
    ----------
    terms : tuple of str (K,)
        All terms of the radiance model.
    wanted : tuple of str
        Terms that are looked up in addition to the total.
    """

    terms: tuple[str, ...]
    wanted: tuple[str, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """``radiance`` and the requested terms, (Q,)."""
        return TOTAL, *self.wanted

    def of(self, terms: Array) -> Array:
        """Compute the quantities (..., Q, B) from terms (..., K, B)."""
        picked = [terms[..., self.terms.index(name), :] for name in self.wanted]
        return np.stack([np.sum(terms, axis=-2), *picked], axis=-2)


@dataclass(frozen=True)
class InstantTable:
    """Band radiance at one instant.

    Attributes
    ----------
    clear : ndarray (Q, B)
        The clear column.
    alone : tuple of ndarray (N, Q, B)
        For each layer, columns with cloud in this layer only, at the dense nodes of its axis; N = 0 for a layer
        that never has cloud.
    both : ndarray (E, F, K, B) or None
        Terms of columns with cloud in both layers, at the exact nodes of their axes; None unless there are two.
    """

    clear: Array
    alone: tuple[Array, ...]
    both: Array | None


@dataclass(frozen=True)
class DenseTable:
    """Band radiance at one instant, ready to be looked up.

    Attributes
    ----------
    clear : ndarray (C,)
        The clear column; C = Q x B.
    nodes_m : tuple of ndarray (N,)
        Thickness nodes of each layer, ascending, above 0; empty for a layer that never has cloud.
    alone : tuple of ndarray (N, C)
    both : ndarray of float32 (N, M, C) or None
    """

    clear: Array
    nodes_m: tuple[Array, ...]
    alone: tuple[Array, ...]
    both: NDArray[np.float32] | None

    @cached_property
    def pair(self) -> NDArray[np.float32]:
        """Columns (2 + N, 2 + M, C) of two layers, without cloud twice before the nodes of either."""
        assert self.both is not None
        lower, upper = self.alone
        pair = np.empty((lower.shape[0] + 2, upper.shape[0] + 2, self.clear.size), np.float32)
        pair[:2, :2], pair[:2, 2:], pair[2:, :2], pair[2:, 2:] = self.clear, upper, lower[:, None], self.both
        return pair

    def blend(self, other: DenseTable, weight: float) -> DenseTable:
        """Interpolate linearly toward ``other``, with the same nodes."""
        if weight == 0.0:
            return self
        both: NDArray[np.float32] | None = None
        if self.both is not None and other.both is not None:
            # Not self + weight (other - self): small night values would be lost in the rounding of day values.
            both = other.both * np.float32(weight)
            for row, before in zip(both, self.both, strict=True):  # row by row, as these tables are large
                row += np.float32(1 - weight) * before
        return DenseTable(
            (1 - weight) * self.clear + weight * other.clear,
            self.nodes_m,
            tuple((1 - weight) * a + weight * b for a, b in zip(self.alone, other.alone, strict=True)),
            both,
        )


@dataclass(frozen=True)
class ShadowTables:
    """Radiance that clear points lose in cloud shadow.

    Attributes
    ----------
    time_s : tuple of float (T,)
        Time nodes of the radiance tables.
    longest_m : ndarray (L,)
        Longest path of sunlight in each layer.
    loss : ndarray (T, Q, B)
        Sea-reflected direct sunlight in each quantity of the clear column.
    depth : ndarray (T, L, N, B)
        Negative logarithm of the direct band transmission, at paths uniform in the square root from 0 to the longest.
    """

    time_s: tuple[float, ...]
    longest_m: Array
    loss: Array
    depth: Array

    def at(self, time_s: float) -> tuple[Array, Array]:
        """Return ``loss`` (Q, B) and ``depth`` (L, N, B) at a time within the nodes, as in :class:`TableReader`."""
        index, weight = interval(self.time_s, time_s)
        after = min(index + 1, len(self.time_s) - 1)
        loss: Array = (1 - weight) * self.loss[index] + weight * self.loss[after]
        depth: Array = (1 - weight) * self.depth[index] + weight * self.depth[after]
        return loss, depth


@dataclass(frozen=True)
class WaveTables:
    """Change of clear radiance with wave slope.

    Attributes
    ----------
    reach : (float, float)
        Largest slope of the table, upwind and crosswind.
    change : tuple of ndarray of float32 (N, M, C)
        At each time node: W m-2 sr-1 for every band and quantity, at slopes evenly spaced from -reach to reach,
        upwind and then crosswind (clockwise from upwind). Its mean over the waves is 0.
    level : tuple of ndarray (K, B)
        At each time node: factor that scales the mean of each term to the radiance of the mean sea.
    estimated_error : float
        Relative to the total, measured between the nodes during their placement.
    """

    reach: tuple[float, float]
    change: tuple[NDArray[np.float32], ...]
    level: tuple[Array, ...]
    estimated_error: float


@dataclass(frozen=True)
class TextureTables:
    """Tables of the perturbed states of clear-sky texture.

    Attributes
    ----------
    states : tuple of tuple of InstantTable
        For each perturbed state, at each time node: the warmer sea, if its temperature has texture, then those of
        :data:`hcss_twin.plan.texture.VAPOUR_PLACES` that are used.
    square : ndarray (Q, B)
        Part of the difference by a warmer sea that is quadratic in the perturbation, of the clear column.
    mixed : ndarray (2, Q, B)
        Relative change of this difference with the vapour, linear and quadratic.
    estimated_error : float
        Relative to the total, at one and at two standard deviations of both.
    """

    states: tuple[tuple[InstantTable, ...], ...]
    square: Array
    mixed: Array
    estimated_error: float


@dataclass(frozen=True)
class RadianceTables:
    """Tables at time nodes.

    Attributes
    ----------
    time_s : tuple of float (T,)
        Time nodes; a single one if the sun does not matter.
    axes : tuple of ThicknessAxis or None
        Axis of each layer, from the lowest to the highest; None for a layer that never has cloud.
    pair : LayerPair or None
        Axes for both layers together, equal to ``axes``.
    tables : tuple of InstantTable (T,)
        Tables at the nodes.
    spectrum : Spectrum
        Wavenumbers of each column.
    errors : Budget
        Relative errors of the total, measured for each approximation during node placement.
    shadows : ShadowTables or None
        None if no cloud casts shadows.
    waves : WaveTables or None
        Change of the clear column by resolved waves, at the same time nodes; None for a statistical sea.
    texture : TextureTables or None
        Perturbed states of the same columns; None without clear-sky texture.
    over_views : tuple of RadianceTables
        Tables for each view if view angles vary over the image; these tables are then one of them, with the largest
        errors of all.
    over_states : tuple of RadianceTables
        Tables for each state of the points (:mod:`.point_states`), if it differs; these tables are then one of them,
        with the largest errors of all.
    state_error : float
        Relative error of the interpolation between these states.
    """

    quantities: Quantities
    time_s: tuple[float, ...]
    axes: tuple[ThicknessAxis | None, ...]
    pair: LayerPair | None
    tables: tuple[InstantTable, ...]
    spectrum: Spectrum
    errors: Budget
    shadows: ShadowTables | None = None
    waves: WaveTables | None = None
    texture: TextureTables | None = None
    over_views: tuple[RadianceTables, ...] = ()
    over_states: tuple[RadianceTables, ...] = ()
    state_error: float = 0.0

    @property
    def estimated_error(self) -> float:
        """Largest sum of the relative errors of the total."""
        texture = 0.0 if self.texture is None else self.texture.estimated_error
        return self.errors.total + self.state_error + texture


class TableReader:
    """Tables for look-up at any time within the nodes.

    Dense tables of two layers are large: only those of the two current time nodes are kept, so request frames in the
    order of time.
    """

    def __init__(self, tables: RadianceTables) -> None:
        self._tables = tables
        self._dense = cached_method(self._dense_at_node, 2)

    def at(self, time_s: float) -> DenseTable:
        """Return the table at a time within the nodes."""
        nodes = self._tables.time_s
        index, weight = interval(nodes, time_s)
        if len(nodes) == 1:
            return self._dense(index)
        return self._dense(index).blend(self._dense(index + 1), weight)

    def _dense_at_node(self, index: int) -> DenseTable:
        tables, table = self._tables, self._tables.tables[index]
        both = None
        if tables.pair is not None and table.both is not None:
            both = tables.pair.dense(table.both, tables.quantities.of)
        return DenseTable(
            clear=table.clear.ravel(),
            nodes_m=tuple(np.empty(0) if axis is None else axis.dense_m for axis in tables.axes),
            alone=tuple(columns.reshape(columns.shape[0], table.clear.size) for columns in table.alone),
            both=both,
        )


def interval(nodes: tuple[float, ...], time_s: float) -> tuple[int, float]:
    """Interval of a time, and the weight of its end node; 0 and 0 for a single node."""
    if len(nodes) == 1:
        return 0, 0.0
    index = int(np.clip(np.searchsorted(nodes, time_s, side="right") - 1, 0, len(nodes) - 2))
    return index, (time_s - nodes[index]) / (nodes[index + 1] - nodes[index])


def with_largest_errors(every: Sequence[RadianceTables]) -> RadianceTables:
    """Return the tables with the most wavenumbers, with the largest error of each kind among all tables."""
    largest = max(every, key=lambda tables: tables.spectrum.nodes.wavenumber_cm1.size)
    errors = {field.name: max(getattr(tables.errors, field.name) for tables in every) for field in fields(Budget)}
    return replace(largest, errors=Budget(**errors))
