"""One thread for products of matrices.

Those of this model are so small that several threads wait for each other longer than they compute, above all where
other programs use the processors, too; and in another number of threads the last bits of a product are others.

Radiance model ``physical``: clouds that scatter many times over a rough, emissive sea.

Radiance model ``physical-two-stream``: the laws of ``physical`` with clouds in closed form.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from functools import cache, lru_cache, partial, wraps
from typing import Any, ClassVar, ParamSpec, TypeVar

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.models.parameters import PhysicalParameters
from hcss_twin.models.radiance.physical.air import Air
from hcss_twin.models.radiance.physical.cloud_slab import CloudSlab, SlabMaker, stacked, turned_modes
from hcss_twin.models.radiance.physical.columns import CloudColumns
from hcss_twin.models.radiance.physical.directions import (
    AIR_SUN,
    CLOUD_SUN,
    SEA_SUN,
    SEA_SUN_TERMS,
    SOLAR_TERMS,
    TERMS,
    VIEW,
    ColumnDirections,
    column_directions,
)
from hcss_twin.models.radiance.physical.power_law_gas import PowerLawGas
from hcss_twin.models.radiance.physical.sea_surface import SeaSurface, sunlit, unlit_sea_surface
from hcss_twin.models.radiance.physical.tracing import Tracer
from hcss_twin.models.radiance.physical.turned_glint import SeaModes, sunlit_modes, turned_glint, unlit_sea_modes
from hcss_twin.physics.geometry import sun_zenith_along
from hcss_twin.physics.paths import to_space
from hcss_twin.providers import CloudLayer, Declares, RadianceInputs, Sun, TransmittanceProvider

_P = ParamSpec("_P")
_T = TypeVar("_T")


def in_one_thread(function: Callable[_P, _T]) -> Callable[_P, _T]:
    """Have the process multiply matrices in one thread while a function runs; loops of our own keep theirs.

    Functions that several threads call take turns. It holds for libraries that numpy and scipy have loaded when such a
    function runs first.
    """

    @wraps(function)
    def limited(*args: _P.args, **kwargs: _P.kwargs) -> _T:
        # The number belongs to the process: the first of two threads to end would give it back under the other.
        with _turn(), _libraries().limit(limits=1, user_api="blas"):
            return function(*args, **kwargs)

    return limited


@cache
def _turn() -> AbstractContextManager[bool]:
    return threading.RLock()


@cache
def _libraries() -> Any:
    """Find the libraries: some milliseconds, once."""
    # imported here: runs that find their tables should not wait for it
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()


MEASURED_STREAMS, MEASURED_MODES = 8, 16
"""For which, and for more, the model says what its own error is."""

_KEPT_GRIDS, _KEPT_WAVENUMBERS = 4, 512
"""Sets of wavenumbers, and how many of these over all suns, whose solved clouds are kept: some 70 kB each."""

_VALUES_TOGETHER = 1024
"""Columns times wavenumbers that are computed together: arrays of more do not stay in the processor's cache."""

_LARGEST_SUN_DEG = 88.0
"""Zenith angle from which sunlight scattered in the air is left out: paths to the sun graze the Earth."""

_EARTH_RADIUS_M = 6356752.0
"""The smallest, of the poles: providers with a larger one see the sun no lower."""


@dataclass(frozen=True)
class _Shared:
    """What all columns have in common at some wavenumbers and for one position of the sun.

    ``scattered`` gives the sunlight (V,) that the air scatters once into the view from above an altitude, sr-1.
    """

    air: Air
    directions: ColumnDirections
    sea: SeaSurface
    received: Array
    modes: Callable[[], SeaModes | None]
    scattered: Callable[[float], Array]


