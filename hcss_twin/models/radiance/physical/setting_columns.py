"""Columns of one setting: what those with the same view, sea, air and layers share, clear or cloudy, under any sun."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, lru_cache, partial

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.cached_method import cached_by_spectrum, weakly
from hcss_twin.core.result_cache import ArrayMemory
from hcss_twin.models.parameters import PhysicalParameters
from hcss_twin.models.radiance.physical.air import Air
from hcss_twin.models.radiance.physical.cloud_slab import CloudSlab, LayerOptics, side_by_side
from hcss_twin.models.radiance.physical.columns import SceneColumns
from hcss_twin.models.radiance.physical.directions import VIEW, ColumnDirections, column_directions
from hcss_twin.models.radiance.physical.gathered_paths import MOST_VALUES as MOST_GATHERED
from hcss_twin.models.radiance.physical.gathered_paths import GatheredGas, Rehearsal, first_wavenumber, gathers
from hcss_twin.models.radiance.physical.numerics import Numerics
from hcss_twin.models.radiance.physical.power_law_gas import PowerLawGas
from hcss_twin.models.radiance.physical.sea_surface import (
    ReflectionModes,
    SeaSurface,
    sunlit,
    sunlit_modes,
    unlit_sea_modes,
    unlit_sea_surface,
)
from hcss_twin.models.radiance.physical.slab_solver import SlabSolver
from hcss_twin.models.radiance.physical.sunlight_between import sunlight_between
from hcss_twin.models.radiance.physical.sunlight_in_air import received, scattered_in, seen_scattered, sun_share
from hcss_twin.models.radiance.physical.sunlight_mirrored import Mirror, blind_mirror, sunlit_mirror, unlit_mirror
from hcss_twin.models.radiance.physical.terms import AIR_SUN, CLOUD_SUN, SEA_SUN, TERMS
from hcss_twin.models.radiance.physical.tracing import Tracer
from hcss_twin.providers import CloudLayer, ColumnSetting, RadianceInputs, SeaModel, Sun, TransmittanceProvider, View

_MAX_SPECTRA, _MAX_SOLVED = 4, 2e7
"""Limits of solved clouds in memory: spectra, and values of a spectrum over all suns; at one wavenumber of one sun some
hundred times streams times azimuth modes between cloud and sea."""

_FEW_WAVENUMBERS, _FEW_SPECTRA = 64, 4
"""Wavenumbers up to which levels of one scene share their air, and the spectra of which it is kept."""

_MODES = 6
"""Spectra, views, seas or numbers of streams for which modes of the sea are kept, which levels of sunlight share."""

_MIRRORS = 6
"""Spectra, seas or numbers of streams for which reflection between streams is kept."""

VALUES_TOGETHER = 1024
"""Columns times wavenumbers computed together: larger arrays do not fit in the processor cache."""

_COLUMNS_AT_ONCE = 32
"""Columns whose clouds are in memory at once; more at few wavenumbers."""

_KEPT_BETWEEN_VIEWS = 2**18
"""Transmittances of legs in memory of an air that many views share: most legs are of one view."""

_FAINT_SHARE = 1e-5
"""Terms that are negative by less than this share of the total are 0."""

_STEEP_CM1 = 2500.0
"""Wavenumber from which on Planck's law is steep in temperature; by day sunlight outshines emission there."""


@dataclass(frozen=True)
class _Scene:
    """Properties that all columns share at given wavenumbers and one sun position.

    Attributes
    ----------
    air, directions, sea
        As in :class:`SceneColumns`.
    received : ndarray (V,)
        Solar irradiance on a horizontal plane outside the atmosphere, mu0 E0; 0 without a sun.
    modes : callable
        Returns the azimuth modes of the sea's BRDF along the streams, and along more of them, or None if they are
        negligible.
    scattered : callable
        Returns sunlight (V,) scattered once into the view by the air above an altitude, sr-1.
    """

    air: Air
    directions: ColumnDirections
    sea: SeaSurface
    received: Array
    modes: Callable[[], tuple[ReflectionModes, Mirror] | None]
    scattered: Callable[[float], Array]


