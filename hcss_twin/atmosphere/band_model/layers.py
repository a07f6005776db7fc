"""Layers between levels: vertical absorber amounts, mean temperatures and the refraction of each.

Between levels densities that fall with height are exponential, all others linear (subroutines FILL and LAYER of
LOWTRAN7). A layer consists of one or more *cells* thin enough for one slant factor each.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcss_twin.atmosphere.band_model.absorber_density import (
    COLD_SELF_COLUMN,
    OXYGEN_COLUMN,
    OXYGEN_LINEAR_COLUMN,
    OXYGEN_TEMPERATURE_K,
    LevelState,
)

Array = NDArray[np.float64]

_CELL_M, _LOW_CELL_M, _LOW_M = 2_500.0, 500.0, 12_000.0
"""Greatest thickness of a cell, and that of one below ``_LOW_M``, where water vapour falls off within a layer."""
_WARM_SELF_K, _COLD_SELF_K = 296.0, 260.0
"""Temperatures of the two tables of the H2O self-continuum; between them the layer's mean temperature decides."""

_FLAT = 1e-5
"""Relative change of density below which LOWTRAN7 integrates linearly."""


@dataclass(frozen=True)
class Layers:
    """A stack of layers, lowest first.

    Attributes
    ----------
    radius_m, index, bending : ndarray (M, 3)
        At bottom, middle and top of each cell: distance from the Earth's centre, refractive index, and radius times
        the relative fall of the index per metre.
    thickness_m : ndarray (M,)
        Of the cells.
    amount : ndarray (M, K)
        Vertical absorber amounts of the cells.
    first_cell : ndarray of int (L,)
        First cell of each layer.
    temperature_K : ndarray (L,)
        Density-weighted mean temperature of each layer.
    """

    radius_m: Array
    index: Array
    bending: Array
    thickness_m: Array
    amount: Array
    first_cell: NDArray[np.intp]
    temperature_K: Array

    def slice(self, first: int, last: int) -> Layers:
        """Return layers ``first`` to ``last`` - 1."""
        starts = np.append(self.first_cell, self.thickness_m.size)
        cells = slice(int(starts[first]), int(starts[max(first, last)]))
        return Layers(
            self.radius_m[cells],
            self.index[cells],
            self.bending[cells],
            self.thickness_m[cells],
            self.amount[cells],
            self.first_cell[first:last] - starts[first],
            self.temperature_K[first:last],
        )


def stack_layers(parts: list[Layers]) -> Layers:
    """Put stacks on top of each other."""
    if len(parts) == 1:
        return parts[0]
    sizes = np.cumsum([0] + [part.thickness_m.size for part in parts[:-1]])
    return Layers(
        np.concatenate([part.radius_m for part in parts]),
        np.concatenate([part.index for part in parts]),
        np.concatenate([part.bending for part in parts]),
        np.concatenate([part.thickness_m for part in parts]),
        np.concatenate([part.amount for part in parts]),
        np.concatenate([part.first_cell + size for part, size in zip(parts, sizes, strict=True)]),
        np.concatenate([part.temperature_K for part in parts]),
    )


