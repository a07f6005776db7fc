"""Air between interfaces: transmittance and emission of legs, seen through whole composite paths.

Of C columns at once, whose legs end at heights of their own: S = C x V values are those of all V wavenumbers of the
first column, then of the second, and so on.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.models.radiance.physical.composite_paths import Crossing, PathAmounts
from hcss_twin.physics.paths import SPACE, Leg, Path
from hcss_twin.physics.planck import planck
from hcss_twin.physics.profile import Profile
from hcss_twin.providers import TransmittanceProvider

Heights = tuple[float, ...]
"""One of each column, m."""

_DARK = 1e-30
"""Transmittance below which nothing seen through a path could matter."""

_COARSE_MASS, _COARSE_STEP_M = 0.05, 8e3
"""Layers of scattered light hold this share of the air's mass at least, or are this thick."""

_KEPT_LOOKS = 16
"""Legs seen through what is in front of them that are kept, about those of columns that are computed together: the
tracer and the closure look along the same ones, and so do clear skies under all suns."""

_KEPT_LEGS, _KEPT_SOURCES = 2048, 256
"""Legs whose absorbers, and whose emission, are kept: columns share those below and above, suns share all."""


@dataclass(frozen=True)
class LegView:
    """Legs seen through the paths in front of them.

    Attributes
    ----------
    emission : ndarray (P, S)
        What the air of each leg sends through its path, W m-2 sr-1 (cm-1)-1.
    transmittance : ndarray (P, S)
        Of each path and its leg together.
    crossed : PathAmounts (P,)
        Each path and its leg together.
    """

    emission: Array
    transmittance: Array
    crossed: PathAmounts

    def conditional(self, front: Array, source: Array) -> LegView:
        """Return emission and transmittance for an observer at the end of the paths, whose transmittance is ``front``.

        Where ``front`` is as good as 0 the leg counts as opaque and sends ``source``.
        """
        dark = front < _DARK
        safe = np.where(dark, 1.0, front)
        return LegView(
            np.where(dark, source, self.emission / safe), np.where(dark, 0.0, self.transmittance / safe), self.crossed
        )


@dataclass(frozen=True)
class _Look:
    """What is asked of :meth:`Air.leg`; what is in front counts by its key."""

    key: Hashable
    zenith_deg: tuple[float, ...]
    lower_m: Heights
    upper_m: Heights
    downward: bool
    coarse: bool
    front: PathAmounts = field(compare=False)
    front_transmittance: Array = field(compare=False)


