"""Planning of a scenario: build its providers, check its requests, and decide what a run computes."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import replace
from datetime import timedelta
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hcss_twin.core.arguments import checked
from hcss_twin.core.catalog import Catalog, SecludedCatalog
from hcss_twin.core.errors import Problem, ScenarioError
from hcss_twin.core.memory import naming_memory
from hcss_twin.core.one_thread import in_one_thread
from hcss_twin.core.result_cache import ResultCache
from hcss_twin.core.stages import stage
from hcss_twin.cube.variables import VariableSpec
from hcss_twin.plan.assemble import assemble
from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.builder import numbered
from hcss_twin.plan.clear_sky import EVEN_SKY, EVEN_VAPOUR, EvenSky
from hcss_twin.plan.combinations import NotComputed
from hcss_twin.plan.filled_in import FilledIn
from hcss_twin.plan.land import land_share
from hcss_twin.plan.lines_of_sight import SunTrack, detector_notes
from hcss_twin.plan.output import computed_variables, cube_variables, quantized, wants_radiance
from hcss_twin.plan.packing import packed_variables
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.point_effects import extremes_of, plan_point_effect
from hcss_twin.plan.rays import GridRays, Rays, planned_rays, require_one_view
from hcss_twin.plan.scene_analysis import analyse_scene, probe_last_frame, strictest
from hcss_twin.plan.section_effect import section_effects
from hcss_twin.plan.sensor import planned_sensor, require_instants
from hcss_twin.plan.sensor_geometry import examine_geometry
from hcss_twin.plan.sensor_margin import alone, with_margin
from hcss_twin.plan.sensor_stages import Stage
from hcss_twin.plan.slant_paths import SlantPaths, excluded_beside_shadows, slant_paths
from hcss_twin.plan.sunlight import SunFrames
from hcss_twin.plan.surroundings import air_unlike_sea
from hcss_twin.plan.waves import MEAN_SEA, resolve_waves
from hcss_twin.plan.waves import NOTE as WAVE_NOTE
from hcss_twin.providers import Sun, View
from hcss_twin.providers.registry.specs import Kind
from hcss_twin.scenario.scenario import Scenario
from hcss_twin.scenario.viewing import viewing_notes

if TYPE_CHECKING:
    from hcss_twin.core.arrays import Array
    from hcss_twin.plan.accuracy import RequestedAccuracy
    from hcss_twin.plan.air_by_place import SeveralAirs
    from hcss_twin.plan.cloud_tops import CloudTops
    from hcss_twin.plan.probes import Probed
    from hcss_twin.plan.scene_family import SceneFamily
    from hcss_twin.plan.surfaces import PlannedSurfaces

EARLIEST_YEAR, LATEST_YEAR = 1700, 2200
"""Years that a time axis can represent in nanoseconds, the resolution of cube readers."""

BETWEEN_DEG = 0.01
"""By how much the sun is taken to be lower than at known times, so that its paths between them stay in the room."""


@checked
@naming_memory()
@in_one_thread
def make_plan(
    scenario: Scenario | str | Path | dict[str, Any],
    *,
    keeps_results: bool = True,
    shelf: ResultCache | None = None,
    family: SceneFamily | None = None,
    rays: Callable[[Scenario, Catalog], Rays | None] = planned_rays,
) -> Plan:
    """Resolve a scenario and decide what to compute.

    Parameters
    ----------
    scenario : Scenario, str, Path or dict
        The scene and output to simulate, or what :meth:`Scenario.of` makes one from.
    keeps_results : bool
        Whether to use results of earlier runs in the user's cache, and store new ones there.
    shelf : ResultCache, optional
        Files and results of scenes planned earlier in this process.
    family : SceneFamily, optional
        Where the scene is one of many that are alike but for one input.
    rays : callable
        Makes the rays; by default those of the scenario's sections. None: a grid on the ground.

    Raises
    ------
    ScenarioError
        If a request cannot be met; names the field.
    ProviderError
        If a selected provider is broken.
    """
    scenario = Scenario.of(scenario)
    try:
        catalog = (Catalog if keeps_results else SecludedCatalog)(base=scenario.base)
        catalog.shelf = shelf or catalog.shelf
        again = partial(make_plan, keeps_results=keeps_results, shelf=catalog.shelf, family=family, rays=rays)
        alike = _but_seeds(scenario), keeps_results, family, rays
        with stage("planning"):
            (before, kept), catalog.shelf.latest = catalog.shelf.latest, (None, None)
            plan = (
                kept.drawn_as(scenario)
                if alike == before
                else _make_plan(scenario, catalog, family, rays(scenario, catalog))
            )
        plan = replace(plan, replan=again)
        if shelf is not None:  # a plan that its own shelf kept would stay in memory until garbage is collected
            shelf.latest = alike, plan
        return plan
    except ScenarioError as error:
        typed = [Problem(_key_of_instrument(scenario, each.field), each.message) for each in error.problems]
        raise ScenarioError(typed, scenario.origin) from error


def _but_seeds(scenario: Scenario) -> tuple[str, Path]:
    """Return what is equal for scenarios that differ in seeds alone."""
    values = json.loads(scenario.to_json())
    for section in (values, values.get("sensor", {})):
        section.pop("seed", None)
    return json.dumps(values), scenario.base


def _key_of_instrument(scenario: Scenario, field: str) -> str:
    """Return the key of the instrument from which a field followed; the messages about clouds name their own."""
    return field if field.startswith("clouds") else scenario.field_as_typed(field)


def _make_plan(scenario: Scenario, catalog: Catalog, family: SceneFamily | None, given: Rays | None) -> Plan:
    frames, image = scenario.frames, scenario.image
    if given is not None:
        require_one_view(scenario)
    times = (frames.first + np.arange(frames.count, dtype=np.float64)) * np.float64(frames.interval)
    track = _sun_track(scenario, float(times[-1]))
    zenith, azimuth, _ = track.positions(times)
    view = View(scenario.view.zenith, scenario.view.azimuth) if given is None else given.view
    assembled = partial(_assembled, scenario, catalog, family, given, times)
    assembly = assembled(slant_paths(scenario.slant, view, zenith, azimuth, given is None))
    size = image.rows, image.columns
    extent = (slice(0, size[0]), slice(0, size[1])) if image.window is None else image.window.slices(*size)
    if given is not None:
        extent = slice(0, given.image.rows), slice(0, given.image.columns)
    sensor = planned_sensor(scenario, assembly, catalog, extent)
    if sensor.asking and assembly.slant.shadows:  # there is room around the image for the sun at other instants, too
        lower, bearing, _ = track.positions(sensor.reached_s(times))
        assembly = assembled(slant_paths(scenario.slant, view, lower + BETWEEN_DEG, bearing, given is None))
    airs = _several_airs(given, assembly, (*times.tolist(), *sensor.reached_s(times).tolist()))
    for of_places in airs:
        assembly = of_places.at(assembly)
    suns = SunFrames(track, times, zenith, azimuth)
    texture, even_vapour = _texture(scenario, assembly, catalog, suns)
    assembly = replace(assembly, has_texture=texture.varies, even_vapour=even_vapour)
    beside_shadows = excluded_beside_shadows(assembly.model, assembly.own_suns)
    assembly = replace(assembly, slant=assembly.slant.beside("shadows", beside_shadows))
    probe_last_frame(assembly, float(times[-1]))
    doubts = examine_geometry(json.loads(scenario.to_json()), sensor.stages) if sensor.stages else ()
    probes = _probes(scenario, assembly, catalog, sensor.stages)
    if given is not None:
        assembly, suns = _with_own_suns(given, scenario, assembly, catalog, suns) or (assembly, suns)
    tops_at = _at_extreme_tops(assembly)
    effects = section_effects(scenario, catalog)
    at_corners = (scene for of_places in airs for scene in of_places.at_corners(assembly))
    scenes = [*tops_at, *extremes_of(assembly, effects), *at_corners]
    analyses = [analyse_scene(scenario, scene, catalog, suns) for scene in scenes]
    analysis = analyses[0] if len(analyses) == 1 else strictest(analyses[0], analyses)
    planned_surfaces: list[PlannedSurfaces] = []
    for surfaces in assembly.surfaces:
        from hcss_twin.plan.surfaces import extreme_states, merged, plan_surfaces  # not for scenes of sea alone

        states = [analyse_scene(scenario, assembly.over(state), catalog, suns) for state in extreme_states(surfaces)]
        analysis = merged(scenario, assembly, surfaces, analysis, states)
        resolved = analysis.resolves_waves
        wanted = computed_variables(scenario, assembly, resolved, cube_variables(scenario, assembly, resolved))
        accuracy = analysis.accuracy if wants_radiance(wanted) else None
        planned_surfaces.append(plan_surfaces(scenario, assembly, surfaces, accuracy))
    highest = suns.track.at(float(suns.time_s[np.argmin(suns.zenith_deg)]))
    sun = highest if highest.is_up else None
    tops = _cloud_tops(scenario, assembly, analysis.accuracy, sun, catalog)
    planned = tuple(plan_point_effect(scenario, assembly, effect, analysis.accuracy, sun) for effect in effects)
    by_place = tuple(of_places.planned(scenario, assembly, analysis.accuracy, sun) for of_places in airs)
    assembly = assembly.at_level(analysis.numerics.level).on_grid(analysis.spectral_grid.refinement)
    assembly = assembly.with_finer_sunlight(analysis.numerics.sunlight_steps)
    assembly = replace(assembly, slant=assembly.slant.without("shadows", analysis.faint_shadows))
    waves = resolve_waves(scenario, assembly) if analysis.resolves_waves else MEAN_SEA
    point_m = image.pixel_size / image.samples_per_pixel
    own_views = analysis.views.varies or assembly.slant.differs(assembly.layers, point_m)
    require_instants(sensor, assembly, float(times[0]), float(times[-1]))
    sensor = with_margin(sensor, assembly, waves.varies, own_views) if given is None else alone(sensor)
    rays = given
    if rays is None:
        rays = GridRays(assembly, image.samples_per_pixel, analysis.views.over(assembly))
    variables = quantized(cube_variables(scenario, assembly, waves.varies), scenario, analysis.accuracy)
    variables, unpacked = packed_variables(variables, scenario, assembly, analysis.accuracy, analysis.expected)
    computed = computed_variables(scenario, assembly, waves.varies, variables)
    variables = rays.variables(variables)
    land = 0.0 if assembly.surfaces else land_share(scenario, catalog, float(times[-1]))
    plan = Plan(
        scenario=scenario,
        catalog=catalog,
        assembly=assembly,
        bands=assembly.bands,
        spectral_grid=assembly.spectral_grid,
        layers=assembly.layers,
        view=assembly.view,
        grid=assembly.grid,
        samples_per_pixel=rays.samples_per_pixel,
        extent=extent,
        frame_times_s=times,
        sun_track=suns.track,
        sun_zenith_deg=zenith,
        sun_azimuth_deg=azimuth,
        variables=variables,
        computed=computed,
        accuracy=analysis.accuracy,
        omissions=analysis.omissions,
        filled_in=(*assembly.filled_in, *(FilledIn(*each) for each in rays.filled_in)),
        notes=(
            *_notes(scenario, assembly, computed, waves.varies, analysis.sunlight.matters(zenith)),
            *analysis.notes,
            *unpacked,
            *viewing_notes(scenario),
            *doubts,
            *(f"{probe.label} breaks a law, as it declares: {law}" for probe in probes for law in probe.expected),
            *_on_land(land),
            *rays.notes,
        ),
        waves=waves,
        sunlight=analysis.sunlight,
        sensor=sensor,
        views=analysis.views,
        numerics=analysis.numerics,
        grid_refinement=analysis.spectral_grid,
        surfaces=tuple(planned_surfaces),
        tops=tops,
        texture=texture,
        land_share=land,
        probes=probes,
        rays=rays,
        point_effects=planned,
        air_by_place=by_place,
    )
    rays.prepare(scenario, assembly, plan.needs_radiance)
    light = scenario.radiance
    if light.light in ("auto", "columns") and (light.light_profile, light.light_accuracy) == ("uniform", None):
        return plan
    from hcss_twin.plan.choose_light import with_light  # not for independent columns

    return with_light(plan)


def _assembled(
    scenario: Scenario,
    catalog: Catalog,
    family: SceneFamily | None,
    rays: Rays | None,
    times_s: Array,
    slant: SlantPaths,
) -> Assembly:
    """Return all providers of a scene, seen as a grid on the ground or by rays."""
    if rays is None:
        return assemble(scenario, catalog, slant, None, family)
    return replace(
        assemble(scenario, catalog, slant, rays.climate, family, rays.image),
        directions=rays.directions,
        samples_per_pixel=rays.samples_per_pixel,
        reach_m=rays.reach_m(float(times_s[0]), float(times_s[-1])),
    )


def _several_airs(rays: Rays | None, assembly: Assembly, times_s: Sequence[float]) -> tuple[SeveralAirs, ...]:
    """Return the air of all places that rays see, if it is not that of one place or of the rays."""
    if rays is None or rays.climate is not None or not assembly.air_over_field.varies:
        return ()
    from hcss_twin.plan.air_by_place import SeveralAirs  # not for grids on the ground

    return (SeveralAirs(assembly, rays, times_s),)


def _with_own_suns(
    rays: Rays, scenario: Scenario, assembly: Assembly, catalog: Catalog, suns: SunFrames
) -> tuple[Assembly, SunFrames] | None:
    from hcss_twin.plan.sunlit_directions import needs_own_suns, with_own_suns  # not for grids on the ground

    return with_own_suns(rays, scenario, assembly, suns) if needs_own_suns(scenario, assembly, catalog, suns) else None


def _at_extreme_tops(assembly: Assembly) -> list[Assembly]:
    """Return the scene, or those with the highest and with the lowest cloud tops."""
    if not assembly.tops_vary:
        return [assembly]
    from hcss_twin.plan.cloud_tops import extreme_tops  # not for layers with tops of their own

    return extreme_tops(assembly)


def _cloud_tops(
    scenario: Scenario, assembly: Assembly, accuracy: RequestedAccuracy, sun: Sun | None, catalog: Catalog
) -> tuple[CloudTops, ...]:
    if not assembly.tops_vary:
        return ()
    from hcss_twin.plan.cloud_tops import plan_tops

    return tuple(plan_tops(scenario, assembly, index, accuracy, sun, catalog) for index in assembly.hanging_layers)


def _texture(
    scenario: Scenario, assembly: Assembly, catalog: Catalog, suns: SunFrames
) -> tuple[EvenSky, NotComputed | None]:
    if scenario.sea.temperature_texture == scenario.atmosphere.water_vapour_texture == 0.0:
        return EVEN_SKY, EVEN_VAPOUR
    from hcss_twin.plan.texture import plan_texture  # not for scenes without texture

    radiance = wants_radiance(cube_variables(scenario, replace(assembly, has_texture=True), True))
    of_frames = [position for _, position in suns.extremes(assembly.view)] if radiance else []
    return plan_texture(scenario, assembly, catalog, of_frames[:1])


def _on_land(share: float) -> tuple[str, ...]:
    text = (
        f"{max(round(100.0 * share, 1), 0.1):g} % of the image is land (coastlines of Natural Earth), but the scene is "
        "sea everywhere; with [surfaces] land is land"
    )
    return (text,) if share > 0.0 else ()


def _probes(scenario: Scenario, assembly: Assembly, catalog: Catalog, stages: Sequence[Stage]) -> tuple[Probed, ...]:
    if all(entry.is_own for entry in (*assembly.entries.values(), *(stage.entry for stage in stages))):
        return ()
    from hcss_twin.plan.probes import probe_providers  # the laws are needed for plugins only

    radiance = wants_radiance(cube_variables(scenario, assembly, True))
    labels = (numbered(Kind.SENSORS, index, len(stages)) for index in range(len(stages)))
    of_stages = [(label, stage.built) for label, stage in zip(labels, stages, strict=True)]
    return probe_providers(assembly, catalog, radiance, of_stages).results


def _sun_track(scenario: Scenario, last_s: float) -> SunTrack:
    first, last = EARLIEST_YEAR, LATEST_YEAR
    try:
        end = scenario.time + timedelta(seconds=last_s)
    except OverflowError:
        end = None
    for field, moment in (("time", scenario.time), ("frames", end)):
        if moment is None or not first <= moment.year <= last:
            when = "beyond the calendar" if moment is None else f"in {moment.year}"
            raise ScenarioError([Problem(field, f"a frame lies {when}; allowed: the years {first} to {last}")])
    place = scenario.place
    return SunTrack(scenario.time, place.latitude, place.longitude, float(scenario.motion.platform_speed))


def _notes(
    scenario: Scenario, assembly: Assembly, variables: tuple[VariableSpec, ...], waves: bool, sunlight: bool
) -> tuple[str, ...]:
    """Notes on the limits of the providers that this scene uses."""
    radiance, names = wants_radiance(variables), {spec.name for spec in variables}
    narrow = assembly.unresolved_bands if radiance else ()
    of_providers = assembly.notes(
        air="cloud_top_temperature" in names,
        particles=radiance or "cloud_optical_thickness" in names,
        radiance=radiance,
        sunlight=sunlight,
    )
    centre: tuple[str, ...] = ()
    air, tops = assembly.air_over_field, "cloud_top_temperature" in names
    if air.varies and (assembly.elements or tops):
        centre = ("cloud_top_temperature, and the air before elements, are those of the profile at the image centre",)
    elif air.is_of_place and tops:
        centre = ("cloud_top_temperature is that of the profile at the image centre",)
    unlike = air_unlike_sea(assembly.profile, assembly.sea_temperature_K) if radiance else ()
    read_as = (f"band {band.name}: {band.read_as}" for band in assembly.bands if band.read_as)
    of_waves = (WAVE_NOTE,) if waves else ()
    return (*read_as, *narrow, *centre, *unlike, *of_providers, *of_waves, *detector_notes(scenario))
