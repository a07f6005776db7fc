"""Absorber amounts of composite paths: layers times slant factors, summed over the legs."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from functools import lru_cache

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.models.atmosphere.band_model.absorber_density import LevelState
from hcss_twin.models.atmosphere.band_model.layers import (
    Layers,
    cell_limits_m,
    make_layers,
    slant_factors,
    stack_layers,
)
from hcss_twin.physics.paths import SPACE, Leg, LegSums, Path

_KEPT_PARTS = 1024
"""Parts of the profile that are kept: legs of many paths are alike."""

_SAME_ALTITUDE_M = 1e-3
"""Altitudes are compared through distances from the Earth's centre, which round to about 1e-9 m."""

_NOTHING_M = 1e-6
"""Pieces of a layer as thin as this are left out: rounding is a thousandth of them."""


class LayeredAir:
    """The layers of a profile, and of any part of it.

    Parameters
    ----------
    state : LevelState
        Densities at the levels.
    earth_radius_m : float
    """

    def __init__(self, state: LevelState, earth_radius_m: float) -> None:
        self._state = state
        self.earth_radius_m = earth_radius_m
        self._limit_m = cell_limits_m(state.altitude_m)
        self._layers = make_layers(state, earth_radius_m, self._limit_m)
        self.columns = state.density.shape[1]
        self._kept = lru_cache(maxsize=_KEPT_PARTS)(self._between)
        self.amounts_upwards = lru_cache(maxsize=_KEPT_PARTS)(self._amounts_upwards)
        self._level_m = state.altitude_m
        self._level_set = frozenset(state.altitude_m.tolist())
        self._sums = LegSums(self.columns, self._compute)

    def between(self, lower_m: float, upper_m: float) -> Layers:
        """Layers from one altitude to another; of one that an end lies in, the part between."""
        return self._kept(lower_m, upper_m)

    def _between(self, lower_m: float, upper_m: float) -> Layers:
        levels = self._state.altitude_m
        upper_m = min(upper_m, float(levels[-1]))
        lower_m = min(lower_m, upper_m)
        first = int(np.searchsorted(levels, lower_m))  # lowest level not below the beginning
        last = int(np.searchsorted(levels, upper_m, side="right")) - 1
        if first > last:  # both ends inside one layer
            return self._partial(lower_m, upper_m)
        parts = [self._layers.slice(first, last)]
        if lower_m < levels[first]:
            parts.insert(0, self._partial(lower_m, float(levels[first])))
        if upper_m > levels[last]:
            parts.append(self._partial(float(levels[last]), upper_m))
        return stack_layers(parts)

    def slant(self, layers: Layers, lower_m: float, zenith_deg: Array) -> Array:
        """Slant factors (P, M) of rays that begin at ``lower_m``.

        At their beginning sin(zenith) = sin(zenith at the surface) R / (R + h), a straight ray; from there on they are
        refracted.
        """
        return slant_factors(layers, self._index(lower_m) * self.earth_radius_m * np.sin(np.radians(zenith_deg)))

    def boundaries_m(self, layers: Layers) -> Array:
        """Altitudes (L + 1,) of the bottom of each layer and of the last one's top."""
        bottoms = layers.radius_m[layers.first_cell, 0]
        result: Array = np.append(bottoms, layers.radius_m[-1, 2]) - self.earth_radius_m
        return result

    def _amounts_upwards(self, altitude_m: float, sine: float) -> Array:
        """Absorber amounts (K,) from an altitude to space, given the sine of the zenith angle there."""
        layers = self.between(altitude_m, SPACE)
        invariant = self._index(altitude_m) * (self.earth_radius_m + altitude_m) * sine
        result: Array = slant_factors(layers, np.array([invariant]))[0] @ layers.amount
        return result

    def amounts(self, paths: Sequence[Path]) -> Array:
        """Absorber amounts of composite paths, (P, K)."""
        return self._sums.of(paths)

    def _compute(self, legs: Iterable[Leg], known: dict[Leg, Array]) -> None:
        """Add the absorber amounts (K,) of single legs to those known.

        Rays from one altitude to levels of the profile are followed once, to space: the levels are on their way.
        """
        groups: dict[tuple[float, float | None], list[Leg]] = {}
        for leg in legs:
            to_level = leg.upper_m >= self._level_m[-1] or leg.upper_m in self._level_set
            groups.setdefault((leg.lower_m, None if to_level else leg.upper_m), []).append(leg)
        for (lower, between_levels), members in groups.items():
            layers = self.between(lower, SPACE if between_levels is None else between_levels)
            zenith = sorted({leg.zenith_deg for leg in members})
            by_cell = self.slant(layers, lower, np.array(zenith))[:, :, None] * layers.amount
            upward = np.cumsum(by_cell, axis=1)
            tops = layers.radius_m[:, 2] - self.earth_radius_m
            cells = [tops.size] * len(members)
            if between_levels is None:
                ends = np.array([leg.upper_m for leg in members]) - _SAME_ALTITUDE_M
                cells = np.minimum(np.searchsorted(tops, ends) + 1, tops.size).tolist()
            row = {zenith_deg: number for number, zenith_deg in enumerate(zenith)}
            for leg, cell in zip(members, cells, strict=True):
                nothing = cell == 0 or leg.upper_m <= lower
                known[leg] = np.zeros(self.columns) if nothing else upward[row[leg.zenith_deg], cell - 1].copy()

    def _index(self, altitude_m: float) -> float:
        refractivity = np.interp(altitude_m, self._state.altitude_m, np.log(self._state.refractivity))
        return 1.0 + math.exp(float(refractivity))

    def _partial(self, lower_m: float, upper_m: float) -> Layers:
        if upper_m - lower_m <= _NOTHING_M:
            return self._layers.slice(0, 0)
        limit = self._limit_m
        # Pieces of a cell likewise.
        inner = limit[(limit > lower_m + _NOTHING_M) & (limit < upper_m - _NOTHING_M)]
        return make_layers(self._state, self.earth_radius_m, np.array([lower_m, *inner, upper_m]))
