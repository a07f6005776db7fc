"""Absorber amounts of composite paths: layers times slant factors, summed over the legs."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hcss_twin.atmosphere.band_model.absorber_density import LevelState
from hcss_twin.atmosphere.band_model.layers import Layers, join_states, make_layers, stack_layers, state_at
from hcss_twin.atmosphere.band_model.refraction import slant_factors
from hcss_twin.physics.paths import SPACE, Path

Array = NDArray[np.float64]


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
        self._layers = make_layers(state, earth_radius_m)
        self.columns = state.density.shape[1]

    def between(self, lower_m: float, upper_m: float) -> Layers:
        """Layers from one altitude to another; a target inside a layer becomes a level of its own."""
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
        return slant_factors(
            layers, self._index(lower_m) * self.earth_radius_m * np.sin(np.radians(zenith_deg))
        )

    def boundaries_m(self, layers: Layers) -> Array:
        """Altitudes (L + 1,) of the bottom of each layer and of the last one's top."""
        bottoms = layers.radius_m[layers.first_cell, 0]
        result: Array = np.append(bottoms, layers.radius_m[-1, 2]) - self.earth_radius_m
        return result

    def amounts_upwards(self, altitude_m: float, sine: float) -> Array:
        """Absorber amounts (K,) from an altitude to space, given the sine of the zenith angle there."""
        layers = self.between(altitude_m, SPACE)
        invariant = self._index(altitude_m) * (self.earth_radius_m + altitude_m) * sine
        result: Array = slant_factors(layers, np.array([invariant]))[0] @ layers.amount
        return result

    def amounts(self, paths: Sequence[Path]) -> Array:
        """Absorber amounts of composite paths, (P, K)."""
        result = np.zeros((len(paths), self.columns))
        legs: dict[tuple[float, float], list[tuple[int, float]]] = {}
        for row, path in enumerate(paths):
            for leg in path.legs:
                legs.setdefault((leg.lower_m, leg.upper_m), []).append((row, leg.zenith_deg))
        for (lower, upper), rays in legs.items():
            layers = self.between(lower, upper)
            slant = self.slant(layers, lower, np.array([zenith for _, zenith in rays]))
            np.add.at(result, [row for row, _ in rays], slant @ layers.amount)
        return result

    def _index(self, altitude_m: float) -> float:
        refractivity = np.interp(altitude_m, self._state.altitude_m, np.log(self._state.refractivity))
        return 1.0 + math.exp(float(refractivity))

    def _partial(self, lower_m: float, upper_m: float) -> Layers:
        if upper_m <= lower_m:
            return self._layers.slice(0, 0)
        ends = join_states(state_at(self._state, lower_m), state_at(self._state, upper_m))
        return make_layers(ends, self.earth_radius_m)
