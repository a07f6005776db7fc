"""Radiance of clear-sky texture: tables of perturbed states, compiled once per scene and applied to every frame."""

from __future__ import annotations

from collections.abc import Mapping, MutableMapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.kernels import kernel
from hcss_twin.cube.variables import SEA_TEMPERATURE, WATER_VAPOUR_FACTOR
from hcss_twin.engine.tables.columns import BandColumns, ExactColumns
from hcss_twin.engine.tables.layer_pair import LayerPair
from hcss_twin.engine.tables.look_up import LookUp
from hcss_twin.engine.tables.over_views import ViewedLookUp
from hcss_twin.engine.tables.radiance_tables import InstantTable, RadianceTables, TableReader, TextureTables
from hcss_twin.engine.tables.thickness_axis import ThicknessAxis
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.texture import (
    EXPANSION_STATES,
    VAPOUR_PLACES,
    Expansion,
    State,
    Texture,
    TextureFields,
    sea_factors,
)
from hcss_twin.plan.windows import Window, length, points_of
from hcss_twin.providers import Sun

Thickness = NDArray[np.float32]

TOLERANCE = 0.1
"""Share of the accuracy for columns of a perturbed state that are derived from those of the scene."""

PIXELS_AT_ONCE = 2**14
"""Pixels whose states are in memory together: they fit into the processor's cache."""

PARABOLA_SHARE = 0.25
"""Share of the accuracy up to which two states of vapour are enough."""

_VAPOURS = -1.2, -0.9, -0.6, -0.3, 0.3, 0.6, 0.9, 1.2
_TRIED = tuple(zip((1.2, 0.6, -0.6, 0.6, -0.6, 0.6, -0.6, -1.2), _VAPOURS, strict=True))
"""States up to two standard deviations of both, whose clear radiance tests the interpolation. Haze is a table of
relative humidity: where that of the path passes 70 or 80 %, sunlight that it scatters has a kink of largest error."""


def compile_texture(
    columns: BandColumns,
    axes: tuple[ThicknessAxis | None, ...],
    pair: LayerPair | None,
    exact: Sequence[ExactColumns],
    suns: Sequence[Sun | None],
) -> TextureTables | None:
    """Compute the tables of the perturbed states of a scene; None if it has no texture.

    Parameters
    ----------
    columns : BandColumns
        Of the scene.
    exact : sequence of ExactColumns (T,)
        Those of the scene, at each time node.
    suns : sequence of (Sun or None) (T,)
    """
    plan = columns.plan
    texture: Texture | None = plan.texture
    if texture is None:
        return None

    own: dict[State, BandColumns] = {(0.0, 0.0): columns}
    middle, known, most = len(suns) // 2, dict[State, Array](), len(VAPOUR_PLACES)

    def clear_in(state: State) -> Array:
        state = texture.without_flat(state)
        if state not in own:
            own[state] = columns.of(replace(plan, assembly=texture.perturbed(plan.assembly, state)))
        if state not in known:
            known[state] = columns.quantities.of(own[state].clear(suns[middle]))
        return known[state]

    clear = Expansion(np.stack([clear_in(state) for state in EXPANSION_STATES]))
    tried = {texture.without_flat(state): clear_in(state) for state in (_TRIED if texture.water_vapour else _TRIED[:1])}
    errors = {places: _error(clear, tried, places) for places in (2, most)}
    # At a kink a higher order is no better.
    places = most if errors[2] > PARABOLA_SHARE * plan.accuracy.relative and errors[most] < 0.5 * errors[2] else 2
    tolerance, tables = TOLERANCE * plan.budget.thickness, list[tuple[InstantTable, ...]]()
    if texture.temperature_K > 0.0:
        warm = own[1.0, 0.0]
        if texture.sea_is_proportional(plan.assembly):
            warm = OverWarmerSea(columns, warm.plan, suns[middle])
        first = warm.exact(axes, pair, suns[middle], [exact[middle]], tolerance)
        # What the sea emits does not depend on the sun.
        each = [first if scene is exact[middle] else scene.plus(first, exact[middle]) for scene in exact]
        tables.append(tuple(own[1.0, 0.0].table(axes, *one) for one in zip(each, suns, strict=True)))
    for place in VAPOUR_PLACES[: places if texture.water_vapour else 0]:
        drier, scenes = own[0.0, place], zip(suns, exact, strict=True)
        each = [drier.exact(axes, pair, sun, [scene], tolerance) for sun, scene in scenes]
        tables.append(tuple(drier.table(axes, *one) for one in zip(each, suns, strict=True)))
    mixed = np.stack([_ratio(each, clear.warm) for each in clear.mixed])
    return TextureTables(tuple(tables), _ratio(clear.square, clear.warm), mixed, errors[places] + tolerance)


