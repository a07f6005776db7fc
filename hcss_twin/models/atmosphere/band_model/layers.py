"""Atmospheric layers: absorber amounts, mean temperatures, refracted rays, and amounts along composite paths.

Between levels, densities that fall with height vary exponentially and all others linearly (subroutines FILL and LAYER
of LOWTRAN7). A layer consists of one or more *cells*, each thin enough for a single slant factor.

A partial layer has the densities and cells of the whole layer, cut off at its ends, so that amounts vary continuously
with the ends. LOWTRAN7 treats the part as a separate layer: its number of cells jumps with its thickness, and haze that
decreases linearly to zero at a level decreases exponentially when the layer ends below that level.

Rays are refracted in spherical layers, as in LOWTRAN7 (W. O. Gallery, F. X. Kneizys and S. A. Clough, *Air Mass
Computer Program for Atmospheric Transmittance/Radiance Calculation: FSCATM*, AFGL-TR-83-0065, 1983): n r sin(zenith)
is constant along a ray. FSCATM integrates over x = r cos(zenith), which fails under strong inversions, where light
bends as much as the Earth and x does not grow with height; here the length is integrated over r^2.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.cached_method import cached_method, weakly
from hcss_twin.models.atmosphere.band_model.absorber_density import (
    COLD_SELF_COLUMN,
    OXYGEN_COLUMN,
    OXYGEN_LINEAR_COLUMN,
    OXYGEN_TEMPERATURE_K,
    LevelState,
)
from hcss_twin.physics.paths import SPACE, Leg, LegSums, Path

Indices = NDArray[np.intp]

_CELL_M, _LOW_CELL_M, _LOW_M = 2_500.0, 500.0, 12_000.0
"""Maximum cell thickness, and maximum below ``_LOW_M``, where water vapour decreases within a layer."""
_WARM_SELF_K, _COLD_SELF_K = 296.0, 260.0
"""Temperatures of the two H2O self-continuum tables, interpolated to the mean layer temperature."""

_FLAT = 1e-5
"""Relative density change below which LOWTRAN7 integrates linearly."""


@dataclass(frozen=True)
class Layers:
    """A stack of layers, lowest first.

    Attributes
    ----------
    radius_m, index : ndarray (M, 3)
        At bottom, middle and top of each cell: distance from the Earth's centre, and refractive index.
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
        np.concatenate([part.thickness_m for part in parts]),
        np.concatenate([part.amount for part in parts]),
        np.concatenate([part.first_cell + size for part, size in zip(parts, sizes, strict=True)]),
        np.concatenate([part.temperature_K for part in parts]),
    )


def cell_limits_m(level_m: Array) -> Array:
    """Return the altitudes (M + 1,) of the cell boundaries, lowest first."""
    thickness = np.diff(level_m)
    thickest = np.where(level_m[:-1] < _LOW_M, _LOW_CELL_M, _CELL_M)
    parts = np.maximum(np.ceil(thickness / thickest - 1e-9).astype(np.intp), 1)
    first = np.repeat(np.cumsum(parts) - parts, parts)
    layer = np.repeat(np.arange(thickness.size), parts)
    share = (np.arange(layer.size) - first) / parts[layer]
    result: Array = np.append(level_m[layer] + share * thickness[layer], level_m[-1])
    return result