def make_layers(state: LevelState, earth_radius_m: float) -> Layers:
    """Integrate the densities between consecutive levels."""
    thickness = np.diff(state.altitude_m)
    thickest = np.where(state.altitude_m[:-1] < _LOW_M, _LOW_CELL_M, _CELL_M)
    parts = np.ceil(thickness / thickest - 1e-9).astype(np.intp)
    layer = np.repeat(np.arange(thickness.size), parts)
    first_cell = np.concatenate(([0], np.cumsum(parts)[:-1]))
    within = np.arange(layer.size) - first_cell[layer]
    edges = np.stack((within, within + 0.5, within + 1.0), axis=1) / parts[layer, None]
    height = state.altitude_m[:-1][layer, None] + edges * thickness[layer, None]
    refractivity = state.refractivity
    fall = np.log(refractivity[:-1] / refractivity[1:])
    local = refractivity[:-1][layer, None] * np.exp(-edges * fall[layer, None])
    radius = earth_radius_m + height
    temperature = _mean_temperature(state)
    amount = _integral(state.density[:-1][layer], state.density[1:][layer], edges[:, ::2], thickness[layer])
    cold_share = np.clip((_WARM_SELF_K - temperature) / (_WARM_SELF_K - _COLD_SELF_K), 0.0, 1.0)
    amount[:, COLD_SELF_COLUMN] *= cold_share[layer]
    amount[:, OXYGEN_LINEAR_COLUMN] -= OXYGEN_TEMPERATURE_K * amount[:, OXYGEN_COLUMN]
    return Layers(
        radius_m=radius,
        index=1.0 + local,
        bending=radius * local / (1.0 + local) * (fall / thickness)[layer, None],
        thickness_m=thickness[layer] / parts[layer],
        amount=amount,
        first_cell=first_cell,
        temperature_K=temperature,
    )


def _integral(lower: Array, upper: Array, edges: Array, thickness_m: Array) -> Array:
    """Integrals (M, K) over a part of a layer, from densities per km at its bottom and top (M, K)."""
    falls = (lower > 0.0) & (upper > 0.0) & (upper < lower * (1.0 - _FLAT))
    ratio = np.where(falls, upper, 1.0) / np.where(falls, lower, np.e)
    logarithm = np.log(ratio)
    begin, end = edges[:, :1], edges[:, 1:]
    exponential = lower * (np.exp(begin * logarithm) - np.exp(end * logarithm)) / -logarithm
    linear = (end - begin) * (lower + (upper - lower) * 0.5 * (begin + end))
    result: Array = 1e-3 * thickness_m[:, None] * np.where(falls, exponential, linear)
    return result


def _mean_temperature(state: LevelState) -> Array:
    """Pressure integral over density integral, (L,)."""
    number = state.pressure_Pa / state.temperature_K

    def mean(value: Array) -> Array:
        lower, upper = value[:-1], value[1:]
        falls = upper < lower * (1.0 - _FLAT)
        safe = np.where(falls, upper / lower, 0.5)
        result: Array = np.where(falls, (lower - upper) / -np.log(safe), 0.5 * (lower + upper))
        return result

    result: Array = mean(state.pressure_Pa) / mean(number)
    return result


def state_at(state: LevelState, altitude_m: float) -> LevelState:
    """Interpolate one level: temperature linearly, all else exponentially where it is positive (EXPINT).

    Returns
    -------
    LevelState
        Of one level.
    """
    upper = int(np.clip(np.searchsorted(state.altitude_m, altitude_m), 1, state.altitude_m.size - 1))
    pair = slice(upper - 1, upper + 1)
    low, high = state.altitude_m[pair]
    fraction = (altitude_m - low) / (high - low)

    def exponential(values: Array) -> Array:
        below, above = values[pair]
        positive = (below > 0.0) & (above > 0.0)
        ratio = np.where(positive, above, 1.0) / np.where(positive, below, 1.0)
        result: Array = np.where(positive, below * ratio**fraction, below + (above - below) * fraction)
        return result[None]

    return LevelState(
        np.array([altitude_m]),
        exponential(state.pressure_Pa),
        state.temperature_K[pair][:1] * (1.0 - fraction) + state.temperature_K[pair][1:] * fraction,
        exponential(state.refractivity),
        exponential(state.density),
    )


def join_states(lower: LevelState, upper: LevelState) -> LevelState:
    """Put levels on top of each other."""
    return LevelState(
        np.concatenate((lower.altitude_m, upper.altitude_m)),
        np.concatenate((lower.pressure_Pa, upper.pressure_Pa)),
        np.concatenate((lower.temperature_K, upper.temperature_K)),
        np.concatenate((lower.refractivity, upper.refractivity)),
        np.concatenate((lower.density, upper.density)),
    )
