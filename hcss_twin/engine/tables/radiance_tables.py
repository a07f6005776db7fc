"""Radiance tables: band radiance as a function of cloud-layer thickness (and of time if the sun moves)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.cache import TABLES, recall_or_compute, result_key
from hcss_twin.cube.variables import TOTAL
from hcss_twin.engine.tables.spectrum import Spectrum
from hcss_twin.engine.tables.table_key import table_key
from hcss_twin.engine.tables.tensor_train import TensorTrain, beside, fewest_states, stacked, total
from hcss_twin.engine.tables.thickness_axis import ThicknessAxis
from hcss_twin.physics.quadrature import lagrange
from hcss_twin.plan.accuracy import Budget
from hcss_twin.plan.plan import Plan

__all__ = ["RadianceTables"]

_T = TypeVar("_T")


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
    columns : TensorTrain
        K x B terms as functions of the thickness of each layer that can have cloud, at none and at the exact nodes of
        its axis; without variables if no layer can.
    """

    clear: Array
    columns: TensorTrain


@dataclass(frozen=True)
class DenseTable:
    """Band radiance at one instant, ready to be looked up.

    Attributes
    ----------
    clear : ndarray (R, C)
        The clear column in R states; C = Q x B.
    nodes_m : tuple of ndarray (N,)
        Thickness nodes of each layer, ascending, above 0; empty for a layer that never has cloud.
    columns : TensorTrain
        R x C functions of the thickness of each layer that can have cloud, at none and at its nodes.
    bands : int
        B, if all terms follow the total; 0 if their sum need not be the total.
    """

    clear: Array
    nodes_m: tuple[Array, ...]
    columns: TensorTrain
    bands: int = 0

    @property
    def channels(self) -> int:
        """Number of quantities times bands, C."""
        return int(self.clear.shape[1])

    def blend(self, other: DenseTable, weight: float) -> DenseTable:
        """Interpolate linearly toward ``other``, with the same nodes."""
        if weight in (0.0, 1.0):
            return (self, other)[int(weight)]
        clear = (1.0 - weight) * self.clear + weight * other.clear
        one, two, shares = self.columns, other.columns, (1.0 - weight, weight)
        if len(one.cores) > 1:
            return replace(self, clear=clear, columns=total([one, two], shares).rounded(ROUNDING))
        # As shadows are blended, to the bit: what they take is no more than there is.
        cores = tuple(shares[0] * a + shares[1] * b for a, b in zip(one.cores, two.cores, strict=True))
        return replace(self, clear=clear, columns=TensorTrain(cores))

    def mixed(self, weights: Array) -> DenseTable:
        """Return sums over states with weights (M, R)."""
        columns = self.columns.mixed(weights) if self.columns.cores else self.columns
        return replace(self, clear=weights @ self.clear, columns=columns)

    def in_state(self, number: int) -> DenseTable:
        """Return the table of one state."""
        some = slice(number, number + 1)
        first = (self.columns.cores[0][:, some], *self.columns.cores[1:]) if self.columns.cores else ()
        return replace(self, clear=self.clear[some], columns=TensorTrain(first))

    def fewest(self, lost: float) -> tuple[DenseTable, Array | None]:
        """Return the fewest states whose combinations, with weights (R, M), equal all within a relative error.

        Those of several layers are not combined (None).
        """
        if len(self.columns.cores) != 1:
            return self, None
        (core,), states = self.columns.cores, self.clear.shape[0]
        every = np.concatenate((self.clear, core[..., 0].swapaxes(0, 1).reshape(states, -1)), axis=1)
        size = np.maximum(np.abs(every), 1e-6 * np.abs(every).max() + 1e-300)
        weights, components = fewest_states(every, size, lost)
        count = len(components)
        clear, columns = np.split(components, [self.channels], axis=1)
        mixed = columns.reshape(count, self.channels, -1).swapaxes(0, 1)[..., None]
        return replace(self, clear=clear, columns=TensorTrain((mixed,))), weights