def make_layers(
    state: LevelState,
    earth_radius_m: float,
    bottom_m: Array,
    top_m: Array,
    amount: Array | None = None,
    stack: Indices | None = None,
) -> Layers:
    """Integrate the densities over cells.

    Parameters
    ----------
    state : LevelState
    earth_radius_m : float
    bottom_m, top_m : ndarray (M,)
        Ends of the cells, each within one layer; neighbouring cells of a stack touch.
    amount : ndarray (M, K), optional
        Vertical amounts of the cells, if they are known (:func:`vertical_amounts`).
    stack : ndarray of int (M,), optional
        To which of several stacks, one after the other, a cell belongs.

    Returns
    -------
    Layers
        One for each pair of levels with cells between them, possibly a partial layer.
    """
    thickness, layer, ends = _place(state, bottom_m, top_m)
    begins = np.ones(layer.size, dtype=np.bool_)
    begins[1:] = layer[1:] != layer[:-1]
    if stack is not None:
        begins[1:] |= stack[1:] != stack[:-1]
    first_cell = np.flatnonzero(begins)
    cells = np.append(first_cell[1:], layer.size) - first_cell
    edges = np.stack((ends[:, 0], np.mean(ends, axis=1), ends[:, 1]), axis=1)
    height = state.altitude_m[layer, None] + edges * thickness[layer, None]
    local = state.refractivity[layer, None] * np.exp(-edges * state.fall[layer, None])
    radius = earth_radius_m + height
    temperature = _mean_temperature(state, layer[first_cell], ends[first_cell, 0], ends[first_cell + cells - 1, 1])
    amount = vertical_amounts(state, bottom_m, top_m) if amount is None else amount.copy()
    cold_share = np.clip((_WARM_SELF_K - temperature) / (_WARM_SELF_K - _COLD_SELF_K), 0.0, 1.0)
    amount[:, COLD_SELF_COLUMN] *= np.repeat(cold_share, cells)
    amount[:, OXYGEN_LINEAR_COLUMN] -= OXYGEN_TEMPERATURE_K * amount[:, OXYGEN_COLUMN]
    return Layers(
        radius_m=radius,
        index=1.0 + local,
        thickness_m=top_m - bottom_m,
        amount=amount,
        first_cell=first_cell,
        temperature_K=temperature,
    )


def vertical_amounts(state: LevelState, bottom_m: Array, top_m: Array) -> Array:
    """Return the integrals (M, K) of the densities over cells, whatever the temperature of their layers."""
    thickness, layer, ends = _place(state, bottom_m, top_m)
    return _integral(state.density[:-1][layer], state.density[1:][layer], ends, thickness[layer])


def _place(state: LevelState, bottom_m: Array, top_m: Array) -> tuple[Array, Indices, Array]:
    """Return the thickness of all layers, the layer of each cell (M,), and its ends (M, 2) as shares of the layer."""
    level_m, thickness = state.altitude_m, state.thickness_m
    layer = np.searchsorted(level_m, bottom_m, side="right") - 1
    ends = (np.stack((bottom_m, top_m), axis=1) - level_m[layer, None]) / thickness[layer, None]
    return thickness, layer, ends


def _integral(lower: Array, upper: Array, edges: Array, thickness_m: Array) -> Array:
    """Return the integrals (M, K) over partial layers, from densities per km at bottom and top (M, K)."""
    falls = (lower > 0.0) & (upper > 0.0) & (upper < lower * (1.0 - _FLAT))
    ratio = np.where(falls, upper, 1.0) / np.where(falls, lower, np.e)
    logarithm = np.log(ratio)
    begin, end = edges[:, :1], edges[:, 1:]
    exponential = lower * (np.exp(begin * logarithm) - np.exp(end * logarithm)) / -logarithm
    linear = (end - begin) * (lower + (upper - lower) * 0.5 * (begin + end))
    result: Array = 1e-3 * thickness_m[:, None] * np.where(falls, exponential, linear)
    return result


def _mean_temperature(state: LevelState, layer: Indices, begin: Array, end: Array) -> Array:
    """Return mean temperatures (L,) between two fractions of the layer thickness: pressure over density integral.

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


LEAST_BENT_SHARE = 0.25
"""Least cos^2(zenith) of a ray, as a share of that of the straight ray; 0.7 to 0.85 near the horizon in ordinary air.