class Air:
    """Legs of a spectrum through one profile.

    Parameters
    ----------
    provider : TransmittanceProvider
    profile : Profile
        Brings the temperatures.
    wavenumber_cm1 : ndarray (V,)
    """

    def __init__(self, provider: TransmittanceProvider, profile: Profile, wavenumber_cm1: Array) -> None:
        self._crossing = Crossing(provider, wavenumber_cm1)
        self._profile = profile
        self.wavenumber_cm1 = wavenumber_cm1
        self._black: dict[float, Array] = {}
        self._coarse_m = _coarse_levels(profile)
        self._looks = lru_cache(maxsize=_KEPT_LOOKS)(self._look)
        self._pieces = lru_cache(maxsize=_KEPT_LEGS)(self._make_pieces)
        self._sources = lru_cache(maxsize=_KEPT_SOURCES)(self._make_sources)

    def black_body(self, temperature_K: float) -> Array:
        """Return the Planck radiance (V,)."""
        if temperature_K not in self._black:
            self._black[temperature_K] = planck(self.wavenumber_cm1, temperature_K)
        return self._black[temperature_K]

    def black_bodies(self, temperature_K: Sequence[float]) -> Array:
        """Return the Planck radiance (S,) at the temperature of each column."""
        return np.concatenate([self.black_body(kelvin) for kelvin in temperature_K])

    def crossed(self, paths: Sequence[Sequence[Path]]) -> PathAmounts:
        """Return paths (P, C) as the provider adds them."""
        return self._crossing.of(paths)

    def transmittance(self, crossed: PathAmounts) -> Array:
        """Return transmittance (P, S) of composite paths."""
        return self._crossing.transmittance(crossed)

    def leg(
        self,
        front: PathAmounts,
        front_transmittance: Array,
        zenith_deg: Sequence[float],
        lower_m: Heights,
        upper_m: Heights,
        downward: bool,
        coarse: bool = False,
    ) -> LegView:
        """Look along a leg through the path in front of it.

        E(x, l) = sum over layers n of J_n [T(x + l before n) - T(x + l with n)]: only summed absorber amounts
        enter the transmittance, and the weights of all layers and of what lies behind sum to T(x).

        Parameters
        ----------
        front : PathAmounts (P,)
            What the light crosses after the leg, on its way to the sensor.
        front_transmittance : ndarray (P, S)
            Of ``front``.
        zenith_deg : sequence of float (P,)
            Zenith angle of each leg at the surface.
        lower_m, upper_m : tuple of float (C,)
            Its ends in each column; ``upper_m`` may be ``SPACE``.
        downward : bool
            Whether the observer looks down: the leg's upper end is the near one.
        coarse : bool
            Whether thin layers high up may be joined: for light that is scattered afterwards.
        """
        zeniths = tuple(zenith_deg)
        return self._looks(_Look(front.key, zeniths, lower_m, upper_m, downward, coarse, front, front_transmittance))

    def _look(self, asked: _Look) -> LegView:
        """Look along a leg that is not known."""
        front, front_transmittance, zenith_deg = asked.front, asked.front_transmittance, asked.zenith_deg
        lower_m, upper_m, downward, coarse = asked.lower_m, asked.upper_m, asked.downward, asked.coarse
        levels = self._coarse_m if coarse else self._profile.altitude_m
        edges = [self._edges(low, high, levels) for low, high in zip(lower_m, upper_m, strict=True)]
        count = max(map(len, edges)) - 1
        if count < 1:
            return LegView(np.zeros_like(front_transmittance), front_transmittance, front)
        distinct = tuple(sorted(set(zenith_deg)))
        # Columns with fewer layers have some of no thickness at the far end.
        padded = np.minimum(np.arange(count), np.array([[max(len(own) - 2, 0)] for own in edges]))
        first, *others = (
            self._pieces(own, high == SPACE, downward, distinct).take(
                (np.arange(len(distinct))[:, None] * max(len(own) - 1, 1) + layers).reshape(-1)
            )
            for own, high, layers in zip(edges, upper_m, padded, strict=True)
        )
        number = np.arange(count)
        place = np.array([distinct.index(zenith) for zenith in zenith_deg])
        paths = front.take(np.repeat(np.arange(len(front)), count)) + first.beside(others).take(
            (place[:, None] * count + number).reshape(-1)
        )
        beyond = self.transmittance(paths).reshape(len(front), count, -1)
        weights = np.concatenate((front_transmittance[:, None] - beyond[:, :1], beyond[:, :-1] - beyond[:, 1:]), axis=1)
        # Where nothing absorbs, rounding could leave less than nothing.
        np.maximum(weights, 0.0, out=weights)
        order = -1 if downward else 1
        sources = np.concatenate(
            [self._sources(own)[::order][layers] for own, layers in zip(edges, padded, strict=True)], axis=1
        )
        emission: Array = np.einsum("pns,ns->ps", weights, sources)
        whole = paths.take(np.arange(count - 1, len(paths), count))
        return LegView(emission, beyond[:, -1], whole)

    def near_source(self, lower_m: Heights, upper_m: Heights, downward: bool) -> Array:
        """Return the Planck radiance (S,) of a leg's near end."""
        top = float(self._profile.altitude_m[-1])
        near = np.minimum(upper_m, top) if downward else np.array(lower_m)
        return self.black_bodies(self._profile.temperature_at(near).tolist())

    def _make_pieces(
        self, edges: tuple[float, ...], to_space: bool, downward: bool, zenith_deg: tuple[float, ...]
    ) -> PathAmounts:
        """Parts of the legs of one column (Z x N,): for each zenith angle the first layer, the first two, ...

        From the near end; one of no length where there is no layer.
        """
        count = len(edges) - 1
        if count < 1:
            return self._crossing.of([[Path()] for _ in zenith_deg])
        paths = []
        for zenith in zenith_deg:
            for n in range(1, count + 1):
                low, high = (edges[count - n], edges[count]) if downward else (edges[0], edges[n])
                reach = SPACE if to_space and high == edges[-1] else high
                paths.append([Path((Leg(low, reach, zenith),))])
        return self._crossing.of(paths)

    def _edges(self, lower_m: float, upper_m: float, levels: Array) -> tuple[float, ...]:
        """Levels within a leg, and its ends."""
        top = min(upper_m, float(levels[-1]))
        if top <= lower_m:
            return (lower_m,)
        inner = levels[(levels > lower_m) & (levels < top)]
        return (lower_m, *(float(level) for level in inner), top)

    def _make_sources(self, edges: tuple[float, ...]) -> Array:
        """Planck radiance (N, V) of each layer between edges at its pressure-weighted mean temperature.

        For a temperature linear in height and a density exponential in it, that is the mean of the ends plus a twelfth
        of their difference times ln(p below / p above), to first order. 0 where there is no layer.
        """
        altitude = np.asarray(edges)
        temperature = self._profile.temperature_at(altitude)
        ratio = -np.diff(np.log(self._profile.pressure_at(altitude)))
        mean = 0.5 * (temperature[:-1] + temperature[1:]) - np.diff(temperature) * np.minimum(ratio, 6.0) / 12.0
        if not mean.size:
            return np.zeros((1, self.wavenumber_cm1.size))
        return np.stack([self.black_body(kelvin) for kelvin in mean.tolist()])


def _coarse_levels(profile: Profile) -> Array:
    """Levels of a profile without those between which there is next to no air."""
    altitude, pressure = profile.altitude_m, profile.pressure_Pa
    kept = [0]
    for index in range(1, altitude.size - 1):
        mass = (pressure[kept[-1]] - pressure[index]) / pressure[0]
        if mass >= _COARSE_MASS or altitude[index] - altitude[kept[-1]] >= _COARSE_STEP_M:
            kept.append(index)
    return altitude[[*kept, altitude.size - 1]]