ROUNDING = 1e-8
"""Rounding of tables of several layers, relative to their root mean square."""


def stacked_tables(tables: Sequence[DenseTable]) -> DenseTable:
    """Return tables of one state each as one of all states, at all thicknesses at which one of them has values.

    Between these every table is linear. Beyond its thickest cloud, a table continues with that. Those of several layers
    differ little from state to state: together they need about as large matrices as one of them alone.
    """
    first = tables[0]
    if len(tables) == 1:
        return first
    clear = np.concatenate([table.clear for table in tables])
    nodes = tuple(_union([table.nodes_m[layer] for table in tables]) for layer in range(len(first.nodes_m)))
    if not first.columns.cores:
        return replace(first, clear=clear, nodes_m=nodes)
    present = [layer for layer, of_layer in enumerate(nodes) if of_layer.size]

    def at_all(table: DenseTable) -> TensorTrain:
        return table.columns.each(
            lambda which, values: _at(nodes[present[which]], table.nodes_m[present[which]], values)
        )

    columns = stacked([at_all(table) for table in tables])
    columns = columns.rounded(ROUNDING) if len(columns.cores) > 1 else columns
    return replace(first, clear=clear, nodes_m=nodes, columns=columns)


def _union(nodes: Sequence[Array]) -> Array:
    """Return all nodes, ascending."""
    first = nodes[0]
    return (
        first
        if all(other is first or np.array_equal(other, first) for other in nodes)
        else np.unique(np.concatenate(nodes))
    )


def _at(nodes: Array, given: Array, values: Array) -> Array:
    """Interpolate values (1 + N, ...), the first without cloud, linearly from thicknesses to others."""
    if nodes is given or np.array_equal(nodes, given):
        return values
    index = np.clip(np.searchsorted(given, nodes, side="right") - 1, 0, given.size - 2)
    share = np.clip((nodes - given[index]) / (given[index + 1] - given[index]), 0.0, 1.0)
    share = share.reshape(-1, *(1,) * (values.ndim - 1))
    cloudy = values[1:]
    return np.concatenate((values[:1], (1.0 - share) * cloudy[index] + share * cloudy[index + 1]))


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

    def at(self, time_s: float, intervals: int) -> tuple[Array, Array]:
        """Return ``loss`` (Q, B) and ``depth`` (L, N, B) at a time within the nodes, as :meth:`RadianceTables.at`.

        Parameters
        ----------
        intervals : int
            N - 1, at least those of the table, by a power of 2.
        """
        index, weight = interval(self.time_s, time_s)
        after = min(index + 1, len(self.time_s) - 1)
        loss: Array = (1 - weight) * self.loss[index] + weight * self.loss[after]
        depth: Array = (1 - weight) * self.depth[index] + weight * self.depth[after]
        while depth.shape[1] <= intervals:
            depth = _halved(depth)
        return loss, depth