Under strong inversions air bends rays within a few tenths of a degree of the horizon back to the sea. Layers that are
horizontal for hundreds of kilometres do not exist: such rays reach space, with at most twice the length."""


def slant_factors(layers: Layers, start_index: Array, impact_m: Array) -> Array:
    """Return ray length divided by cell thickness, which is always above 0.

    With x = r cos(zenith), ds = d(r^2) / 2x; x^2 is nearly linear in r^2 (exactly so without refraction). The last
    factor is the correction of second order by the middle of the cell.

    Parameters
    ----------
    layers : Layers
        M cells.
    start_index : ndarray (M,) or (1,)
        Refractive index where the ray begins.
    impact_m : ndarray (P, M) or (P, 1)
        r sin(zenith) of each ray where it begins.

    Returns
    -------
    ndarray (P, M)
    """
    straight = impact_m[..., None] / layers.radius_m
    bent = straight * (start_index[:, None] / layers.index)
    # (1 - s)(1 + s) is more accurate than 1 - s^2.
    cosine2 = np.maximum((1.0 - bent) * (1.0 + bent), LEAST_BENT_SHARE * (1.0 - straight) * (1.0 + straight))
    along = layers.radius_m * np.sqrt(np.maximum(cosine2, 0.0))
    lower, middle, upper = along[..., 0], along[..., 1], along[..., 2]
    bottom, centre, top = layers.radius_m.T
    share = 0.5 * (bottom + centre) / (bottom + top)  # of r^2 below the middle
    expected = np.sqrt((1.0 - share) * lower**2 + share * upper**2)
    result: Array = (bottom + top) / (lower + upper) * (1.0 + 2.0 * expected / middle) / 3.0
    return result


_MAX_PARTS = 1024
"""Partial profiles held in memory: many paths share their legs."""

_RAY_CELLS = 4096
"""Cells times zenith angles whose amounts are computed together."""

_NOTHING_M = 1e-6
"""Thinner partial layers are neglected; rounding errors are a thousand times smaller."""


class LayeredAir:
    """Layers of a profile or of any part of it.

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
        self._vertical = vertical_amounts(state, self._limit_m[:-1], self._limit_m[1:])
        self._layers = make_layers(state, earth_radius_m, self._limit_m[:-1], self._limit_m[1:], self._vertical)
        self.columns = state.density.shape[1]
        self._parts = cached_method(self._between, _MAX_PARTS)
        self.amounts_upwards = cached_method(self._amounts_upwards, _MAX_PARTS)
        self._sums = LegSums(self.columns, weakly(self._compute))

    def between(self, lower_m: float, upper_m: float) -> Layers:
        """Return the layers between two altitudes, with partial layers at the ends."""
        return self._parts(lower_m, upper_m)

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
        """Return the slant factors (P, M) of rays that start at ``lower_m``.

        The zenith angle at the start is that of a straight ray, sin(zenith) = sin(zenith at the surface) R / (R + h);
        above, the rays are refracted.
        """
        return slant_factors(layers, self._index(np.array([lower_m])), self._impacts_m(zenith_deg))

    def boundaries_m(self, layers: Layers) -> Array:
        """Return the altitudes (L + 1,) of the layer boundaries."""
        bottoms = layers.radius_m[layers.first_cell, 0]
        result: Array = np.append(bottoms, layers.radius_m[-1, 2]) - self.earth_radius_m
        return result

    def _amounts_upwards(self, altitude_m: float, sine: float) -> Array:
        """Return absorber amounts (K,) from an altitude to space, given the sine of the zenith angle there."""
        layers = self.between(altitude_m, SPACE)
        impact_m = np.array([[(self.earth_radius_m + altitude_m) * sine]])
        result: Array = slant_factors(layers, self._index(np.array([altitude_m])), impact_m)[0] @ layers.amount
        return result

    def amounts(self, paths: Sequence[Path]) -> Array:
        """Return the absorber amounts of composite paths, (P, K)."""
        return self._sums.of(paths)

    def _compute(self, legs: Iterable[Leg], known: dict[Leg, Array]) -> None:
        """Compute the absorber amounts (K,) of single legs and store them in ``known``.

        Legs between the same altitudes share their cells, and many of them are computed together: alone, they are so
        short that calls would cost more than the arithmetic.
        """
        spans: dict[tuple[float, float], list[Leg]] = {}
        for leg in legs:
            spans.setdefault((leg.lower_m, leg.upper_m), []).append(leg)
        zenith = {
            degrees: row
            for row, degrees in enumerate(sorted({leg.zenith_deg for span in spans.values() for leg in span}))
        }
        members = iter(spans.values())
        for amounts in self._amounts_of_spans(np.array(list(spans)), np.array(list(zenith))):
            known.update((leg, amounts[zenith[leg.zenith_deg]]) for leg in next(members))

    def _amounts_of_spans(self, span_m: Array, zenith_deg: Array) -> Iterator[Array]:
        """Yield the absorber amounts (Z, K) along rays between the ends of each span, (S, 2)."""
        limit = self._limit_m
        lower, upper = span_m[:, 0], np.minimum(span_m[:, 1], limit[-1])
        # Ends that miss a border of cells by rounding are put on it.
        first = np.searchsorted(limit, lower + _NOTHING_M, side="right")
        last = np.minimum(np.searchsorted(limit, upper - _NOTHING_M), limit.size - 1)
        lower = np.where(np.abs(limit[first - 1] - lower) <= _NOTHING_M, limit[first - 1], lower)
        upper = np.where(np.abs(limit[last] - upper) <= _NOTHING_M, limit[last], upper)
        exists = upper - lower > _NOTHING_M
        counts = np.where(exists, last - first + 1, 0)
        chunk = np.cumsum(counts) * zenith_deg.size // _RAY_CELLS
        for number in np.unique(chunk):
            members = np.flatnonzero(chunk == number)
            amounts = np.zeros((zenith_deg.size, members.size, self.columns))
            some = members[exists[members]]
            if some.size:
                amounts[:, exists[members]] = self._amounts_of_cells(
                    lower[some], upper[some], first[some], counts[some], zenith_deg
                )
            yield from np.moveaxis(amounts, 1, 0)

    def _amounts_of_cells(
        self, lower_m: Array, upper_m: Array, first: Indices, counts: Indices, zenith_deg: Array
    ) -> Array:
        """Return absorber amounts (Z, S, K) of spans from their first border of cells on."""
        starts, span = np.cumsum(counts) - counts, np.repeat(np.arange(counts.size), counts)
        cell = np.arange(span.size) - starts[span] + first[span] - 1
        bottom, top = self._limit_m[cell], self._limit_m[cell + 1]
        bottom[starts], top[starts + counts - 1] = lower_m, upper_m
        cut = np.flatnonzero((bottom != self._limit_m[cell]) | (top != self._limit_m[cell + 1]))
        vertical = self._vertical[cell]
        vertical[cut] = vertical_amounts(self._state, bottom[cut], top[cut])
        layers = make_layers(self._state, self.earth_radius_m, bottom, top, vertical, span)
        slant = slant_factors(layers, self._index(lower_m)[span], self._impacts_m(zenith_deg))
        result: Array = np.add.reduceat(slant[:, :, None] * layers.amount, starts, axis=1)
        return result

    def _impacts_m(self, zenith_deg: Array) -> Array:
        """Return r sin(zenith) (P, 1) of rays straight below their beginning, the same at all altitudes."""
        return self.earth_radius_m * np.sin(np.radians(zenith_deg))[:, None]

    def _index(self, altitude_m: Array) -> Array:
        """Return the refractive index of air at altitudes."""
        result: Array = 1.0 + np.exp(np.interp(altitude_m, self._state.altitude_m, np.log(self._state.refractivity)))
        return result

    def _partial(self, lower_m: float, upper_m: float) -> Layers:
        if upper_m - lower_m <= _NOTHING_M:
            return self._layers.slice(0, 0)
        limit = self._limit_m
        # The same for partial cells.
        inner = limit[(limit > lower_m + _NOTHING_M) & (limit < upper_m - _NOTHING_M)]
        limits = np.array([lower_m, *inner, upper_m])
        return make_layers(self._state, self.earth_radius_m, limits[:-1], limits[1:])
