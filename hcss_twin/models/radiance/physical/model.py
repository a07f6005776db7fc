"""Radiance models ``physical`` and ``physical-two-stream``: clouds that scatter many times over a rough, emissive sea.

For each column, :class:`~hcss_twin.models.radiance.physical.columns.SceneColumns` stacks air, clouds and sea,
:mod:`~hcss_twin.models.radiance.physical.tracing` follows rays from the sensor into them, and
:mod:`~hcss_twin.models.radiance.physical.closure` sums the reflections that remain.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, lru_cache, partial
from os.path import dirname
from typing import ClassVar

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.cached_method import cached_by_spectrum, weakly
from hcss_twin.core.one_thread import in_one_thread
from hcss_twin.core.result_cache import ArrayMemory
from hcss_twin.models.model_errors import from_table
from hcss_twin.models.parameters import PhysicalParameters
from hcss_twin.models.radiance.physical.air import Air
from hcss_twin.models.radiance.physical.cloud_slab import CloudSlab, LayerOptics, side_by_side
from hcss_twin.models.radiance.physical.columns import SceneColumns
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
from hcss_twin.models.radiance.physical.gathered_paths import MOST_VALUES as MOST_GATHERED
from hcss_twin.models.radiance.physical.gathered_paths import GatheredGas, Rehearsal, first_wavenumber, gathers
from hcss_twin.models.radiance.physical.numerics import Numerics, levels
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
from hcss_twin.models.radiance.physical.sunlight_in_air import received, scattered_above, seen_scattered, sun_share
from hcss_twin.models.radiance.physical.sunlight_mirrored import Mirror, sunlit_mirror, unlit_mirror
from hcss_twin.models.radiance.physical.tracing import Tracer
from hcss_twin.providers import CloudLayer, RadianceDeclaration, RadianceInputs, Sun, TransmittanceProvider, View

_MAX_SPECTRA, _MAX_SOLVED = 4, 1e7
"""Limits of solved clouds in memory: spectra, and values of a spectrum over all suns; at one wavenumber of one sun some
hundred times streams times azimuth modes between cloud and sea."""

VALUES_TOGETHER = 1024
"""Columns times wavenumbers computed together: larger arrays do not fit in the processor cache."""

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


class Physical:
    """Multiple-scattering model of sea, clouds and air that conserves energy exactly.

    At the sea and at each cloud face, emissivity is 1 minus reflection and transmission. Air attenuates and emits along
    whole composite paths, whose absorber amounts add. An isothermal enclosure therefore emits the Planck radiance in
    every direction, with any providers.

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
    model_errors = from_table(dirname(__file__), "physical")

    def __init__(self, inputs: RadianceInputs, parameters: PhysicalParameters) -> None:
        self._inputs = inputs
        self._parameters = parameters
        possible = levels(parameters, inputs.sunlight_steps)
        self._numerics = possible[min(inputs.numerical_level, len(possible) - 1)]
        self._gas: TransmittanceProvider = inputs.transmittance
        if inputs.transmittance.declares.legs == "to_space":
            self._gas = PowerLawGas(inputs.transmittance, inputs.profile)
        elif gathers(inputs.transmittance):
            self._gas = GatheredGas(inputs.transmittance)
        # The engine requests the same few spectra repeatedly, for one or several sun positions.
        self._scene = cached_by_spectrum(self._new_scene, maxsize=4)
        memory, sublayers = inputs.air_memory, self._numerics.sublayers
        layers = {} if memory is None else memory.small
        air = partial(Air, self._gas, inputs.profile, sublayers=sublayers, layers=layers, memory=memory)
        self._air = cached_by_spectrum(air, maxsize=2)
        self._shared_air = partial(air, kept_values=_KEPT_BETWEEN_VIEWS)
        self._unlit_sea = cached_by_spectrum(self._new_unlit_sea, maxsize=4)
        self._unlit_sea_modes = cached_by_spectrum(self._new_unlit_sea_modes, maxsize=2)
        self._optics = LayerOptics(inputs.optics)
        self._expected: tuple[Sun | None, ...] = ()
        self._expected_views: tuple[View, ...] = ()
        # Solved clouds are the most expensive: clear skies at other sun positions must not evict them.
        self._slab_solvers = cached_by_spectrum(self._slab_solvers_by_sun, maxsize=_MAX_SPECTRA)
        self.declares = RadianceDeclaration(
            depends_on=frozenset({"view_zenith", "sun_zenith", "relative_azimuth", "thickness"}),
            notes=_notes(parameters, self._numerics, inputs, self.closed_form),
            numerical_levels=len(possible),
        )

    @in_one_thread
    def clear(self, wavenumber_cm1: Array, sun: Sun | None) -> Mapping[str, Array]:
        """Return terms (V,) of a cloud-free column."""
        scene = self._scene(wavenumber_cm1, _above_horizon(sun))
        ((_, columns),) = self._gathered(scene, [([0], self._columns(scene, (), 1))])
        return self._terms(scene, columns)

    @in_one_thread
    def cloudy(self, wavenumber_cm1: Array, thickness_m: Array, sun: Sun | None) -> Mapping[str, Array]:
        """Return terms (N, V) of columns with layer thicknesses (N, L), not all 0 in any column.

        Raises
        ------
        ValueError
            If the thickness has another shape, is negative, or a column has no cloud.
        """
        layers = self._inputs.layers
        if thickness_m.ndim != 2 or thickness_m.shape[1] != len(layers):
            raise ValueError(f"thickness_m: shape {thickness_m.shape}; allowed (N, {len(layers)})")
        if np.any(thickness_m < 0) or not np.all(np.any(thickness_m > 0, axis=1)):
            raise ValueError("thickness_m: allowed >= 0, at least one layer > 0; use clear() without cloud")
        sun = _above_horizon(sun)
        scene = self._scene(wavenumber_cm1, sun)
        solvers, toward = self._solvers_together(wavenumber_cm1, sun), self._solvers_toward(wavenumber_cm1, sun)
        slabs = [self._slabs(solvers, toward, layer, thickness_m[:, i]) for i, layer in enumerate(layers)]
        results = {name: np.empty((thickness_m.shape[0], wavenumber_cm1.size)) for name in self.terms}
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
            Tracer(thin, self._parameters.closure_order).radiance()
            if modes is not None:
                sunlight_between(thin, first_wavenumber(modes[0], 1))
            if 2 * len(rehearsal.paths) * wavenumber.size > MOST_GATHERED:
                gas.learn(wavenumber, rehearsal.paths)
                yield from waiting
                waiting, rehearsal = [], Rehearsal(gas, scene.air)
        gas.learn(wavenumber, rehearsal.paths)
        yield from waiting

    def _new_scene(self, wavenumber: Array, sun: Sun | None) -> _Scene:
        inputs = self._inputs
        directions = self._directions(inputs.view, sun)
        irradiance = received(inputs, directions, wavenumber)
        most, closed_form, unlit = self._numerics.turned_modes, self.closed_form, self._unlit_sea_modes

        sea = sunlit(self._unlit_sea(wavenumber, directions.wind_azimuth), inputs.sea, wavenumber, directions)

        @cache
        def modes() -> tuple[ReflectionModes, Mirror] | None:  # stored in this object, so it must not refer to it
            if directions.sun is None or closed_form or most < 2:
                return None
            along, mirror = unlit(wavenumber)
            sea_inputs = inputs.sea, wavenumber, directions
            return sunlit_modes(along, *sea_inputs), sunlit_mirror(mirror, *sea_inputs, sea)

        scattered = scattered_above(inputs, directions, wavenumber)
        return _Scene(self._air(wavenumber), directions, sea, irradiance, modes, scattered)

    def _new_unlit_sea(self, wavenumber: Array, wind_azimuth: float) -> SeaSurface:
        directions = replace(self._sunless_directions(), wind_azimuth=wind_azimuth)
        return unlit_sea_surface(self._inputs.sea, wavenumber, directions)

    def _new_unlit_sea_modes(self, wavenumber: Array) -> tuple[ReflectionModes, Mirror]:
        sea_inputs, numerics = (self._inputs.sea, wavenumber, self._sunless_directions()), self._numerics
        return unlit_sea_modes(*sea_inputs, numerics.turned_modes), unlit_mirror(*sea_inputs, numerics.mirror_streams)

    def _sunless_directions(self) -> ColumnDirections:
        return self._directions(self._inputs.view, None)

    def expect(self, suns: Sequence[Sun | None]) -> None:
        """Solve clouds for these suns together, when they are needed for the first of them."""
        self._expected = tuple(dict.fromkeys(sun for sun in suns if _above_horizon(sun) is not None))

    def expect_views(self, views: Sequence[View]) -> None:
        """Solve clouds for these views together if there is one sun; models toward the others then find them."""
        self._expected_views = tuple(dict.fromkeys(views))
        memory = self._inputs.air_memory
        if memory is not None and memory.memory is None and self._gas is self._inputs.transmittance:
            # Models of one scene toward several views share its air; scenes of a sweep share its arrays instead.
            shared = cached_by_spectrum(self._shared_air, maxsize=2)
            self._air = memory.objects.setdefault(("air", self._numerics.sublayers), shared)

    def _solvers_toward(self, wavenumber: Array, sun: Sun | None) -> list[SlabSolver]:
        """Return the cloud solvers of the expected views that are solved with this one; none if it is solved alone."""
        views, solver = self._expected_views, self._slab_solvers(wavenumber)(sun)
        if self._inputs.view not in views or len(self._expected) > 1 or solver.solves_alone or self.closed_form:
            return []
        most = max(self._solved_in_memory(wavenumber) // 2, 1)  # beside what else is in the memory
        first = views.index(self._inputs.view) // most * most
        every = [self._directions(view, sun) for view in views]
        solver.views_at_once = tuple((float(directions.mu[VIEW]), directions.relative_azimuth) for directions in every)
        return [
            solver if view == self._inputs.view else self._new_slab_solver(wavenumber, sun, view)
            for view in views[first : first + most]
        ]

    def _directions(self, view: View, sun: Sun | None) -> ColumnDirections:
        return column_directions(view, sun, self._inputs.wind_from_deg, self._numerics.streams)

    def _solvers_together(self, wavenumber: Array, sun: Sun | None) -> list[SlabSolver]:
        """Return the cloud solver of a sun, followed by those that are solved with it."""
        by_sun = self._slab_solvers(wavenumber)
        solver = by_sun(sun)
        if sun not in self._expected or solver.solves_alone or self.closed_form:
            return [solver]
        most = self._solved_in_memory(wavenumber)
        first = self._expected.index(sun) // most * most
        others = self._expected[first : first + most]
        return [solver, *(by_sun(other) for other in others if other != sun)]

    def _solved_in_memory(self, wavenumber: Array) -> int:
        numerics = self._numerics
        return max(int(_MAX_SOLVED / (wavenumber.size * 100.0 * numerics.streams * numerics.turned_modes)), 1)

    def _slab_solvers_by_sun(self, wavenumber: Array) -> Callable[[Sun | None], SlabSolver]:
        """Return the cloud solvers for a sun position; solved clouds are kept for as many suns as fit in memory."""
        suns = self._solved_in_memory(wavenumber)
        return lru_cache(maxsize=suns)(partial(weakly(self._new_slab_solver), wavenumber))

    def _new_slab_solver(self, wavenumber: Array, sun: Sun | None, toward: View | None = None) -> SlabSolver:
        inputs = self._inputs
        directions = self._directions(inputs.view if toward is None else toward, sun)
        return SlabSolver(
            self._optics,
            self._numerics,
            wavenumber,
            directions,
            partial(sun_share, inputs, directions),  # not a method: this object keeps the solver
            self.closed_form,
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
            top = self._inputs.profile.temperature_at(tops)
            base = top
            if self._parameters.cloud_temperature == "profile":
                base = self._inputs.profile.temperature_at(np.maximum(tops - thickness, 0.0))
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
            sea_source=np.tile(black(self._inputs.sea_temperature_K), count),
            space=np.tile(black(space) if space > 0.0 else np.zeros_like(scene.received), count),
            received=np.tile(scene.received, count),
            scattered_sublayers=numerics.sublayers if steep else numerics.scattered_sublayers,
        )

    def _terms(self, scene: _Scene, columns: SceneColumns) -> dict[str, Array]:
        by_source = Tracer(columns, self._parameters.closure_order).radiance()
        by_source[AIR_SUN] += seen_scattered(columns, scene.scattered)
        modes = scene.modes() if columns.slabs else None
        if modes is not None:
            by_cloud, by_sea = sunlight_between(columns, *modes)
            # A truncated series of modes can make a dark part negative: by at most 0.4 % of the radiance, in 1 % of
            # columns and wavenumbers (docs/development/radiance.md).
            by_source[CLOUD_SUN] = np.maximum(by_source[CLOUD_SUN] + by_cloud, 0.0)
            by_source[SEA_SUN] = np.maximum(by_source[SEA_SUN] + by_sea, 0.0)
        # The truncated phase function is negative at some angles; behind opaque clouds a term may be, too.
        least = -_FAINT_SHARE * np.sum(by_source, axis=0)
        by_source[(by_source < 0.0) & (by_source > least)] = 0.0
        result = dict(zip(self.terms, by_source, strict=True))
        for name in self._parameters.leave_out:
            result[name] = np.zeros_like(result[name])
        return result


class PhysicalTwoStream(Physical):
    """As :class:`Physical`, but with delta-Eddington two-stream clouds and exact single scattering.

    Energy is still conserved, and an isothermal enclosure is still black. Errors of single layers against discrete
    ordinates are in docs/development/radiance.md: about 0.02 in emissivity and 15 percent in reflected sunlight.
    """

    closed_form = True
    model_errors = from_table(dirname(__file__), "physical-two-stream")


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


def _notes(
    parameters: PhysicalParameters, numerics: Numerics, inputs: RadianceInputs, closed_form: bool
) -> tuple[str, ...]:
    streams = f"{numerics.streams} streams, {numerics.sun_streams} for sunlight"
    notes = [f"physical radiance: {streams}, gas exact for {parameters.closure_order} changes"]
    if closed_form:
        notes.append("physical radiance: clouds by a two-stream closed form, see docs/development/radiance.md")
    if inputs.transmittance.declares.legs == "to_space":
        notes.append(
            "physical radiance: the atmosphere knows paths to space only; others by a power law fitted to them, "
            "a few percent off where light goes down and up again"
        )
    if parameters.leave_out:
        notes.append(f"terms left out by choice: {', '.join(parameters.leave_out)}")
    return tuple(notes)