def _halved(depth: Array) -> Array:
    """Return a table (L, N, B) with half the intervals; it is linear in the square of their number."""
    first = np.arange(depth.shape[1] - 1)
    share = ((first + 0.5) ** 2 - first**2) / (2.0 * first + 1.0)
    finer = np.empty((depth.shape[0], 2 * first.size + 1, depth.shape[2]))
    finer[:, ::2] = depth
    finer[:, 1::2] = depth[:, :-1] + share[:, None] * (depth[:, 1:] - depth[:, :-1])
    return finer


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
    sunlit : tuple of ndarray of float32 (N, M, C)
        The part of ``change`` that is direct sunlight, which shadows and vapour change; empty without either.
    """

    reach: tuple[float, float]
    change: tuple[NDArray[np.float32], ...]
    level: tuple[Array, ...]
    estimated_error: float
    sunlit: tuple[NDArray[np.float32], ...] = ()

    def at(self, time_s: float, times_s: tuple[float, ...], sizes: tuple[int, int]) -> NDArray[np.float32]:
        """Return the change and, if there is one, its sunlit part, (1 or 2, C, N, M), linear between time nodes.

        Parameters
        ----------
        times_s : tuple of float
            The time nodes.
        sizes : (int, int)
            N and M, at least those of the table.
        """
        index, weight = interval(times_s, time_s)
        both = []
        for nodes in (self.change, self.sunlit) if self.sunlit else (self.change,):
            table = nodes[index]
            if len(nodes) > 1:
                # Not as a difference: small night values would be lost in the rounding of day values.
                table = np.float32(1 - weight) * table + np.float32(weight) * nodes[index + 1]
            both.append(np.moveaxis(_resampled(table, sizes), 2, 0))
        return np.stack(both)


def _resampled(table: NDArray[np.float32], sizes: tuple[int, int]) -> NDArray[np.float32]:
    """Return a table (N, M, C) at more nodes, by the cubics between which frames look it up."""
    for axis, (size, before) in enumerate(zip(sizes, table.shape, strict=False)):
        if size == before:
            continue
        places = np.linspace(0.0, before - 1.0, size)
        first = np.clip(places.astype(np.intp) - 1, 0, before - 4)
        weights = np.zeros((size, before))
        np.put_along_axis(weights, first[:, None] + np.arange(4), lagrange(np.arange(4.0), places - first), axis=1)
        table = np.moveaxis(np.tensordot(weights, table, (1, axis)), 0, axis).astype(np.float32)
    return table


NO_WAVES = WaveTables((0.0, 0.0), (), (), 0.0)


@dataclass(frozen=True)
class TextureTables:
    """Tables of the perturbed states of clear-sky texture.

    Attributes
    ----------
    states : tuple of tuple of InstantTable
        For each perturbed state, at each time node: the warmer sea, if its temperature has texture, then the amounts of
        vapour of the plan.
    square : ndarray (Q, B)
        Part of the difference by a warmer sea that is quadratic in the perturbation, of the clear column.
    mixed : ndarray (2, Q, B)
        Relative change of this difference with the vapour, linear and quadratic.
    sunlight : ndarray (S, B)
        Relative change of the direct sunlight that the sea mirrors to clear sky, in the states of
        :func:`hcss_twin.plan.texture.expansion_states`: shadows take that of the state.
    estimated_error : float
        Relative to the total, at one and at two standard deviations of both.
    """

    states: tuple[tuple[InstantTable, ...], ...]
    square: Array
    mixed: Array
    sunlight: Array
    estimated_error: float


NO_TEXTURE = TextureTables((), np.empty((0, 0)), np.empty((2, 0, 0)), np.empty((0, 0)), 0.0)


@dataclass(frozen=True)
class RadianceTables:
    """Tables of band radiance, W m-2 sr-1, at time nodes.

    Attributes
    ----------
    time_s : tuple of float (T,)
        Time nodes; a single one if the sun does not matter.
    axes : tuple of ThicknessAxis or None
        Axis of each layer, from the lowest to the highest; None for a layer that never has cloud.
    tables : tuple of InstantTable (T,)
        Tables at the nodes.
    spectrum : Spectrum
        Wavenumbers of each column.
    errors : Budget
        Relative errors of the total, measured for each approximation during node placement.
    shadows : ShadowTables or None
        None if no cloud casts shadows.
    waves : WaveTables
        Change of the clear column by resolved waves, at the same time nodes; none for a statistical sea.
    texture : TextureTables
        Perturbed states of the same columns; none without clear-sky texture.
    over : tuple of RadianceTables
        Tables at each node of the first of the axes along which points differ (:mod:`.point_axis`); these tables are
        then one of them, with the largest errors of all.
    over_error : float
        Relative error of the interpolation along that axis, but for views.
    """

    quantities: Quantities
    time_s: tuple[float, ...]
    axes: tuple[ThicknessAxis | None, ...]
    tables: tuple[InstantTable, ...]
    spectrum: Spectrum
    errors: Budget
    shadows: ShadowTables | None = None
    waves: WaveTables = NO_WAVES
    texture: TextureTables = NO_TEXTURE
    over: tuple[RadianceTables, ...] = ()
    over_error: float = 0.0

    @staticmethod
    def key_of(plan: Plan) -> str:
        """Return a hash of everything that the tables of a plan depend on, before they are compiled."""
        return table_key(plan)

    @staticmethod
    def recall_beside(plan: Plan, parts: Any, compute: Callable[[], _T], classes: tuple[type, ...]) -> _T:
        """Return what depends on a plan's tables and ``parts`` alone, from the cache or newly computed.

        Parameters
        ----------
        parts : object
            Anything that JSON can hold, with the name of what is computed.
        classes : tuple of type
            Dataclasses that may occur in the result; its own first.
        """
        key = result_key({"tables": table_key(plan), "parts": parts}, plan.catalog.shelf)
        return recall_or_compute(TABLES, key, plan.catalog, compute, classes)

    @property
    def estimated_error(self) -> float:
        """Largest sum of the relative errors of the total."""
        return self.errors.total + self.over_error + self.texture.estimated_error

    @property
    def leaves(self) -> tuple[RadianceTables, ...]:
        """Tables at all nodes of all axes, those of the last axis one after another."""
        return tuple(leaf for node in self.over for leaf in node.leaves) or (self,)

    @cached_property
    def in_texture_states(self) -> tuple[RadianceTables, ...]:
        """Tables of each perturbed state of the texture."""
        if self.over:
            of_nodes = zip(*(node.in_texture_states for node in self.over), strict=True)
            return tuple(replace(self, over=of_state) for of_state in of_nodes)
        return tuple(replace(self, tables=state) for state in self.texture.states)

    def at(self, time_s: float) -> DenseTable:
        """Return the table at a time within the nodes; those of two nodes are kept, for all scenes that share them."""
        index, weight = interval(self.time_s, time_s)
        if len(self.time_s) == 1:
            return self._dense(index)
        return self._dense(index).blend(self._dense(index + 1), weight)

    def _dense(self, node: int) -> DenseTable:
        kept = self._kept
        if node not in kept:
            while len(kept) > 1:
                del kept[next(iter(kept))]
            kept[node] = self._dense_at(node)
        return kept[node]

    @cached_property
    def _kept(self) -> dict[int, DenseTable]:
        return {}

    def _dense_at(self, node: int) -> DenseTable:
        table, quantities = self.tables[node], self.quantities
        axes = [axis for axis in self.axes if axis is not None]
        columns, clear = table.columns, table.clear.reshape(1, -1)
        if len(axes) == 1:
            terms = np.moveaxis(columns.cores[0][:, 0, 1:, 0], 0, 1)
            dense = axes[0].interpolate(terms.reshape(len(terms), len(quantities.terms), -1))
            of_nodes = quantities.of(dense).reshape(len(dense), -1)
            columns = TensorTrain((np.concatenate((clear, of_nodes)).T[:, None, :, None],))
        elif axes:
            columns = _quantities_of(columns, quantities).each(
                lambda which, values: np.concatenate((values[:1], axes[which].linear(values[1:])))
            )
        nodes_m = tuple(np.empty(0) if axis is None else axis.dense_m for axis in self.axes)
        whole = set(quantities.wanted) == set(quantities.terms)
        return DenseTable(clear, nodes_m, columns, table.clear.shape[1] if whole else 0)


def _quantities_of(terms: TensorTrain, quantities: Quantities) -> TensorTrain:
    """Return the quantities (Q x B) of the terms (K x B) of several layers."""
    bands = terms.cores[0].shape[0] // len(quantities.terms)
    of_terms = [terms.of(slice(first * bands, (first + 1) * bands)) for first in range(len(quantities.terms))]
    whole = total(of_terms, [1.0] * len(of_terms)).rounded(ROUNDING)
    return beside([whole, *(of_terms[quantities.terms.index(name)] for name in quantities.wanted)])


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