class SettingColumns:
    """Columns of one setting, under any sun.

    Parameters
    ----------
    setting : ColumnSetting
        Its sun is not used.
    inputs : RadianceInputs
    parameters : PhysicalParameters
    numerics : Numerics
        Sizes of the solution.
    optics : LayerOptics
    closed_form : bool
        Whether clouds are solved by the two-stream closed form.

    Raises
    ------
    ProviderError
        If the emissivity and the BRDF of the sea model contradict each other.
    """

    def __init__(
        self,
        setting: ColumnSetting,
        inputs: RadianceInputs,
        parameters: PhysicalParameters,
        numerics: Numerics,
        optics: LayerOptics,
        closed_form: bool,
    ) -> None:
        self._setting, self._inputs, self._parameters = setting, inputs, parameters
        self._numerics, self._optics, self._closed_form = numerics, optics, closed_form
        self._gas: TransmittanceProvider = setting.transmittance
        if setting.transmittance.declares.legs == "to_space":
            self._gas = PowerLawGas(setting.transmittance, setting.profile)
        elif gathers(setting.transmittance):
            self._gas = GatheredGas(setting.transmittance)
        # The engine requests the same few spectra repeatedly, for one or several sun positions.
        self._scene = cached_by_spectrum(self._new_scene, maxsize=8)
        memory, sublayers = setting.air_memory, numerics.sublayers
        layers = {} if memory is None else memory.small
        air = partial(
            Air,
            self._gas,
            setting.profile,
            sublayers=sublayers,
            layers=layers,
            memory=memory,
            space_K=parameters.space_temperature,
        )
        self._air = cached_by_spectrum(air, maxsize=2)
        self._few_air = cached_by_spectrum(partial(air, memory=None), maxsize=_FEW_SPECTRA)
        if memory is not None and memory.memory is None and self._gas is setting.transmittance:
            of_scene = "few wavenumbers", sublayers, parameters.space_temperature
            self._few_air = memory.objects.setdefault(of_scene, self._few_air)
        self._shared_air = partial(air, kept_values=_KEPT_BETWEEN_VIEWS)
        in_air = scattered_in(setting.transmittance, setting.profile)
        self._scattered = in_air if memory is None else memory.objects.setdefault("scattered", in_air)
        # Settings share what of the sea depends neither on view nor on sun.
        mirror = cached_by_spectrum(blind_mirror, maxsize=_MIRRORS)
        self._blind_mirror = mirror if memory is None else memory.objects.setdefault("mirror", mirror)
        self._unlit_sea = cached_by_spectrum(self._new_unlit_sea, maxsize=8)
        modes = cached_by_spectrum(_unlit_modes, maxsize=_MODES)
        self._unlit_modes = modes if memory is None else memory.objects.setdefault("modes", modes)
        # Solved clouds are the most expensive: clear skies at other sun positions must not evict them.
        self._slab_solvers = cached_by_spectrum(self._slab_solvers_by_sun, maxsize=_MAX_SPECTRA)

    def terms(
        self,
        wavenumber_cm1: Array,
        thickness_m: Array,
        sun: Sun | None,
        suns: Sequence[Sun | None],
        views: Sequence[View],
        shares_air: bool = False,
    ) -> dict[str, Array]:
        """Return each term (N, V) of columns with layer thicknesses (N, L); 0 in all layers: clear sky.

        Parameters
        ----------
        suns, views : sequence
            Those for which columns of these thicknesses are asked for together, this one's among them.
        shares_air : bool
            Whether other settings, toward other views or over other seas, are asked for together.
        """
        sun, cloudy = _above_horizon(sun), np.any(thickness_m > 0.0, axis=1)
        if shares_air:
            self._share_air()
        result = {name: np.empty((thickness_m.shape[0], wavenumber_cm1.size)) for name in TERMS}
        if not np.all(cloudy):
            for name, values in self._clear(wavenumber_cm1, sun).items():
                result[name][~cloudy] = values
        if np.any(cloudy):
            rows = np.flatnonzero(cloudy)
            at_once = max(_COLUMNS_AT_ONCE, VALUES_TOGETHER // wavenumber_cm1.size)
            for some in (rows[first : first + at_once] for first in range(0, rows.size, at_once)):
                for name, values in self._cloudy(wavenumber_cm1, thickness_m[some], sun, suns, views).items():
                    result[name][some] = values
        return result

    def _clear(self, wavenumber_cm1: Array, sun: Sun | None) -> dict[str, Array]:
        """Return terms (V,) of the column without cloud."""
        # The closure asks the sea for its light toward streams; where it is traced, nothing sends it back down.
        scene = self._scene(wavenumber_cm1, sun, self._parameters.closure_order > 0)
        ((_, columns),) = self._gathered(scene, [([0], self._columns(scene, (), 1))])
        return self._terms(scene, columns)

    def _cloudy(
        self,
        wavenumber_cm1: Array,
        thickness_m: Array,
        sun: Sun | None,
        suns: Sequence[Sun | None],
        views: Sequence[View],
    ) -> dict[str, Array]:
        """Return terms (N, V) of columns that have cloud."""
        scene = self._scene(wavenumber_cm1, sun, False)
        if len(views) > len(suns):  # all views under one sun cost less than all suns toward one view
            suns = [sun]
        solvers = self._solvers_together(wavenumber_cm1, sun, suns)
        toward = self._solvers_toward(wavenumber_cm1, sun, suns, views)
        layers = self._setting.layers
        slabs = [self._slabs(solvers, toward, layer, thickness_m[:, i]) for i, layer in enumerate(layers)]
        results = {name: np.empty((thickness_m.shape[0], wavenumber_cm1.size)) for name in TERMS}
        together = max(VALUES_TOGETHER // wavenumber_cm1.size, 1)

        def batches() -> Iterator[tuple[list[int], SceneColumns]]:
            for order, rows in _rows_by_layers(thickness_m, slabs).items():
                for first in range(0, len(rows), together):
                    some = rows[first : first + together]
                    scene_slabs = tuple(
                        side_by_side([slabs[i][float(thickness_m[row, i])] for row in some]) for i in order
                    )
                    yield some, self._columns(scene, scene_slabs, len(some))

        for some, columns in self._gathered(scene, batches()):
            for name, values in self._terms(scene, columns).items():
                results[name][some] = values.reshape(len(some), -1)
        return results

    def _gathered(
        self, scene: _Scene, batches: Iterable[tuple[list[int], SceneColumns]]
    ) -> Iterator[tuple[list[int], SceneColumns]]:
        """Yield rows with their columns, after a slow gas has computed the paths of many columns in one call."""
        gas = self._gas
        if not isinstance(gas, GatheredGas):
            yield from batches
            return
        wavenumber = scene.air.wavenumber_cm1
        waiting, rehearsal = [], Rehearsal(gas, scene.air)
        for rows, columns in batches:
            waiting.append((rows, columns))
            thin, modes = rehearsal.columns(columns), scene.modes() if columns.slabs else None
            tracer = Tracer(thin, self._parameters.closure_order)
            tracer.radiance()
            if modes is not None:
                sunlight_between(thin, tracer.frozen, first_wavenumber(modes[0], 1))
            if 2 * len(rehearsal.paths) * wavenumber.size > MOST_GATHERED:
                gas.learn(wavenumber, rehearsal.paths)
                yield from waiting
                waiting, rehearsal = [], Rehearsal(gas, scene.air)
        gas.learn(wavenumber, rehearsal.paths)
        yield from waiting

    def _new_scene(self, wavenumber: Array, sun: Sun | None, view_only: bool) -> _Scene:
        setting, memory = self._setting, self._setting.air_memory
        directions = self._directions(setting.view, sun)
        irradiance = received(self._inputs.solar_irradiance, directions, wavenumber)
        numerics, closed_form = self._numerics, self._closed_form
        most, sunless = numerics.turned_modes, self._sunless_directions()
        blind = partial(self._blind_mirror, wavenumber, setting.sea, numerics.streams, numerics.mirror_streams)
        key = setting.sea, setting.view, self._inputs.wind_from_deg, numerics.streams, numerics.mirror_streams, most
        of_levels = self._unlit_modes

        surface = self._unlit_sea(wavenumber, directions.wind_azimuth, view_only)
        sea = sunlit(surface, setting.sea, wavenumber, directions)

        @cache
        def modes() -> tuple[ReflectionModes, Mirror] | None:  # stored in this object, so it must not refer to it
            if directions.sun is None or closed_form or most < 2:
                return None
            along, mirror = of_levels(wavenumber, _Unlit(key, sunless, blind))
            sea_inputs = setting.sea, wavenumber, directions
            return sunlit_modes(along, *sea_inputs), sunlit_mirror(mirror, *sea_inputs, sea)

        of_view = directions.zenith_deg[VIEW], directions.sun, directions.relative_azimuth
        scattered = self._scattered(wavenumber, *of_view)
        alone = memory is not None and memory.memory is not None
        air = self._air if alone or wavenumber.size > _FEW_WAVENUMBERS else self._few_air
        return _Scene(air(wavenumber), directions, sea, irradiance, modes, scattered)

    def _new_unlit_sea(self, wavenumber: Array, wind_azimuth: float, view_only: bool) -> SeaSurface:
        directions = replace(self._sunless_directions(), wind_azimuth=wind_azimuth)
        return unlit_sea_surface(self._setting.sea, wavenumber, directions, view_only=view_only)

    def _sunless_directions(self) -> ColumnDirections:
        return self._directions(self._setting.view, None)

    def _share_air(self) -> None:
        """Let columns of several views or seas share the air of one scene; scenes of a sweep share its arrays."""
        memory = self._setting.air_memory
        if memory is not None and memory.memory is None and self._gas is self._setting.transmittance:
            shared = cached_by_spectrum(self._shared_air, maxsize=2)
            self._air = memory.objects.setdefault(
                ("air", self._numerics.sublayers, self._parameters.space_temperature), shared
            )

    def _solvers_toward(
        self, wavenumber: Array, sun: Sun | None, suns: Sequence[Sun | None], views: Sequence[View]
    ) -> list[SlabSolver]:
        """Return the cloud solvers of the views that are solved with this one; none if it is solved alone."""
        solver = self._slab_solvers(wavenumber)(sun)
        if len(views) < 2 or len(suns) > 1 or solver.solves_alone or self._closed_form:
            return []
        most = max(self._solved_in_memory(wavenumber) // 4, 1)  # beside what else is in the memory
        first = views.index(self._setting.view) // most * most
        every = [self._directions(view, sun) for view in views]
        solver.views_at_once = tuple((float(directions.mu[VIEW]), directions.relative_azimuth) for directions in every)
        return [
            solver if view == self._setting.view else self._new_slab_solver(wavenumber, sun, view)
            for view in views[first : first + most]
        ]

    def _directions(self, view: View, sun: Sun | None) -> ColumnDirections:
        return column_directions(view, sun, self._inputs.wind_from_deg, self._numerics.streams)

    def _solvers_together(self, wavenumber: Array, sun: Sun | None, suns: Sequence[Sun | None]) -> list[SlabSolver]:
        """Return the cloud solver of a sun, followed by those that are solved with it."""
        by_sun, lit = self._slab_solvers(wavenumber), [other for other in suns if _above_horizon(other) is not None]
        solver = by_sun(sun)
        if len(lit) < 2 or sun not in lit or solver.solves_alone or self._closed_form:
            return [solver]
        most = self._solved_in_memory(wavenumber)
        first = lit.index(sun) // most * most
        return [solver, *(by_sun(other) for other in lit[first : first + most] if other != sun)]

    def _solved_in_memory(self, wavenumber: Array) -> int:
        numerics = self._numerics
        return max(int(_MAX_SOLVED / (wavenumber.size * 100.0 * numerics.streams * numerics.turned_modes)), 1)

    def _slab_solvers_by_sun(self, wavenumber: Array) -> Callable[[Sun | None], SlabSolver]:
        """Return the cloud solvers for a sun position; solved clouds are kept for as many suns as fit in memory."""
        suns = self._solved_in_memory(wavenumber)
        return lru_cache(maxsize=suns)(partial(weakly(self._new_slab_solver), wavenumber))

    def _new_slab_solver(self, wavenumber: Array, sun: Sun | None, toward: View | None = None) -> SlabSolver:
        inputs = self._inputs
        directions, sea_K = self._directions(toward or self._setting.view, sun), self._setting.sea_temperature_K
        return SlabSolver(
            self._optics,
            self._numerics,
            wavenumber,
            directions,
            partial(
                sun_share, inputs.solar_irradiance, sea_K, directions
            ),  # not a method: this object keeps the solver
            self._closed_form,
            len(self._setting.layers) > 1,
            inputs.memory or ArrayMemory(),
        )

    def _slabs(
        self, solvers: Sequence[SlabSolver], toward: Sequence[SlabSolver], layer: CloudLayer, thickness_m: Array
    ) -> dict[float, CloudSlab]:
        """Return solved layers by thickness, of the first solver."""
        thickness = np.unique(thickness_m[thickness_m > 0.0])
        if not thickness.size:
            return {}
        tops = layer.cloud_top_m(thickness)
        if layer.temperature_K is not None:
            top = base = np.full_like(thickness, layer.temperature_K)
        else:
            top = self._setting.profile.temperature_at(tops)
            base = top
            if self._parameters.cloud_temperature == "profile":
                base = self._setting.profile.temperature_at(np.maximum(tops - thickness, 0.0))
        solved = solvers[0].solve(layer, thickness, top, base, solvers, toward)
        return {float(h): slab for h, slab in zip(thickness, solved, strict=True)}

    def _columns(self, scene: _Scene, slabs: tuple[CloudSlab, ...], count: int) -> SceneColumns:
        space = self._parameters.space_temperature
        black, numerics = scene.air.black_body, self._numerics
        steep = scene.directions.sun is None and float(np.max(scene.air.wavenumber_cm1)) > _STEEP_CM1
        return SceneColumns(
            count=count,
            air=scene.air,
            directions=scene.directions,
            slabs=slabs,
            sea=scene.sea.repeated(count),
            sea_source=np.tile(black(self._setting.sea_temperature_K), count),
            space=np.tile(black(space) if space > 0.0 else np.zeros_like(scene.received), count),
            received=np.tile(scene.received, count),
            scattered_sublayers=numerics.steep_sublayers if steep else numerics.scattered_sublayers,
        )

    def _terms(self, scene: _Scene, columns: SceneColumns) -> dict[str, Array]:
        tracer = Tracer(columns, self._parameters.closure_order)
        by_source = tracer.radiance()
        by_source[AIR_SUN] += seen_scattered(columns, scene.scattered)
        modes = scene.modes() if columns.slabs else None
        if modes is not None:
            by_cloud, by_sea = sunlight_between(columns, tracer.frozen, *modes)
            # A truncated series of modes can make a dark part negative: by at most 0.4 % of the radiance, in 1 % of
            # columns and wavenumbers (docs/development/radiance.md).
            by_source[CLOUD_SUN] = np.maximum(by_source[CLOUD_SUN] + by_cloud, 0.0)
            by_source[SEA_SUN] = np.maximum(by_source[SEA_SUN] + by_sea, 0.0)
        # The truncated phase function is negative at some angles; behind opaque clouds a term may be, too.
        least = -_FAINT_SHARE * np.sum(by_source, axis=0)
        by_source[(by_source < 0.0) & (by_source > least)] = 0.0
        result = dict(zip(TERMS, by_source, strict=True))
        for name in self._parameters.leave_out:
            result[name] = np.zeros_like(result[name])
        return result


@dataclass(frozen=True)
class _Unlit:
    """What the modes of a sea without a sun depend on beside wavenumbers, as ``key``, and how they are made."""

    key: tuple[SeaModel, View, float, int, int, int]
    directions: ColumnDirections = field(compare=False)
    mirror: Callable[[], Mirror] = field(compare=False)


def _unlit_modes(wavenumber_cm1: Array, of: _Unlit) -> tuple[ReflectionModes, Mirror]:
    sea, *_, modes = of.key
    inputs = sea, wavenumber_cm1, of.directions
    return unlit_sea_modes(*inputs, modes), unlit_mirror(of.mirror(), *inputs)


def _above_horizon(sun: Sun | None) -> Sun | None:
    return sun if sun is not None and sun.is_up else None


def _rows_by_layers(thickness_m: Array, slabs: list[dict[float, CloudSlab]]) -> dict[tuple[int, ...], list[int]]:
    """Return rows of thickness (N, L) by the layers they have, from the highest to the lowest."""
    rows: dict[tuple[int, ...], list[int]] = {}
    for row, thickness in enumerate(thickness_m.tolist()):
        present = [layer for layer, h in enumerate(thickness) if h > 0.0]
        present.sort(key=lambda layer: slabs[layer][thickness[layer]].base_m, reverse=True)
        rows.setdefault(tuple(present), []).append(row)
    return rows