class Physical:
    """Sea, clouds and air whose emission, reflection and transmission sum to one everywhere.

    Emissivity is what reflection and transmission leave over, at the sea and at each face of each cloud. Air
    weakens and emits along whole composite paths, whose absorber amounts add. An isothermal enclosure therefore sends
    Planck's radiance in every direction, with any providers.

    Parameters
    ----------
    inputs : RadianceInputs
        Any number of cloud layers that do not overlap.
    parameters : PhysicalParameters
        Accuracy, and terms to leave out.

    Raises
    ------
    ProviderError
        If the emissivity and the BRDF of the sea model contradict each other.
    """

    terms: Mapping[str, str] = TERMS
    solar_terms = SOLAR_TERMS
    sea_sun_terms = SEA_SUN_TERMS
    closed_form: ClassVar[bool] = False
    """Whether clouds are solved by the two-stream closed form."""

    def __init__(self, inputs: RadianceInputs, parameters: PhysicalParameters) -> None:
        self._inputs = inputs
        self._parameters = parameters
        self._gas: TransmittanceProvider = inputs.transmittance
        if inputs.transmittance.declares.legs == "to_space":
            self._gas = PowerLawGas(inputs.transmittance, inputs.profile)
        self._scene = lru_cache(maxsize=4)(self._make_scene)
        # Solved clouds cost most; clear skies under other suns must not push them out.
        self._makers = lru_cache(maxsize=_KEPT_GRIDS)(self._makers_of)
        self._air = lru_cache(maxsize=2)(self._make_air)
        self._sea = lru_cache(maxsize=4)(self._make_sea)
        self._sea_modes = lru_cache(maxsize=2)(self._make_sea_modes)
        self.declares = Declares(
            depends_on=frozenset({"view_zenith", "sun_zenith", "relative_azimuth", "thickness"}),
            notes=_notes(parameters, inputs, self.closed_form),
            own_errors=_own_errors(parameters, self.closed_form),
        )

    @in_one_thread
    def clear(self, wavenumber_cm1: Array, sun: Sun | None) -> Mapping[str, Array]:
        """Return terms (V,) of a cloud-free column."""
        shared = self._shared(wavenumber_cm1, sun)
        return self._terms(shared, self._columns(shared, (), 1))

    @in_one_thread
    def cloudy(self, wavenumber_cm1: Array, thickness_m: Array, sun: Sun | None) -> Mapping[str, Array]:
        """Return terms (N, V) of columns with a thickness (N, L) of each layer, none all 0.

        Raises
        ------
        ValueError
            If the thickness has another shape, is negative, or a column has no cloud.
        """
        layers = self._inputs.layers
        if thickness_m.ndim != 2 or thickness_m.shape[1] != len(layers):
            raise ValueError(f"thickness_m: shape {thickness_m.shape}; allowed (N, {len(layers)})")
        if np.any(thickness_m < 0) or not np.all(np.any(thickness_m > 0, axis=1)):
            raise ValueError("thickness_m: allowed 0 or more, and a layer > 0; a column without cloud is clear()")
        shared = self._shared(wavenumber_cm1, sun)
        maker = self._makers(wavenumber_cm1.tobytes())(sun if sun is not None and sun.is_up else None)
        slabs = [self._slabs(maker, layer, thickness_m[:, i]) for i, layer in enumerate(layers)]
        results = {name: np.empty((thickness_m.shape[0], wavenumber_cm1.size)) for name in self.terms}
        together = max(_VALUES_TOGETHER // wavenumber_cm1.size, 1)
        for order, rows in _with_the_same_layers(thickness_m, slabs).items():
            for first in range(0, len(rows), together):
                some = rows[first : first + together]
                own = tuple(stacked([slabs[i][float(thickness_m[row, i])] for row in some]) for i in order)
                found = self._terms(shared, self._columns(shared, own, len(some)))
                for name, values in found.items():
                    results[name][some] = values.reshape(len(some), -1)
        return results

    def _shared(self, wavenumber_cm1: Array, sun: Sun | None) -> _Shared:
        return self._scene(wavenumber_cm1.tobytes(), sun if sun is not None and sun.is_up else None)

    def _make_scene(self, wavenumbers: bytes, sun: Sun | None) -> _Shared:
        wavenumber = np.frombuffer(wavenumbers, dtype=np.float64)
        inputs = self._inputs
        directions = column_directions(inputs.view, sun, inputs.wind_from_deg, self._parameters.streams)
        air = self._air(wavenumbers)
        received = np.zeros_like(wavenumber)
        if directions.sun is not None:
            irradiance = inputs.solar_irradiance(wavenumber)
            received = directions.mu_sun * irradiance / directions.sun.distance_au**2
        most = turned_modes(self._parameters)

        @cache
        def modes() -> SeaModes | None:
            if directions.sun is None or self.closed_form or most < 2:
                return None
            return sunlit_modes(self._sea_modes(wavenumbers), inputs.sea, wavenumber, directions)

        unlit = self._sea(wavenumbers, directions.wind_azimuth)
        sea = sunlit(unlit, inputs.sea, wavenumber, directions)
        return _Shared(air, directions, sea, received, modes, self._scattered_in_air(wavenumber, directions))

    def _makers_of(self, wavenumbers: bytes) -> Callable[[Sun | None], SlabMaker]:
        """Return what makes clouds by the sun, and keeps as many of them as there is room for."""
        count = len(wavenumbers) // np.dtype(np.float64).itemsize
        suns = max(_KEPT_WAVENUMBERS // count, 1)
        return lru_cache(maxsize=suns)(partial(self._make_maker, wavenumbers))

    def _make_maker(self, wavenumbers: bytes, sun: Sun | None) -> SlabMaker:
        shared, inputs = self._scene(wavenumbers, sun), self._inputs
        return SlabMaker(
            inputs.optics,
            self._parameters,
            np.frombuffer(wavenumbers, dtype=np.float64),
            shared.directions,
            shared.received / (np.pi * shared.air.black_body(inputs.sea_temperature_K)),
            self.closed_form,
        )

    def _scattered_in_air(self, wavenumber: Array, where: ColumnDirections) -> Callable[[float], Array]:
        """Sunlight (V,) scattered once into the view above an altitude, sr-1, where the provider knows it; else 0."""
        own, sun = getattr(self._inputs.transmittance, "solar_path_radiance", None), where.sun
        if own is None or sun is None or self._sun_is_too_low(sun, where):
            return lambda altitude_m: np.zeros_like(wavenumber)
        view, azimuth_deg = where.zenith_deg[VIEW], float(np.degrees(where.relative_azimuth))

        @cache
        def above(altitude_m: float) -> Array:
            found: Array = own(wavenumber, [to_space(altitude_m, view)], sun.zenith_deg, azimuth_deg)[0]
            return found

        return above

    def _make_sea_modes(self, wavenumbers: bytes) -> SeaModes:
        inputs, wavenumber = self._inputs, np.frombuffer(wavenumbers, dtype=np.float64)
        directions = column_directions(inputs.view, None, inputs.wind_from_deg, self._parameters.streams)
        return unlit_sea_modes(inputs.sea, wavenumber, directions, turned_modes(self._parameters))

    def _make_sea(self, wavenumbers: bytes, wind_azimuth: float) -> SeaSurface:
        inputs, wavenumber = self._inputs, np.frombuffer(wavenumbers, dtype=np.float64)
        directions = column_directions(inputs.view, None, inputs.wind_from_deg, self._parameters.streams)
        return unlit_sea_surface(inputs.sea, wavenumber, replace(directions, wind_azimuth=wind_azimuth))

    def _make_air(self, wavenumbers: bytes) -> Air:
        return Air(self._gas, self._inputs.profile, np.frombuffer(wavenumbers, dtype=np.float64))

    def _slabs(self, maker: SlabMaker, layer: CloudLayer, thickness_m: Array) -> dict[float, CloudSlab]:
        """Solved layers by thickness."""
        thickness = np.unique(thickness_m[thickness_m > 0.0])
        if not thickness.size:
            return {}
        tops = layer.cloud_top_m(thickness)
        if layer.temperature_K is not None:
            top = base = np.full_like(thickness, layer.temperature_K)
        else:
            top = self._inputs.profile.temperature_at(tops)
            base = top
            if self._parameters.cloud_temperature == "profile":
                base = self._inputs.profile.temperature_at(np.maximum(tops - thickness, 0.0))
        made = maker.make(layer, thickness, top, base)
        return {float(h): slab for h, slab in zip(thickness, made, strict=True)}

    def _columns(self, shared: _Shared, slabs: tuple[CloudSlab, ...], count: int) -> CloudColumns:
        space = self._parameters.space_temperature
        black = shared.air.black_body
        return CloudColumns(
            count=count,
            air=shared.air,
            directions=shared.directions,
            slabs=slabs,
            sea=shared.sea.repeated(count),
            sea_source=np.tile(black(self._inputs.sea_temperature_K), count),
            space=np.tile(black(space) if space > 0.0 else np.zeros_like(shared.received), count),
            received=np.tile(shared.received, count),
        )

    def _terms(self, shared: _Shared, columns: CloudColumns) -> dict[str, Array]:
        found = Tracer(columns, self._parameters.closure_order).radiance()
        found[AIR_SUN] += _seen_scattered(columns, shared.scattered)
        modes = shared.modes() if len(columns.slabs) == 1 else None
        if modes is not None:
            by_cloud, by_sea = turned_glint(columns, modes.repeated(columns.count))
            # Fewer modes than the light has make a dark part darker than nothing: by at most .4 % of the radiance, in
            # 1 % of columns and wavenumbers (docs/physical.md).
            found[CLOUD_SUN] = np.maximum(found[CLOUD_SUN] + by_cloud, 0.0)
            found[SEA_SUN] = np.maximum(found[SEA_SUN] + by_sea, 0.0)
        result = dict(zip(self.terms, found, strict=True))
        for name in self._parameters.leave_out:
            result[name] = np.zeros_like(result[name])
        return result

    def _sun_is_too_low(self, sun: Sun, where: ColumnDirections) -> bool:
        """Whether it is near the horizon of any point between sea and sensor: slant paths reach far."""
        top_m = float(self._inputs.profile.altitude_m[-1])
        highest = sun_zenith_along(
            where.zenith_deg[VIEW], sun.zenith_deg, where.relative_azimuth, top_m, _EARTH_RADIUS_M
        )
        return max(sun.zenith_deg, highest) > _LARGEST_SUN_DEG


def _with_the_same_layers(thickness_m: Array, slabs: list[dict[float, CloudSlab]]) -> dict[tuple[int, ...], list[int]]:
    """Return rows of thickness (N, L) by the layers they have, from the highest to the lowest."""
    found: dict[tuple[int, ...], list[int]] = {}
    for row, thickness in enumerate(thickness_m.tolist()):
        present = [layer for layer, h in enumerate(thickness) if h > 0.0]
        present.sort(key=lambda layer: slabs[layer][thickness[layer]].base_m, reverse=True)
        found.setdefault(tuple(present), []).append(row)
    return found


def _seen_scattered(columns: CloudColumns, scattered: Callable[[float], Array]) -> Array:
    """Sunlight (S,) scattered once into the view; what the air below a cloud scatters passes it directly, twice."""
    result = np.zeros_like(columns.received)
    if columns.directions.sun is None:
        return result
    lower = [*(slab.top_m for slab in columns.slabs), columns.sea_level_m]
    above = np.stack([np.concatenate([scattered(altitude) for altitude in heights]) for heights in lower])
    through = np.ones_like(result)
    for index, between in enumerate(np.diff(above, axis=0, prepend=0.0)):
        result += through * np.maximum(between, 0.0)
        if index < len(columns.slabs):
            slab = columns.slabs[index]
            through = through * slab.direct[VIEW] * slab.sun_direct
    return result * columns.received / columns.directions.mu_sun


def _own_errors(parameters: PhysicalParameters, closed_form: bool) -> tuple[str, ...]:
    """Of the numbers of streams whose errors were measured (docs/multiple-scattering.md, docs/physical.md)."""
    if closed_form:
        return ("physical radiance: clouds in closed form, some 15 % off in reflected sunlight",)
    found = []
    if parameters.streams >= MEASURED_STREAMS:
        found.append(
            "physical radiance: emission of clouds within 0.001 in emissivity to 75 deg, of 64 streams in discrete "
            "ordinates"
        )
    if parameters.sun_streams >= MEASURED_STREAMS and parameters.azimuth_modes >= MEASURED_MODES:
        found.append(
            "physical radiance: sunlight reflected by clouds within 2 % of its maximum in 95 % of random layers to 75 "
            "deg, of 64 streams in discrete ordinates"
        )
    return tuple(found)


def _notes(parameters: PhysicalParameters, inputs: RadianceInputs, closed_form: bool) -> tuple[str, ...]:
    notes = [f"physical radiance: {parameters.streams} streams, gas exact for {parameters.closure_order} changes"]
    if closed_form:
        notes.append("physical radiance: clouds by a two-stream closed form, see docs/multiple-scattering.md")
    if inputs.transmittance.declares.legs == "to_space":
        notes.append(
            "physical radiance: the atmosphere knows paths to space only; others by a power law fitted to them, "
            "a few percent off where light goes down and up again"
        )
    if parameters.leave_out:
        notes.append(f"terms left out by choice: {', '.join(parameters.leave_out)}")
    return tuple(notes)


class PhysicalTwoStream(Physical):
    """As :class:`Physical`, with each cloud layer by a delta-Eddington two-stream solution and exact single scattering.

    Energy is conserved and an isothermal enclosure is black all the same. Errors of single layers against discrete
    ordinates are in docs/multiple-scattering.md: emissivity by some 0.02, reflected sunlight by some 15 percent.
    """

    closed_form = True
