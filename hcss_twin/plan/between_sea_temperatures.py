"""Columns of scenes that differ in the temperature of the sea only, interpolated between a few temperatures.

Radiance is a smooth function of the temperature of the sea, through its emission and its refractive index. A sweep over
many temperatures therefore computes each column at a few of them, which its points share, and interpolates it.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, cast

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.catalog import Catalog
from hcss_twin.physics.planck import planck
from hcss_twin.providers import RadianceModel, SeaModel, Sun, View

LARGEST_ERROR = 1e-7
"""Of an interpolated spectrum, relative to its total: one step of single precision. It is estimated by continuing the
decay of the last two Chebyshev coefficients; columns beyond it are computed at the temperature of their scene."""

NODES_BY_RANGE_K = ((6.0, 4), (12.0, 5), (24.0, 6))
"""Number of temperatures for ranges up to a width."""

SCENES_PER_NODE = 2
"""For fewer scenes, their own temperatures cost less."""

GROUPS = 2
"""Groups of scenes whose columns stay in memory; the scenes of a group follow one another."""

FORESEEN = 41
"""Temperatures at which the wavenumbers of other scenes are foreseen. A choice costs little, and a column at one
wavenumber hardly less than at fifty."""

ALL_COLUMNS = 10**9

LIMIT_BYTES = 100_000_000
"""Of the columns of a group, usually some 20 MB; beyond it all are forgotten."""


@dataclass(frozen=True)
class SeaTemperatures:
    """The temperatures between which the columns of a group of scenes are interpolated.

    Attributes
    ----------
    nodes_K : tuple of float
    group : str
        Equal for scenes that differ only in the temperature of the sea and in what radiance does not depend on.
    afresh : int
        Number of columns at each time that the certificate of this scene solves at the temperature of the scene.
    """

    nodes_K: tuple[float, ...]
    group: str
    afresh: int = 0

    @property
    def text(self) -> str:
        """What a certificate says about it."""
        nodes = ", ".join(f"{kelvin:.2f}" for kelvin in self.nodes_K)
        alone = self.afresh == ALL_COLUMNS
        of = "columns of the tables are" if alone else "columns of the tables and the reference are"
        return (
            f"{of} interpolated between sea temperatures of {nodes} K, which scenes of the sweep share, with an "
            f"estimated error below {LARGEST_ERROR:g}"
        )


def temperatures_between(kelvin: Sequence[float], group: str) -> SeaTemperatures | None:
    """Return the Chebyshev nodes of a group of scenes; None if interpolation would not pay."""
    low, high = min(kelvin), max(kelvin)
    count = next((number for width, number in NODES_BY_RANGE_K if high - low <= width), None)
    if count is None or high == low or len(kelvin) < SCENES_PER_NODE * count:
        return None
    nodes = 0.5 * (low + high) + 0.5 * (high - low) * np.polynomial.chebyshev.chebpts1(count)
    return SeaTemperatures(tuple(nodes.tolist()), group)


class GroupColumns:
    """Columns of a group at its temperatures, with the seas and the files that were read for them."""

    def __init__(self) -> None:
        self.seas: dict[float, SeaModel] = {}
        self.files: dict[str, str] = {}
        self.foreseen: dict[Hashable, Array] = {}
        self._known: dict[tuple[object, ...], tuple[Array, Array]] = {}

    def at(
        self, key: tuple[object, ...], wavenumber_cm1: Array, thickness_m: Array, solve: Callable[[Array, Array], Array]
    ) -> Array:
        """Return terms (n, N, K, V) at n temperatures of columns (N, L); ``solve`` computes missing ones."""
        keys = [(*key, *row) for row in thickness_m.tolist()]
        missing = [
            np.setdiff1d(wavenumber_cm1, self._known[column_key][0]) if column_key in self._known else wavenumber_cm1
            for column_key in keys
        ]
        rows = [row for row, name in enumerate(missing) if name.size]
        if rows:
            if sum(values.nbytes for _, values in self._known.values()) > LIMIT_BYTES:
                self._known.clear()
                return self.at(key, wavenumber_cm1, thickness_m, solve)
            ahead = [foreseen for foreseen in self.foreseen.values() if np.isin(wavenumber_cm1, foreseen).all()]
            new = np.unique(np.concatenate([missing[row] for row in rows] + ahead))
            known = [self._known[keys[row]][0] if keys[row] in self._known else np.empty(0) for row in rows]
            new = new[~np.all([np.isin(new, known_cm1) for known_cm1 in known], axis=0)]
            solved = solve(new, thickness_m[rows])
            for index, row in enumerate(rows):
                self._add(keys[row], new, solved[:, index])
        return np.stack([self._of(column_key, wavenumber_cm1) for column_key in keys], axis=1)

    def _add(self, key: tuple[object, ...], wavenumber_cm1: Array, values: Array) -> None:
        known, old = self._known.get(key, (np.empty(0), values[..., :0]))
        every, first = np.unique(np.concatenate((known, wavenumber_cm1)), return_index=True)
        self._known[key] = every, np.concatenate((old, values), axis=-1)[..., first]

    def _of(self, key: tuple[object, ...], wavenumber_cm1: Array) -> Array:
        known, values = self._known[key]
        return values[..., np.searchsorted(known, wavenumber_cm1)]


class BetweenSeaTemperatures:
    """A radiance model whose columns are interpolated over the temperature of the sea.

    Parameters
    ----------
    exact : RadianceModel
        The model at the temperature of the scene.
    model_at : callable
        Builds the same model at another temperature.
    nodes_K : tuple of float (n,)
    temperature_K : float
        Of the scene, between the nodes or little beyond.
    columns : GroupColumns
    key : tuple
        What models of the group differ in: view, numerical level.
    catalog : Catalog
        Where the files read for known columns are recorded.
    """

    def __init__(
        self,
        exact: RadianceModel,
        model_at: Callable[[float], RadianceModel],
        nodes_K: tuple[float, ...],
        temperature_K: float,
        columns: GroupColumns,
        key: tuple[object, ...],
        catalog: Catalog,
    ) -> None:
        self.exact, self.declares = exact, exact.declares
        self.terms, self.solar_terms = exact.terms, exact.solar_terms
        self.sea_sun_terms: frozenset[str] = getattr(exact, "sea_sun_terms", frozenset())
        self._model_at, self._nodes_K, self._kelvin = model_at, nodes_K, temperature_K
        self._columns, self._key, self._catalog = columns, key, catalog
        self._suns: tuple[Sun | None, ...] = ()
        self._recorded = 0

    def expect(self, suns: Iterable[Sun | None]) -> None:
        """As :meth:`RadianceModelOptions.expect`."""
        self._suns = tuple(suns)
        self._prepared(self.exact)

    def clear(self, wavenumber_cm1: Array, sun: Sun | None) -> Mapping[str, Array]:
        """As :meth:`RadianceModel.clear`."""

        def solve(wavenumber: Array, _: Array) -> Array:
            def of(model: RadianceModel) -> list[Array]:
                terms = model.clear(wavenumber, sun)
                return [terms[name][None] for name in self.terms]

            return self._solved(of)

        values = self._between(wavenumber_cm1, np.zeros((1, 1)), sun, solve)
        if values is None:
            return self.exact.clear(wavenumber_cm1, sun)
        return dict(zip(self.terms, values[0], strict=True))

    def cloudy(self, wavenumber_cm1: Array, thickness_m: Array, sun: Sun | None) -> Mapping[str, Array]:
        """As :meth:`RadianceModel.cloudy`."""

        def solve(wavenumber: Array, thickness: Array) -> Array:
            def of(model: RadianceModel) -> list[Array]:
                terms = model.cloudy(wavenumber, thickness, sun)
                return [terms[name] for name in self.terms]

            return self._solved(of)

        values = self._between(wavenumber_cm1, thickness_m, sun, solve)
        if values is None:
            return self.exact.cloudy(wavenumber_cm1, thickness_m, sun)
        return dict(zip(self.terms, np.moveaxis(values, 1, 0), strict=True))

    def foresee(self, name: Hashable, chosen_by: Callable[[RadianceModel], Array]) -> None:
        """Let columns be solved at once at all wavenumbers that scenes of the group will probably choose.

        ``chosen_by`` returns those of a scene with another model of the group; each named choice is foreseen once.
        """
        if name in self._columns.foreseen:
            return
        low, high, chosen = self._nodes_K[0], self._nodes_K[-1], []
        beyond = 0.04 * (high - low)  # Chebyshev nodes do not reach the ends of the range
        for kelvin in np.linspace(low - beyond, high + beyond, FORESEEN).tolist():
            other = copy(self)
            other._kelvin = kelvin
            chosen.append(chosen_by(other))
        self._columns.foreseen[name] = np.unique(np.concatenate(chosen))

    def _prepared(self, model: RadianceModel) -> RadianceModel:
        prepare = getattr(model, "expect", None)
        if prepare is not None:
            prepare(self._suns)
        return model

    def _solved(self, of: Callable[[RadianceModel], list[Array]]) -> Array:
        """Return terms (n, N, K, V) at all nodes."""
        every = []
        for kelvin in self._nodes_K:
            every.append(np.stack(of(self._prepared(self._model_at(kelvin))), axis=1))
        self._columns.files.update(self._catalog.used)
        return np.stack(every)

    def _between(
        self, wavenumber_cm1: Array, thickness_m: Array, sun: Sun | None, solve: Callable[[Array, Array], Array]
    ) -> Array | None:
        """Return interpolated terms (N, K, V); None if they are not smooth enough.

        A term is interpolated as it is or relative to the Planck radiance of the sea, whichever is smoother.
        """
        if wavenumber_cm1.size == 1:  # a test of the scene's own providers
            return None
        if self._recorded != len(self._columns.files):
            if not self._catalog.unchanged(self._columns.files):
                return None
            self._recorded = len(self._columns.files)
        at_nodes = self._columns.at((*self._key, sun), wavenumber_cm1, thickness_m, solve)
        nodes = np.array(self._nodes_K)
        count, middle, half = nodes.size, 0.5 * (nodes[0] + nodes[-1]), 0.5 * (nodes[-1] - nodes[0])
        half /= np.polynomial.chebyshev.chebpts1(count)[-1]
        # Rows of the inverse: coefficients of Chebyshev polynomials from values at their nodes.
        inverse = np.linalg.inv(np.polynomial.chebyshev.chebvander((nodes - middle) / half, count - 1))
        weights = np.polynomial.chebyshev.chebvander((self._kelvin - middle) / half, count - 1)[0] @ inverse
        emitted = np.stack([planck(wavenumber_cm1, kelvin) for kelvin in (self._kelvin, *self._nodes_K)])
        share = emitted[:1] / emitted[1:]
        scaled = at_nodes * share[:, None, None, :]
        plain, relative = (np.tensordot(weights, terms, 1) for terms in (at_nodes, scaled))
        error, error_relative = (
            _left_out(*np.abs(np.tensordot(inverse[-2:], terms, 1))) for terms in (at_nodes, scaled)
        )
        values: Array = np.where(error <= error_relative, plain, relative)
        error = np.sum(np.minimum(error, error_relative), axis=1)
        return values if np.all(error <= LARGEST_ERROR * np.sum(values, axis=1)) else None


def _left_out(before: Array, last: Array) -> Array:
    """Return the next coefficient of a series if its coefficients decay by the same factor as the last two."""
    factor = np.divide(last, before, out=np.ones_like(last), where=before > last)
    result: Array = last * factor
    return result


def interpolating(
    exact_of: Callable[..., RadianceModel],
    sea_of: Callable[[float], SeaModel],
    own_sea: SeaModel,
    temperature_K: float,
    between: SeaTemperatures,
    catalog: Catalog,
) -> Callable[..., RadianceModel]:
    """Return a builder of interpolated models of the scenario's own sea; those of other surfaces are as they are.

    Parameters
    ----------
    exact_of : callable
        ``Assembly.model_of`` without interpolation.
    sea_of : callable
        Builds the sea for another temperature.
    """
    groups: OrderedDict[SeaTemperatures, GroupColumns] = catalog.shelf.get_or_compute("sea columns", OrderedDict)
    columns = groups.setdefault(replace(between, afresh=0), GroupColumns())
    while len(groups) > GROUPS:
        groups.popitem(last=False)

    @lru_cache
    def model_of(sea: SeaModel, view: View, kelvin: float, level: int, *air: Any, **named: Any) -> RadianceModel:
        exact = exact_of(sea, view, kelvin, level, *air, **named)
        if sea is not own_sea or kelvin != temperature_K or any(air):
            return exact

        def model_at(node_K: float) -> RadianceModel:
            if node_K not in columns.seas:
                columns.seas[node_K] = sea_of(node_K)
            return exact_of(columns.seas[node_K], view, node_K, level, **named)

        model: RadianceModel = BetweenSeaTemperatures(
            exact, model_at, between.nodes_K, kelvin, columns, (view, level, *named.values()), catalog
        )
        return model

    return cast(Callable[..., RadianceModel], model_of)
