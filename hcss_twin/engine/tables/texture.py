"""Radiance of clear-sky texture: tables of perturbed states, compiled once per scene and applied to every frame."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.error_norm import largest_error
from hcss_twin.engine.tables.columns import Axes, BandColumns
from hcss_twin.engine.tables.radiance_tables import InstantTable, TextureTables
from hcss_twin.engine.tables.tensor_train import TensorTrain, total
from hcss_twin.plan.clear_sky import State
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.slant_paths import sea_sun_terms
from hcss_twin.plan.texture import Expansion, expansion_states, sea_factors
from hcss_twin.providers import ColumnSetting, Sun

Thickness = NDArray[np.float32]

TOLERANCE = 0.1
"""Share of the accuracy for columns of a perturbed state that are derived from those of the scene."""

_TRIED = (1.2, -1.2), (-0.6, -0.6), (0.6, 0.6), (-1.2, 1.2)
"""States up to two standard deviations of both, whose clear radiance tests the interpolation."""


def compile_texture(
    columns: BandColumns, axes: Axes, exact: Sequence[TensorTrain], settings: Sequence[ColumnSetting]
) -> TextureTables:
    """Compute the tables of the perturbed states of a scene with texture.

    Parameters
    ----------
    columns : BandColumns
        Of the scene.
    exact : sequence of TensorTrain (T,)
        Those of the scene, at each time node.
    settings : sequence of ColumnSetting (T,)
    """
    plan, texture = columns.plan, columns.plan.texture
    columns_in: dict[State, BandColumns] = {(0.0, 0.0): columns}
    middle, known = len(settings) // 2, dict[State, Array]()

    def in_state(state: State, setting: ColumnSetting) -> ColumnSetting:
        return columns_in[state].plan.assembly.like(setting)

    def clear_in(state: State) -> Array:
        state = texture.without_flat(state)
        if state not in columns_in:
            columns_in[state] = columns.of(replace(plan, assembly=texture.perturbed(plan.assembly, state)))
        if state not in known:
            known[state] = columns_in[state].clear([in_state(state, settings[middle])])[0]
        return known[state]

    nodes = texture.vapour
    terms, quantities = np.stack([clear_in(state) for state in expansion_states(nodes)]), columns.quantities
    clear = Expansion(quantities.of(terms), nodes)
    mirrored = [quantities.terms.index(name) for name in sea_sun_terms(plan.assembly.model)]
    sunlight = np.sum(terms[:, mirrored], axis=1)
    tried = {
        texture.without_flat(state): quantities.of(clear_in(state))
        for state in (_TRIED if texture.water_vapour else _TRIED[:1])
    }
    error = _error(clear, tried)
    tolerance, tables = TOLERANCE * plan.budget.thickness, list[tuple[InstantTable, ...]]()
    if texture.temperature_K > 0.0:
        warm = columns_in[1.0, 0.0]
        if texture.sea_is_proportional(plan.assembly):
            warm = OverWarmerSea(columns, warm.plan, settings[middle].sun)
        over_warm = [in_state((1.0, 0.0), setting) for setting in settings]
        # The ratio hardly depends on the view: that toward the first one is a guess toward others.
        ratio = columns.known.warmer
        guess = exact[middle] if ratio is None else exact[middle].times(ratio)
        (first,) = warm.exact(axes, [over_warm[middle]], tolerance, [[guess]])
        if len(first.cores) == 1 and ratio is None:
            columns.known.warmer = first.over(exact[middle], 1.0)
        # What the sea emits does not depend on the sun.
        perturbed = [
            first if scene is exact[middle] else total([scene, first, exact[middle]], [1.0, 1.0, -1.0])
            for scene in exact
        ]
        tables.append(columns_in[1.0, 0.0].tables(perturbed, over_warm))
    for vapour_place in nodes.places if texture.water_vapour else ():
        drier = columns_in[0.0, vapour_place]
        in_drier = [in_state((0.0, vapour_place), setting) for setting in settings]
        tables.append(drier.tables(drier.exact(axes, in_drier, tolerance, [exact]), in_drier))
    mixed = np.stack([_ratio(mixed_terms, clear.warm) for mixed_terms in clear.mixed])
    of_sun = _ratio(sunlight - sunlight[:1], np.repeat(sunlight[:1], len(sunlight), axis=0))
    return TextureTables(tuple(tables), _ratio(clear.square, clear.warm), mixed, of_sun, error + tolerance)


class OverWarmerSea(BandColumns):
    """Columns over a warmer sea, whose terms differ from those of the scene as in clear sky under some sun."""

    proportional = True

    def __init__(self, scene: BandColumns, warmer: Plan, sun: Sun | None) -> None:
        super().__init__(warmer, scene.nodes)
        scenes = scene.plan.assembly, warmer.assembly
        self._scene, self._factors = scene, sea_factors(*scenes, self.nodes.wavenumber_cm1, sun)

    def cloudy(self, thickness_m: Array, settings: Sequence[ColumnSetting]) -> Array:
        """Terms of cloudy columns (S, N, K, B); those of the scene are not solved again."""
        of_scene = [self._scene.plan.assembly.like(setting) for setting in settings]
        terms: Array = (self._scene.spectra(thickness_m, of_scene) * self._factors) @ self.nodes.weights_cm1.T
        return terms


def _error(clear: Expansion, tried: Mapping[State, Array]) -> float:
    """Largest error of the total of the clear column in the tried states."""
    guess = np.stack([clear.values[0] + clear(np.array(warmer), np.array(drier)) for warmer, drier in tried])
    return largest_error(guess[:, 0], np.stack(list(tried.values()))[:, 0])


def _ratio(part: Array, whole: Array) -> Array:
    """Return a ratio; 0 where there is nothing to divide."""
    known = np.abs(whole) > 1e-9 * np.max(np.abs(whole), initial=0.0)
    ratio: Array = np.divide(part, whole, out=np.zeros_like(whole), where=known)
    return ratio
