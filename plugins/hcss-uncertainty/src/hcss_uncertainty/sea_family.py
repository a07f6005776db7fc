"""Scenes that differ in the temperature of the sea: their columns are interpolated between a few temperatures.

Radiance is a smooth function of the temperature of the sea, through its emission and its refractive index. Draws of
many temperatures therefore compute each column at a few of them, which they share, and interpolate it.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, TypeVar, cast

import numpy as np

from hcss_twin import Scenario
from hcss_twin.core.result_cache import ResultCache
from hcss_twin.providers import Array, ColumnSetting, ColumnStates, RadianceModel, SeaModel, planck

LARGEST_ERROR = 1e-7
"""Of an interpolated spectrum, relative to its total: one step of single precision. It is estimated by continuing the
decay of the last two Chebyshev coefficients; columns beyond it are computed at the temperature of their scene."""

NODES_BY_RANGE_K = ((6.0, 4), (12.0, 5), (24.0, 6))
"""Number of temperatures for ranges up to a width."""

SCENES_PER_NODE = 2
"""For fewer scenes, their own temperatures cost less."""

LIMIT_BYTES = 100_000_000
"""Of the columns of a family, usually some 20 MB; beyond it all are forgotten."""

Kept = TypeVar("Kept")


@dataclass(frozen=True)
class SeaTemperatures:
    """What tells a family of scenes in any process.

    Attributes
    ----------
    nodes_K : tuple of float (n,)
        Temperatures between which columns are interpolated: Chebyshev nodes of the range.
    group : str
        Equal for scenes that differ only in the temperature of the sea and in what radiance does not depend on.
    """

    nodes_K: tuple[float, ...]
    group: str

    def family(self, cache: ResultCache) -> SeaFamily:
        """Return the family of this process."""
        return cache.get_or_compute(("sea family", self), lambda: SeaFamily(self))


def sea_temperatures(scenarios: Sequence[Scenario]) -> list[SeaTemperatures | None]:
    """Return the family of each scenario; None if interpolation would not pay. Their order does not matter."""
    groups: dict[str, list[int]] = {}
    for number, scenario in enumerate(scenarios):
        plain = json.loads(scenario.to_json())
        if plain["sea"].pop("temperature") is not None and plain.get("surfaces") is None:
            text = json.dumps({name: keys for name, keys in plain.items() if name not in ("title", "output", "seed")})
            groups.setdefault(hashlib.sha256(text.encode()).hexdigest(), []).append(number)
    found: list[SeaTemperatures | None] = [None] * len(scenarios)
    for group, members in groups.items():
        kelvin = np.unique([cast(float, scenarios[number].sea.temperature) for number in members])
        low, high = float(kelvin[0]), float(kelvin[-1])
        count = next((number for width, number in NODES_BY_RANGE_K if high - low <= width), None)
        if count is not None and high > low and kelvin.size >= SCENES_PER_NODE * count:
            nodes = 0.5 * (low + high) + 0.5 * (high - low) * np.polynomial.chebyshev.chebpts1(count)
            for number in members:
                found[number] = SeaTemperatures(tuple(nodes.tolist()), group)
    return found


@dataclass
class SeaFamily:
    """Columns of a family at its temperatures, and its seas."""

    temperatures: SeaTemperatures
    seas: dict[float, SeaModel] = field(default_factory=dict)
    columns: dict[Hashable, Array] = field(default_factory=dict)
    kept: dict[Hashable, Any] = field(default_factory=dict)

    @property
    def key(self) -> str:
        """The temperatures."""
        return repr(self.temperatures.nodes_K)

    def at_nodes(self, setting: ColumnSetting, sea_of: Callable[[float], SeaModel]) -> list[ColumnSetting]:
        """Return a setting over the sea at each temperature."""
        for kelvin in self.temperatures.nodes_K:
            if kelvin not in self.seas:
                self.seas[kelvin] = sea_of(kelvin)
        return [
            replace(setting, sea=self.seas[kelvin], sea_temperature_K=kelvin) for kelvin in self.temperatures.nodes_K
        ]

    def spanning(self, setting: ColumnSetting, sea_of: Callable[[float], SeaModel]) -> list[ColumnSetting]:
        """Return the settings at the lowest and the highest temperature."""
        every = self.at_nodes(setting, sea_of)
        return [every[0], every[-1]]

    def keep(self, name: Hashable, compute: Callable[[], Kept]) -> Kept:
        """Return what all scenes have in common, computed once."""
        if name not in self.kept:
            self.kept[name] = compute()
        return cast(Kept, self.kept[name])

    def sharing(
        self, model: RadianceModel, level: tuple[int, int], setting: ColumnSetting, sea_of: Callable[[float], SeaModel]
    ) -> RadianceModel:
        """Return the interpolating model of a scene; models of one level only are cheap as they are."""
        if model.declares.numerical_levels == 1:
            return model
        return SharedColumns(model, self, level, setting, sea_of)


class SharedColumns:
    """A radiance model whose columns over the sea of its scene are interpolated over the temperature."""

    def __init__(
        self,
        exact: RadianceModel,
        family: SeaFamily,
        level: tuple[int, int],
        own: ColumnSetting,
        sea_of: Callable[[float], SeaModel],
    ) -> None:
        self.declares, self.terms, self.solar_terms = exact.declares, exact.terms, exact.solar_terms
        self.sea_sun_terms: frozenset[str] = getattr(exact, "sea_sun_terms", frozenset())
        self._exact, self._family, self._level, self._own, self._sea_of = exact, family, level, own, sea_of

    def columns(self, states: ColumnStates, wavenumber_cm1: Array) -> Mapping[str, Array]:
        """Return each term (N, V); over other seas, in other air or beyond the error they are computed exactly."""
        shared = np.array([self._is_shared(setting) for setting in states.settings])[states.setting_of]
        if wavenumber_cm1.size == 1 or not np.any(shared):  # one wavenumber is a test of the scene's own providers
            return self._exact.columns(states, wavenumber_cm1)
        rows = np.flatnonzero(shared)
        values, error = self._interpolated(self._at_nodes(_some(states, rows), wavenumber_cm1), wavenumber_cm1)
        good = np.all(error <= LARGEST_ERROR * np.sum(values, axis=1), axis=1)
        result = states.empty(self.terms, wavenumber_cm1)
        others = np.setdiff1d(np.arange(len(states)), rows[good])
        alone = self._exact.columns(_some(states, others), wavenumber_cm1) if others.size else {}
        for index, name in enumerate(self.terms):
            result[name][rows[good]] = values[good, index]
            if others.size:
                result[name][others] = alone[name]
        return result

    def _is_shared(self, setting: ColumnSetting) -> bool:
        own = self._own
        return (
            (setting.sea is own.sea and setting.sea_temperature_K == own.sea_temperature_K)
            and setting.profile is own.profile
            and setting.transmittance is own.transmittance
        )

    def _at_nodes(self, states: ColumnStates, wavenumber_cm1: Array) -> Array:
        """Return terms (n, N, K, V) at all temperatures; what no scene has asked for is computed in one call."""
        known, numbers = self._family.columns, wavenumber_cm1.tobytes()
        keys = [
            (self._level, numbers, setting.view, setting.sun, setting.layers, tuple(thickness))
            for setting, thickness in zip(
                (states.settings[number] for number in states.setting_of), states.thickness_m.tolist(), strict=True
            )
        ]
        if sum(values.nbytes for values in known.values()) > LIMIT_BYTES:
            known.clear()
        new = list({key: row for row, key in enumerate(keys) if key not in known}.values())
        if new:
            some, count = _some(states, np.array(new)), len(self._family.temperatures.nodes_K)
            settings = [node for one in some.settings for node in self._family.at_nodes(one, self._sea_of)]
            setting_of = (count * some.setting_of[None] + np.arange(count)[:, None]).ravel()
            every = ColumnStates(tuple(settings), setting_of, np.tile(some.thickness_m, (count, 1)))
            terms = self._exact.columns(every, wavenumber_cm1)
            solved = np.stack([np.asarray(terms[name]) for name in self.terms], axis=1)
            solved = solved.reshape(count, len(new), len(self.terms), -1)
            known.update((keys[row], solved[:, number]) for number, row in enumerate(new))
        return np.stack([known[key] for key in keys], axis=1)

    def _interpolated(self, at_nodes: Array, wavenumber_cm1: Array) -> tuple[Array, Array]:
        """Return interpolated terms (N, K, V), and the error (N, V) of their sum.

        A term is interpolated as it is or relative to the Planck radiance of the sea, whichever is smoother.
        """
        nodes, kelvin = np.array(self._family.temperatures.nodes_K), self._own.sea_temperature_K
        count, middle, half = nodes.size, 0.5 * (nodes[0] + nodes[-1]), 0.5 * (nodes[-1] - nodes[0])
        half /= np.polynomial.chebyshev.chebpts1(count)[-1]
        # Rows of the inverse: coefficients of Chebyshev polynomials from values at their nodes.
        inverse = np.linalg.inv(np.polynomial.chebyshev.chebvander((nodes - middle) / half, count - 1))
        weights = np.polynomial.chebyshev.chebvander((kelvin - middle) / half, count - 1)[0] @ inverse
        emitted = np.stack([planck(wavenumber_cm1, temperature) for temperature in (kelvin, *nodes.tolist())])
        scaled = at_nodes * (emitted[:1] / emitted[1:])[:, None, None, :]
        plain, relative = (np.tensordot(weights, values, 1) for values in (at_nodes, scaled))
        error, error_relative = (
            _left_out(*np.abs(np.tensordot(inverse[-2:], values, 1))) for values in (at_nodes, scaled)
        )
        values: Array = np.where(error <= error_relative, plain, relative)
        return values, np.sum(np.minimum(error, error_relative), axis=1)


def _some(states: ColumnStates, rows: Any) -> ColumnStates:
    """Return some of the columns, with the settings that they have."""
    numbers, setting_of = np.unique(states.setting_of[rows], return_inverse=True)
    settings = tuple(states.settings[number] for number in numbers.tolist())
    return ColumnStates(settings, setting_of.astype(np.intp), states.thickness_m[rows])


def _left_out(before: Array, last: Array) -> Array:
    """Return the next coefficient of a series if its coefficients decay by the same factor as the last two."""
    factor = np.divide(last, before, out=np.ones_like(last), where=before > last)
    result: Array = last * factor
    return result
