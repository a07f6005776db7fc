"""Radiance tables: band radiance against the thickness of the cloud layers (and time, where the sun moves)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.engine.tables.layer_pair import LayerPair
from hcss_twin.engine.tables.spectrum import Spectrum
from hcss_twin.engine.tables.thickness_axis import ThicknessAxis
from hcss_twin.plan.accuracy import Budget

TOTAL = "radiance"


@dataclass(frozen=True)
class Quantities:
    """What is looked up: the total of the radiance and the terms that were asked for.

    Attributes
    ----------
    terms : tuple of str (K,)
        All terms of the radiance model.
    wanted : tuple of str
        Those of them that are looked up beside the total.
    """

    terms: tuple[str, ...]
    wanted: tuple[str, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """``radiance`` and the terms wanted, (Q,)."""
        return TOTAL, *self.wanted

    def of(self, terms: Array) -> Array:
        """Pick from terms (..., K, B), or sum them, (..., Q, B)."""
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

    def blend(self, other: DenseTable, weight: float) -> DenseTable:
        """Interpolate linearly toward ``other``, which has the same nodes."""
        if weight == 0.0:
            return self
        both: NDArray[np.float32] | None = None
        if self.both is not None and other.both is not None:
            # Not self + weight (other - self): night beside day would be lost to the rounding of day.
            both = other.both * np.float32(weight)
            for here, before in zip(both, self.both, strict=True):  # row by row, as these tables are large
                here += np.float32(1 - weight) * before
        return DenseTable(
            (1 - weight) * self.clear + weight * other.clear,
            self.nodes_m,
            tuple((1 - weight) * a + weight * b for a, b in zip(self.alone, other.alone, strict=True)),
            both,
        )


@dataclass(frozen=True)
class ShadowTables:
    """What clear points lose where clouds stand between them and the sun.

    Attributes
    ----------
    time_s : tuple of float (T,)
        Time nodes of the radiance tables.
    longest_m : ndarray (L,)
        Longest path of the sun in each layer.
    loss : ndarray (T, Q, B)
        What direct sunlight on the sea gives each quantity of the clear column.
    depth : ndarray (T, L, N, B)
        Negative logarithm of the direct transmission of the band, at paths even in the square root from 0 to the
        longest.
    """

    time_s: tuple[float, ...]
    longest_m: Array
    loss: Array
    depth: Array

    def at(self, time_s: float) -> tuple[Array, Array]:
        """Return ``loss`` (Q, B) and ``depth`` (L, N, B) at a time within the nodes, as :class:`TableReader` does."""
        index, weight = _interval(self.time_s, time_s)
        after = min(index + 1, len(self.time_s) - 1)
        loss: Array = (1 - weight) * self.loss[index] + weight * self.loss[after]
        depth: Array = (1 - weight) * self.depth[index] + weight * self.depth[after]
        return loss, depth


@dataclass(frozen=True)
class WaveTables:
    """What the slope of waves adds to the clear radiance.

    Attributes
    ----------
    reach : (float, float)
        Greatest slope of the table, upwind and crosswind.
    change : tuple of ndarray of float32 (N, M, C)
        At each time node: W m-2 sr-1 for every band and quantity, at slopes evenly spaced from -reach to reach,
        upwind and then crosswind (clockwise from upwind). Its mean over the waves is 0.
    level : tuple of ndarray (K, B)
        At each time node: factor on each term that brought its mean to the radiance of the mean sea.
    estimated_error : float
        Relative to the total, measured between the nodes while they were placed.
    """

    reach: tuple[float, float]
    change: tuple[NDArray[np.float32], ...]
    level: tuple[Array, ...]
    estimated_error: float


@dataclass(frozen=True)
class RadianceTables:
    """Tables at time nodes.

    Attributes
    ----------
    time_s : tuple of float (T,)
        Time nodes; a single one where the sun does not matter.
    axes : tuple of ThicknessAxis or None
        Of each layer, from the lowest to the highest; None for a layer that never has cloud.
    pair : LayerPair or None
        Axes of both layers together, which then are ``axes``.
    tables : tuple of InstantTable (T,)
        Tables at the nodes.
    spectrum : Spectrum
        Wavenumbers behind each column.
    errors : Budget
        Relative errors of the total: what each approximation found while its nodes were placed.
    shadows : ShadowTables or None
        None where no cloud casts shadows.
    waves : WaveTables or None
        What resolved waves add to the clear column, at the same time nodes; None where they are averaged over.
    over_views : tuple of RadianceTables
        Those toward each view, where pixels have views of their own; these tables then are one of them, with the
        largest errors of any.
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
    over_views: tuple[RadianceTables, ...] = ()

    @property
    def estimated_error(self) -> float:
        """Relative error of the total that all of them can add up to."""
        return self.errors.total


class TableReader:
    """Tables for the look-up at any time within the nodes.

    Dense tables of two layers are large: those of the two time nodes in use are kept, so that frames are best asked
    for in the order of time.
    """

    def __init__(self, tables: RadianceTables) -> None:
        self._tables = tables
        self._dense = lru_cache(maxsize=2)(self._dense_at_node)

    def at(self, time_s: float) -> DenseTable:
        """Table at a time within the nodes."""
        nodes = self._tables.time_s
        index, weight = _interval(nodes, time_s)
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
            alone=tuple(each.reshape(each.shape[0], table.clear.size) for each in table.alone),
            both=both,
        )


def _interval(nodes: tuple[float, ...], time_s: float) -> tuple[int, float]:
    """Interval between nodes in which a time lies, and the weight of its end; the only node and 0 where it is alone."""
    if len(nodes) == 1:
        return 0, 0.0
    index = int(np.clip(np.searchsorted(nodes, time_s, side="right") - 1, 0, len(nodes) - 2))
    return index, (time_s - nodes[index]) / (nodes[index + 1] - nodes[index])
