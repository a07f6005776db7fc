"""Layers between levels: vertical absorber amounts, mean temperatures and the refraction of each.

Between levels densities that fall with height are exponential, all others linear (subroutines FILL and LAYER of
LOWTRAN7). A layer consists of one or more *cells* thin enough for one slant factor each.

Part of a layer has the densities and the cells of the whole, cut off at its ends, so that amounts do not jump with its
ends. LOWTRAN7 makes a layer of its own of it: one that thickens gets a cell more at once, and haze that fades linearly
to nothing at a level would fade exponentially as soon as the layer ends somewhat below.

Refracted rays through spherical layers (subroutines RFPATH and LAYER of LOWTRAN7).

W. O. Gallery, F. X. Kneizys and S. A. Clough, *Air Mass Computer Program for Atmospheric Transmittance/Radiance
Calculation: FSCATM*, AFGL-TR-83-0065 (1983): with x = r cos(zenith), the length of a ray is the integral of
1 / (1 - (r / rho) sin^2(zenith)) over x, rho being the radius of curvature of a horizontal ray, and n r sin(zenith)
stays constant along the ray.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.models.atmosphere.band_model.absorber_density import (
    COLD_SELF_COLUMN,
    OXYGEN_COLUMN,
    OXYGEN_LINEAR_COLUMN,
    OXYGEN_TEMPERATURE_K,
    LevelState,
)

Indices = NDArray[np.intp]

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
    first_cell: Indices
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


def cell_limits_m(level_m: Array) -> Array:
    """Altitudes (M + 1,) at which the cells of the layers between levels end, lowest first."""
    thickness = np.diff(level_m)
    thickest = np.where(level_m[:-1] < _LOW_M, _LOW_CELL_M, _CELL_M)
    parts = np.maximum(np.ceil(thickness / thickest - 1e-9).astype(np.intp), 1)
    first = np.repeat(np.cumsum(parts) - parts, parts)
    layer = np.repeat(np.arange(thickness.size), parts)
    share = (np.arange(layer.size) - first) / parts[layer]
    result: Array = np.append(level_m[layer] + share * thickness[layer], level_m[-1])
    return result


def make_layers(state: LevelState, earth_radius_m: float, limit_m: Array) -> Layers:
    """Integrate the densities over cells.

    Parameters
    ----------
    state : LevelState
    earth_radius_m : float
    limit_m : ndarray (M + 1,)
        Altitudes between which the cells lie, ascending; levels between the first and the last are among them.

    Returns
    -------
    Layers
        One for each pair of levels in between which there are cells, which may be a part of it.
    """
    level_m, thickness = state.altitude_m, np.diff(state.altitude_m)
    layer = np.searchsorted(level_m, limit_m[:-1], side="right") - 1
    touched, first_cell, cells = np.unique(layer, return_index=True, return_counts=True)
    ends = (np.stack((limit_m[:-1], limit_m[1:]), axis=1) - level_m[layer, None]) / thickness[layer, None]
    edges = np.stack((ends[:, 0], np.mean(ends, axis=1), ends[:, 1]), axis=1)
    height = level_m[layer, None] + edges * thickness[layer, None]
    refractivity = state.refractivity
    fall = np.log(refractivity[:-1] / refractivity[1:])
    local = refractivity[:-1][layer, None] * np.exp(-edges * fall[layer, None])
    radius = earth_radius_m + height
    temperature = _mean_temperature(state, touched, ends[first_cell, 0], ends[first_cell + cells - 1, 1])
    amount = _integral(state.density[:-1][layer], state.density[1:][layer], edges[:, ::2], thickness[layer])
    cold_share = np.clip((_WARM_SELF_K - temperature) / (_WARM_SELF_K - _COLD_SELF_K), 0.0, 1.0)
    amount[:, COLD_SELF_COLUMN] *= np.repeat(cold_share, cells)
    amount[:, OXYGEN_LINEAR_COLUMN] -= OXYGEN_TEMPERATURE_K * amount[:, OXYGEN_COLUMN]
    return Layers(
        radius_m=radius,
        index=1.0 + local,
        bending=radius * local / (1.0 + local) * (fall / thickness)[layer, None],
        thickness_m=np.diff(limit_m),
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


def _mean_temperature(state: LevelState, layer: Indices, begin: Array, end: Array) -> Array:
    """Pressure integral over density integral of layers (L,), from one share of their thickness to another.

    Within a layer temperature is linear and pressure exponential.
    """

    def at(share: Array) -> tuple[Array, Array]:
        below, above = state.pressure_Pa[layer], state.pressure_Pa[layer + 1]
        low, high = state.temperature_K[layer], state.temperature_K[layer + 1]
        return below * (above / below) ** share, low * (1.0 - share) + high * share

    def mean(lower: Array, upper: Array) -> Array:
        falls = upper < lower * (1.0 - _FLAT)
        safe = np.where(falls, upper / lower, 0.5)
        result: Array = np.where(falls, (lower - upper) / -np.log(safe), 0.5 * (lower + upper))
        return result

    (lower_Pa, lower_K), (upper_Pa, upper_K) = at(begin), at(end)
    result: Array = mean(lower_Pa, upper_Pa) / mean(lower_Pa / lower_K, upper_Pa / upper_K)
    return result


def slant_factors(layers: Layers, invariant_m: Array) -> Array:
    """Length of rays over the thickness of each cell.

    Parameters
    ----------
    layers : Layers
        M cells.
    invariant_m : ndarray (P,)
        n r sin(zenith) of each ray.

    Returns
    -------
    ndarray (P, M)
    """
    sine = invariant_m[:, None, None] / (layers.index * layers.radius_m)
    along = layers.radius_m * np.sqrt((1.0 - sine) * (1.0 + sine))
    stretch = 1.0 / (1.0 - layers.bending * sine**2)
    # Parabola through three unequally spaced points.
    whole = along[..., 2] - along[..., 0]
    first = along[..., 1] - along[..., 0]
    second = along[..., 2] - along[..., 1]
    length = (whole / 6.0) * (
        (2.0 - second / first) * stretch[..., 0]
        + whole**2 / (first * second) * stretch[..., 1]
        + (2.0 - first / second) * stretch[..., 2]
    )
    result: Array = length / layers.thickness_m
    return result