class OverWarmerSea(BandColumns):
    """Columns over a warmer sea, whose terms differ from those of the scene as in clear sky under some sun."""

    def __init__(self, scene: BandColumns, warmer: Plan, sun: Sun | None) -> None:
        super().__init__(warmer, scene.nodes)
        models = scene.plan.assembly.model, warmer.assembly.model
        self._scene, self._factors = scene, sea_factors(*models, self.nodes.wavenumber_cm1, sun)

    def cloudy(self, thickness_m: Array, sun: Sun | None) -> Array:
        """Terms of cloudy columns (N, K, B); those of the scene are not solved again."""
        terms: Array = (self._scene.spectra(thickness_m, sun) * self._factors) @ self.nodes.weights_cm1.T
        return terms


def _error(clear: Expansion, tried: Mapping[State, Array], places: int) -> float:
    """Largest error of the total of the clear column in the tried states."""
    guess = np.stack([clear.values[0] + clear(np.array(warmer), np.array(drier), places) for warmer, drier in tried])
    exact = np.stack(list(tried.values()))
    away, whole = np.abs(guess - exact)[:, 0], np.abs(exact)[:, 0]
    return float(np.max(np.divide(away, whole, out=np.zeros_like(whole), where=whole > 0.0)))


def _ratio(part: Array, whole: Array) -> Array:
    """Return a ratio; 0 where there is nothing to divide."""
    known = np.abs(whole) > 1e-9 * np.max(np.abs(whole), initial=0.0)
    ratio: Array = np.divide(part, whole, out=np.zeros_like(whole), where=known)
    return ratio


