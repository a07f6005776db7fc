"""Air between interfaces: transmittance and emission of legs, seen through composite paths.

C columns are computed together; the leg ends differ between columns. An axis S = C x V contains all V wavenumbers of
the first column, then of the second, and so on.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.cached_method import cached_method
from hcss_twin.core.result_cache import OwnMemory
from hcss_twin.models.radiance.physical.composite_paths import (
    AbsorberPaths,
    CompositePaths,
    LayerAmounts,
    PathTransmittance,
)
from hcss_twin.models.radiance.physical.numerics import SUBLAYERS
from hcss_twin.physics.paths import SPACE, Path
from hcss_twin.physics.planck import planck
from hcss_twin.physics.profile import Profile
from hcss_twin.physics.thermal_scattering import DIFFUSE_DEG, backscattered, scattered_share, streams
from hcss_twin.providers import TransmittanceProvider

Heights = tuple[float, ...]
"""One altitude for each column, m."""

_DARK = 1e-30
"""Transmittance below which a path is treated as opaque."""

_COARSE_MASS, _COARSE_STEP_M, _COARSE_K = 0.1, 8e3, 0.1
"""Minimum mass fraction, or thickness, of layers for light that is scattered later, and how far their temperature may
be from linear at sea-level pressure (higher up, farther in proportion)."""

_TOP_LAYERS = 3
"""Layers into which the highest one is divided, for light that reaches the sensor directly."""

_MAX_LEG_VIEWS = 16
"""Leg views in memory, about one set of columns computed together; tracer, closure and all suns share them."""

_LARGE = 256
"""Paths times wavenumbers of a column from which on it is computed alone."""

_MOST_VALUES = 2**22
"""Transmittances of the legs of single columns in memory."""

_MOST_KEPT = 2**15
"""Paths times wavenumbers of a column whose transmittances are kept for other scenes: pairs of streams would fill the
memory, and cost little."""

_MAX_LEGS, _MAX_SOURCES = 2048, 256
"""Legs in memory, with ends and absorbers, or emission: columns share those below and above clouds, suns share all."""


@dataclass(frozen=True)
class LegView:
    """Legs seen through the paths in front of them.

    Attributes
    ----------
    emission : ndarray (P, S)
        Emission of the air in each leg, transmitted by its path, W m-2 sr-1 (cm-1)-1.
    transmittance : ndarray (P, S)
        Of each path combined with its leg.
    crossed : CompositePaths (P,)
        Each path combined with its leg.
    """

    emission: Array
    transmittance: Array
    crossed: CompositePaths

    def conditional(self, front: Array, source: Array) -> LegView:
        """Return emission and transmittance for an observer at the end of paths with transmittance ``front``.

        Where ``front`` is practically 0, the leg is treated as opaque and emits ``source``.
        """
        dark = front < _DARK
        safe = np.where(dark, 1.0, front)
        return LegView(
            np.where(dark, source, self.emission / safe), np.where(dark, 0.0, self.transmittance / safe), self.crossed
        )


@dataclass(frozen=True)
class _LegRequest:
    """Hashable arguments of :meth:`Air.leg`: the path in front is represented by its key."""

    key: Hashable
    zenith_deg: tuple[float, ...]
    lower_m: Heights
    upper_m: Heights
    downward: bool
    scattered: int
    front: CompositePaths = field(compare=False)
    front_transmittance: Array = field(compare=False)

    def by_column(self) -> Iterator[_LegRequest]:
        """Yield the request of each column."""
        count = len(self.lower_m)
        through = self.front_transmittance.reshape(len(self.front), count, -1)
        for column, (lower, upper) in enumerate(zip(self.lower_m, self.upper_m, strict=True)):
            front = self.front.column(column)
            yield replace(
                self,
                key=front.key,
                lower_m=(lower,),
                upper_m=(upper,),
                front=front,
                front_transmittance=through[:, column],
            )


def _beside(views: list[LegView]) -> LegView:
    """Join the columns of several views."""
    first, *others = views
    if not others:
        return first
    emission, transmittance = (
        np.concatenate([getattr(view, name) for view in views], axis=1) for name in ("emission", "transmittance")
    )
    return LegView(emission, transmittance, first.crossed.beside([view.crossed for view in others]))


class Air:
    """Transmittance and emission of legs through one profile, at given wavenumbers.

    Parameters
    ----------
    provider : TransmittanceProvider
    profile : Profile
        Source of the temperatures.
    wavenumber_cm1 : ndarray (V,)
    sublayers : int
        Parts into which the layers between two levels are divided for their emission; even.
    layers : dict, optional
        Absorber amounts that other wavenumbers share.
    memory : OwnMemory, optional
        Keeps legs and transmittances for scenes in the same air; used if paths are sums of absorber amounts.
    kept_values : int
        Transmittances of the legs of single columns in memory; their absorbers in proportion.
    space_K : float
        Temperature of space, whose light aerosol scatters.
    """

    def __init__(
        self,
        provider: TransmittanceProvider,
        profile: Profile,
        wavenumber_cm1: Array,
        sublayers: int = SUBLAYERS,
        layers: LayerAmounts | None = None,
        memory: OwnMemory | None = None,
        kept_values: int = _MOST_VALUES,
        space_K: float = 0.0,
    ) -> None:
        self._crossing = PathTransmittance(provider, wavenumber_cm1, {} if layers is None else layers)
        self._profile = profile
        self._sublayers = sublayers
        self._power_law = provider.declares.legs == "to_space"
        self.wavenumber_cm1 = wavenumber_cm1
        self._memory = None if memory is None or memory.memory is None else memory
        self._numbers = wavenumber_cm1.tobytes() + sublayers.to_bytes(2, "big") + repr(space_K).encode()
        self._black: dict[float, Array] = {}
        self._coarse_m, self._fine_m = _coarse_levels(profile), _fine_levels(profile)
        self._leg_views = cached_method(self._leg_view, _MAX_LEG_VIEWS)
        most = max(kept_values // (wavenumber_cm1.size * 16), _MAX_LEG_VIEWS)
        self._leg_of_column = cached_method(self._leg_of_scenes, most)
        self._pieces = cached_method(self._new_pieces, _MAX_LEGS * kept_values // _MOST_VALUES)
        self._sources = cached_method(self._new_sources, _MAX_SOURCES)
        self._edges = cached_method(self._new_edges, _MAX_LEGS)
        self._space = planck(wavenumber_cm1, space_K) if space_K > 0.0 else np.zeros(wavenumber_cm1.size)
        self._clear_streams = cached_method(self._new_clear_streams, 1)
        self._streams = cached_method(self._new_streams, _MAX_SOURCES)

    def with_gas(self, provider: TransmittanceProvider) -> Air:
        """Return the same air with another gas, at the first wavenumber."""
        return Air(provider, self._profile, self.wavenumber_cm1[:1], self._sublayers)

    def black_body(self, temperature_K: float) -> Array:
        """Return the Planck radiance (V,)."""
        return self._black_bodies([temperature_K])[0]

    def black_bodies(self, temperature_K: Sequence[float]) -> Array:
        """Return the Planck radiance (S,) at the temperature of each column."""
        return np.concatenate(self._black_bodies(temperature_K))

    def _black_bodies(self, temperature_K: Sequence[float]) -> list[Array]:
        new = [kelvin for kelvin in dict.fromkeys(temperature_K) if kelvin not in self._black]
        if new:
            self._black.update(zip(new, planck(self.wavenumber_cm1, np.array(new)[:, None]), strict=True))
        return [self._black[kelvin] for kelvin in temperature_K]

    def crossed(self, paths: Sequence[Sequence[Path]]) -> CompositePaths:
        """Return paths (P, C) in the additive form of the provider."""
        return self._crossing.of(paths)

    def transmittance(self, crossed: CompositePaths) -> Array:
        """Return transmittance (P, S) of composite paths."""
        small = len(crossed) * self.wavenumber_cm1.size <= _MOST_KEPT
        if self._memory is None or not small or not isinstance(crossed, AbsorberPaths):
            return self._crossing.transmittance(crossed)
        parts = self._numbers, crossed.key, str(len(crossed)).encode()
        return self._memory.get_or_compute(parts, lambda: (self._crossing.transmittance(crossed),))[0]

    def leg(
        self,
        front: CompositePaths,
        front_transmittance: Array,
        zenith_deg: Sequence[float],
        lower_m: Heights,
        upper_m: Heights,
        downward: bool,
        scattered: int = 0,
    ) -> LegView:
        """Return the view along a leg through the path in front of it.

        E(x, l) = sum over layers n of J_n [T(x + l before n) - T(x + l with n)]. The transmittance depends only on
        summed absorber amounts, and the weights of all layers and of the light from behind sum to T(x). J_n is Planck
        radiance; looking up, the share of scattering in it is the light of the clear sky and of the sea that aerosol
        sends into the path (:mod:`hcss_twin.physics.thermal_scattering`). Looking down, that would be the light from
        behind, and is taken as emission.

        Parameters
        ----------
        front : CompositePaths (P,)
            Path of the light from the leg to the sensor.
        front_transmittance : ndarray (P, S)
            Of ``front``.
        zenith_deg : sequence of float (P,)
            Zenith angle of each leg at the surface.
        lower_m, upper_m : tuple of float (C,)
            Its ends in each column; ``upper_m`` may be ``SPACE``.
        downward : bool
            Whether the observer looks down, so that the upper end of the leg is the near one.
        scattered : int
            For light that is scattered afterwards: parts of each layer, after thin layers at high altitude are merged;
            even. 0 for light that reaches the sensor directly.
        """
        zeniths = tuple(zenith_deg)
        return self._leg_views(
            _LegRequest(front.key, zeniths, lower_m, upper_m, downward, scattered, front, front_transmittance)
        )

    def _leg_view(self, request: _LegRequest) -> LegView:
        """Return a leg, of each column from the memory.

        Many columns share their upper air, and the arrays of one column fit in the processor's cache; where they are
        small, calls would cost more.
        """
        large = len(request.front) * self.wavenumber_cm1.size >= _LARGE
        if large and isinstance(request.front, AbsorberPaths):
            return _beside([self._leg_of_column(of_column) for of_column in request.by_column()])
        return self._leg_of_scenes(request)

    def _leg_of_scenes(self, request: _LegRequest) -> LegView:
        """Return a leg from the memory that scenes share, if there is one."""
        if self._memory is None or not isinstance(request.front, AbsorberPaths):
            return self._new_leg_view(request)
        ends = repr((request.zenith_deg, request.lower_m, request.upper_m, request.downward, request.scattered))

        def compute() -> tuple[Array, ...]:
            view = self._new_leg_view(request)
            assert isinstance(view.crossed, AbsorberPaths)
            return view.emission, view.transmittance, view.crossed.amounts

        parts = self._numbers, request.front.key, ends.encode()
        emission, transmittance, amounts = self._memory.get_or_compute(parts, compute)
        return LegView(emission, transmittance, AbsorberPaths(amounts))

    def _new_leg_view(self, request: _LegRequest) -> LegView:
        front, front_transmittance, zenith_deg = request.front, request.front_transmittance, request.zenith_deg
        lower_m, upper_m, downward = request.lower_m, request.upper_m, request.downward
        is_coarse, parts = bool(request.scattered), request.scattered or self._sublayers
        edges = [self._edges(low, high, is_coarse, parts) for low, high in zip(lower_m, upper_m, strict=True)]
        count = max(map(len, edges)) - 1
        if count < 1:
            return LegView(np.zeros_like(front_transmittance), front_transmittance, front)
        distinct = tuple(sorted(set(zenith_deg)))
        # Columns with fewer layers get layers of zero thickness at the far end.
        padded = np.minimum(np.arange(count), np.array([[max(len(edge) - 2, 0)] for edge in edges]))
        zenith_index = np.array([distinct.index(zenith) for zenith in zenith_deg])

        def pieces_of(number: int, to_space: bool) -> CompositePaths:
            ends_m = edges[number]
            result = self._pieces(ends_m, to_space and upper_m[number] == SPACE, downward, distinct, parts)
            if len(ends_m) - 1 == count:
                return result
            return result.take(
                (np.arange(len(distinct))[:, None] * max(len(ends_m) - 1, 1) + padded[number]).reshape(-1)
            )

        def pieces(to_space: bool) -> CompositePaths:
            first, *others = (pieces_of(number, to_space) for number in range(len(edges)))
            return first.beside(others)

        # For a path down to a target and up again to space, a power law returns the provider's own transmittance. Its
        # difference from the sum of layers would appear as emission of the highest layer, which is hot.
        layered = pieces(not self._power_law)
        paths = front.through_each(layered, zenith_index)
        beyond = self.transmittance(paths).reshape(len(front), count, -1)
        weights = np.concatenate((front_transmittance[:, None] - beyond[:, :1], beyond[:, :-1] - beyond[:, 1:]), axis=1)
        # Without absorption, rounding could give negative weights.
        np.maximum(weights, 0.0, out=weights)
        order = -1 if downward else 1
        sources = np.concatenate(
            [self._sources(edge)[::order][layers] for edge, layers in zip(edges, padded, strict=True)], axis=1
        )
        along = None if downward else self._crossing.scattering(layered)
        if along is None:
            emission: Array = np.einsum("pns,ns->ps", weights, sources)
        else:
            depth, forward = (
                np.diff(each.reshape(len(distinct), count, -1), axis=1, prepend=0.0)[zenith_index] for each in along
            )
            seen = np.concatenate((front_transmittance[:, None], beyond), axis=1)
            share = scattered_share(seen, depth)
            back = backscattered(np.cos(np.radians(zenith_deg))[:, None, None], _ratio(forward, depth))
            from_sky, from_sea = (
                np.concatenate([each[layers] for each, layers in zip(at, padded, strict=True)], axis=1)
                for at in zip(*(self._streams(edge) for edge in edges), strict=True)
            )
            emission = np.einsum("pns,pns->ps", weights, sources + share * (from_sky - sources))
            emission += np.einsum("pns,pns->ps", weights, share * back * (from_sea - from_sky))
        whole = paths.take(np.arange(count - 1, len(paths), count))
        if self._power_law and SPACE in upper_m:
            whole = front + pieces(True).take(zenith_index * count + count - 1)
        # A copy: views of all layers would stay in memory with it.
        return LegView(emission, beyond[:, -1].copy(), whole)

    def _new_streams(self, edges: tuple[float, ...]) -> tuple[Array, Array]:
        """Return the radiance from the clear sky and from the sea, (N, V) each, in the middle of the parts of a leg."""
        if len(edges) == 1:
            return (self._new_sources(edges),) * 2
        known_m, *known = self._clear_streams()
        middle = 0.5 * (np.array(edges[:-1]) + edges[1:])
        upper = np.clip(np.searchsorted(known_m, middle), 1, known_m.size - 1)
        low, high = known_m[upper - 1], known_m[upper]
        share = np.clip((middle - low) / (high - low), 0.0, 1.0)[:, None]
        one, other = ((1.0 - share) * each[upper - 1] + share * each[upper] for each in known)
        return one, other

    def _new_clear_streams(self) -> tuple[Array, Array, Array]:
        """Return altitudes (M,) and the radiance of both hemispheres there, (M, V) each, without clouds.

        The sea is black, at the temperature of the lowest air.
        """
        edges = self._edges(float(self._coarse_m[0]), SPACE, True, SUBLAYERS)
        steps = self._pieces(edges, not self._power_law, False, (DIFFUSE_DEG,), SUBLAYERS)
        assert isinstance(steps, AbsorberPaths)
        layers = steps.steps()
        scattering = self._crossing.scattering(layers)
        assert scattering is not None
        depth, forward = scattering
        ends = self.black_body(float(self._profile.temperature_K[0])), self._space
        through = self._crossing.transmittance(layers)
        down, up = streams(self._mean_sources(edges), through, depth, _ratio(forward, depth), ends)
        return 0.5 * (np.array(edges[:-1]) + edges[1:]), down, up

    def near_source(self, lower_m: Heights, upper_m: Heights, downward: bool) -> Array:
        """Return the Planck radiance (S,) at the near end of a leg."""
        top = float(self._profile.altitude_m[-1])
        near = np.minimum(upper_m, top) if downward else np.array(lower_m)
        return self.black_bodies(self._profile.temperature_at(near).tolist())

    def _new_pieces(
        self, edges: tuple[float, ...], to_space: bool, downward: bool, zenith_deg: tuple[float, ...], parts: int
    ) -> CompositePaths:
        """Parts of the legs of one column (Z x N,): for each zenith angle the first layer, the first two, ...

        Counted from the near end; a part of zero length if there is no layer.
        """
        if len(edges) < 2:
            return self._crossing.of([[Path()] for _ in zenith_deg])
        ends = (*edges[:-1], SPACE if to_space else edges[-1])
        ends = ends[::-1] if downward else ends
        near = [(ends[n - n % parts], ends[n + 1]) for n in range(len(ends) - 1)]
        within = [(high, low) if downward else (low, high) for low, high in near]
        return self._crossing.nested(within, zenith_deg, parts)

    def _new_edges(self, lower_m: float, upper_m: float, is_coarse: bool, parts: int) -> tuple[float, ...]:
        """Return the ends of a leg, and of all parts of the layers within it."""
        levels = self._coarse_m if is_coarse else self._fine_m
        top = min(upper_m, float(levels[-1]))
        if top <= lower_m:
            return (lower_m,)
        ends = np.array([lower_m, *levels[(levels > lower_m) & (levels < top)], top])
        share = np.tile(np.arange(parts) / parts, (ends.size - 1, 1))
        if not is_coarse and top == levels[-1]:  # see _fine_levels
            share[-1] = 1.0 - (1.0 - share[-1]) ** 2
        return (*(ends[:-1, None] + share * np.diff(ends)[:, None]).ravel().tolist(), top)

    def _new_sources(self, edges: tuple[float, ...]) -> Array:
        """Return the source (N, V) of each part of the layers; 0 if there is none.

        The error of a sum over parts that emit at their mean temperature falls with the square of their thickness.
        With J of two successive parts and their common mean J2, (4 J - J2) / 3 removes it (Richardson, Phil. Trans. R.
        Soc. A 226, 299, 1927). At most half of J is removed: where J varies more, hardly any light is emitted.
        """
        if len(edges) == 1:
            return np.zeros((1, self.wavenumber_cm1.size))
        of_parts = self._mean_sources(edges)
        pairs = np.repeat(self._mean_sources(edges[::2]), 2, axis=0)
        result: Array = np.maximum((4.0 * of_parts - pairs) / 3.0, 0.5 * of_parts)
        return result

    def _mean_sources(self, edges: tuple[float, ...]) -> Array:
        """Return the Planck radiance (N, V) of layers at their pressure-weighted mean temperature.

        For temperature linear and density exponential in height, this temperature is to first order the mean of the
        ends plus a twelfth of their difference times ln(p below / p above).
        """
        altitude = np.asarray(edges)
        temperature = self._profile.temperature_at(altitude)
        ratio = -np.diff(np.log(self._profile.pressure_at(altitude)))
        mean = 0.5 * (temperature[:-1] + temperature[1:]) - np.diff(temperature) * np.minimum(ratio, 6.0) / 12.0
        return np.stack(self._black_bodies(mean.tolist()))


def _ratio(forward: Array, depth: Array) -> Array:
    """Return the asymmetry of layers; 0 where hardly anything scatters."""
    some = depth > _DARK
    result: Array = np.where(some, forward, 0.0) / np.where(some, depth, 1.0)
    return result


def _fine_levels(profile: Profile) -> Array:
    """Return the levels of a profile, with more of them below the top, toward which they become closer.

    The transmittance of lines falls with about the root of what is crossed, so that most of what the highest layer
    sends to space comes from its top, where it may be hot: with six parts of equal height 3.4e-3 of the radiance near
    2.7 um, where air is opaque, were missing by night. Their error fell as slowly as the power -1.5 of their number,
    and levels that have as many shared it. Where the ends of parts grow with the square of their number it is smooth.
    """
    altitude = profile.altitude_m
    below = altitude[-1] - (altitude[-1] - altitude[-2]) * (np.arange(_TOP_LAYERS, 0, -1) / _TOP_LAYERS) ** 2
    return np.concatenate((altitude[:-2], below, altitude[-1:]))


def _coarse_levels(profile: Profile) -> Array:
    """Return profile levels without closely spaced ones between which temperature is nearly linear."""
    altitude, pressure, temperature = profile.altitude_m, profile.pressure_Pa, profile.temperature_K
    chosen = [0]
    for index in range(1, altitude.size - 1):
        last = chosen[-1]
        mass = (pressure[last] - pressure[index]) / pressure[0]
        ends = [last, index + 1]
        bent = temperature[last : index + 1] - np.interp(altitude[last : index + 1], altitude[ends], temperature[ends])
        thick = mass >= _COARSE_MASS or altitude[index] - altitude[last] >= _COARSE_STEP_M
        if thick or np.max(np.abs(bent)) * pressure[last] > _COARSE_K * pressure[0]:
            chosen.append(index)
    return altitude[[*chosen, altitude.size - 1]]