class TextureStage:
    """Adds clear-sky texture to frames.

    Parameters
    ----------
    tables : RadianceTables or None
        None if no radiance is needed.
    """

    def __init__(self, plan: Plan, texture: Texture, tables: RadianceTables | None) -> None:
        self._plan, self._texture = plan, texture
        self._fields = TextureFields(plan.scenario, plan.assembly, texture)
        self._readers: list[list[TableReader]] = []
        if tables is not None and tables.texture is not None:
            toward = tables.over_views or (tables,)
            self._readers = [
                [TableReader(replace(one, tables=one.texture.states[number])) for one in toward if one.texture]
                for number in range(len(tables.texture.states))
            ]
            self._square, self._mixed = tables.texture.square.ravel(), tables.texture.mixed.reshape(2, -1)
        self._instant: tuple[float, list[LookUp | ViewedLookUp]] | None = None

    def fill(
        self,
        radiance: NDArray[np.float32],
        truth: MutableMapping[str, NDArray[Any]],
        extent: Window,
        place: Window,
        thickness_m: Sequence[Thickness],
        time_s: float,
    ) -> None:
        """Apply the texture to a window of a part.

        Parameters
        ----------
        radiance : ndarray of float32 (C, y, x)
            Radiance of a part of the image, every band and term; the window is modified.
        truth : mapping of str to ndarray (y, x)
            Truth variables of the same part.
        extent : (slice, slice)
            The part, in pixels of the image.
        place : (slice, slice)
            The window, in pixels of the part.
        thickness_m : sequence of ndarray
            Thickness of each cloud layer at the points of the window.
        time_s : float
            Time of the frame.
        """
        rows, columns = (
            slice(own.start + part.start, own.stop + part.start) for own, part in zip(place, extent, strict=True)
        )
        warmer, drier = self._fields.at(time_s, rows, columns)
        if SEA_TEMPERATURE in truth:
            kelvin = np.float32(self._texture.steps[0]) * warmer
            truth[SEA_TEMPERATURE][place] = np.float32(self._plan.assembly.sea_temperature_K) + kelvin
        if WATER_VAPOUR_FACTOR in truth:
            truth[WATER_VAPOUR_FACTOR][place] = 1.0 - np.float32(self._texture.steps[1]) * drier
        if not self._readers or not radiance.size:
            return
        look_ups, samples = self._look_ups(time_s), self._plan.samples_per_pixel
        sea = self._texture.temperature_K > 0.0
        places = np.array(VAPOUR_PLACES[: len(look_ups) - sea], np.float32)
        step = max(1, PIXELS_AT_ONCE // warmer.shape[1])
        memory = np.empty((len(look_ups), radiance.shape[0], min(step, warmer.shape[0]), warmer.shape[1]), np.float32)
        for first in range(0, warmer.shape[0], step):
            strip = slice(first, min(first + step, warmer.shape[0]))
            states, points = memory[:, :, : length(strip)], points_of(strip, samples)
            inside = slice(rows.start + strip.start, rows.start + strip.stop), columns
            for look_up, state in zip(look_ups, states, strict=True):
                own = look_up.of_part(inside) if isinstance(look_up, ViewedLookUp) else look_up
                own.fill(state, [layer[points] for layer in thickness_m], samples)
            here = radiance[:, place[0].start + strip.start : place[0].start + strip.stop, place[1]]
            _apply(here, states, sea, warmer[strip], drier[strip], places, self._square, self._mixed)

    def _look_ups(self, time_s: float) -> list[LookUp | ViewedLookUp]:
        if self._instant is None or self._instant[0] != time_s:
            plan, look_ups = self._plan, list[LookUp | ViewedLookUp]()
            for readers in self._readers:
                each = [LookUp(reader.at(time_s)) for reader in readers]
                look_ups.append(each[0] if plan.views is None else ViewedLookUp(plan.views, plan.grid, each))
            self._instant = time_s, look_ups
        return self._instant[1]


@kernel()
def _apply(radiance, states, sea, warmer, drier, places, square, mixed):  # type: ignore[no-untyped-def]
    """Change pixels (C, y, x) along the polynomials through the scene and its states (N, C, y, x).

    The first state is the warmer sea, if it has texture; its parabola has the curvature of clear sky. The others are at
    ``places`` of the vapour.
    """
    one, count, width = np.float32(1), places.size, radiance.shape[2]
    weight, change = np.empty((count, width), np.float32), np.empty(width, np.float32)
    for y in range(radiance.shape[1]):
        t, q = warmer[y], drier[y]
        for n in range(count):
            for x in range(width):
                weight[n, x] = q[x] / places[n]
            for k in range(count):
                if k != n:
                    scale = one / (places[n] - places[k])
                    for x in range(width):
                        weight[n, x] *= (q[x] - places[k]) * scale
        for c in range(radiance.shape[0]):
            here = radiance[c, y]
            change[:] = 0
            if sea:
                s, m, n2, warm = (
                    np.float32(square[c]),
                    np.float32(mixed[0, c]),
                    np.float32(mixed[1, c]),
                    states[0, c, y],
                )
                for x in range(width):
                    change[x] = (warm[x] - here[x]) * (t[x] * (one - s + s * t[x] + q[x] * (m + n2 * q[x])))
            for n in range(count):
                state, own = states[states.shape[0] - count + n, c, y], weight[n]
                for x in range(width):
                    change[x] += own[x] * (state[x] - here[x])
            for x in range(width):
                here[x] = max(here[x] + change[x], np.float32(0))
