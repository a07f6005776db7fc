"""Make the plan of a scenario: resolve and check what it asks for, and decide what it needs."""

from __future__ import annotations

from dataclasses import replace
from datetime import timedelta

import numpy as np

from hcss_twin.core.catalog import Catalog, SecludedCatalog
from hcss_twin.core.errors import Problem, ScenarioError
from hcss_twin.core.result_cache import ResultCache
from hcss_twin.plan.assembly import assemble
from hcss_twin.plan.kept_findings import keep_findings, kept_findings
from hcss_twin.plan.lines_of_sight import SunTrack
from hcss_twin.plan.output import cube_variables, quantized
from hcss_twin.plan.plan import Plan, extent_of
from hcss_twin.plan.scene_analysis import analyse_scene, probe_last_frame
from hcss_twin.plan.sensor import planned_sensor
from hcss_twin.plan.sensor_margin import with_margin
from hcss_twin.plan.slant_paths import require_sea_sun_terms, slant_paths
from hcss_twin.plan.sunlight import SunFrames
from hcss_twin.providers import View
from hcss_twin.scenario.scenario import Scenario

EARLIEST_YEAR, LATEST_YEAR = 1700, 2200
"""Years the time axis of a cube can hold in nanoseconds, as its readers want it."""


def make_plan(scenario: Scenario, *, keeps_results: bool = True, shelf: ResultCache | None = None) -> Plan:
    """Resolve a scenario and decide what it needs.

    Parameters
    ----------
    scenario : Scenario
        What to simulate.
    keeps_results : bool
        Whether cloud optics computed for it, and what the plan finds out, may be kept for later runs, and taken from
        earlier ones.
    shelf : ResultCache, optional
        What scenes planned before in this process read already.

    Raises
    ------
    ScenarioError
        If what the scenario asks for cannot be had, naming the field.
    ProviderError
        If a selected provider is broken.
    """
    if not isinstance(scenario, Scenario):
        raise TypeError(f"a Scenario is needed, not {scenario!r}; Scenario.load reads names and files")
    try:
        catalog = (Catalog if keeps_results else SecludedCatalog)(base=scenario.base)
        catalog.shelf = shelf or catalog.shelf
        return _make_plan(scenario, catalog)
    except ScenarioError as error:
        raise ScenarioError(error.problems, scenario.origin) from error


def _make_plan(scenario: Scenario, catalog: Catalog) -> Plan:
    frames = scenario.frames
    times = (frames.first + np.arange(frames.count, dtype=np.float64)) * np.float64(frames.interval)
    track = _sun_track(scenario, float(times[-1]))
    zenith, azimuth, _ = track.positions(times)
    slant = slant_paths(scenario.slant, View(scenario.view.zenith, scenario.view.azimuth), zenith, azimuth)
    assembly = assemble(scenario, catalog, slant)
    if scenario.slant.shadows:
        require_sea_sun_terms(assembly.model)
    probe_last_frame(assembly, float(times[-1]))
    sensor = planned_sensor(scenario, assembly, catalog, extent_of(scenario))
    findings = kept_findings(scenario, assembly, catalog)
    waves = None
    if findings is None:
        before = catalog.used
        findings, waves = analyse_scene(scenario, assembly, SunFrames(track, times, zenith, azimuth))
        if waves is None:
            keep_findings(scenario, assembly, catalog, before, findings)
    variables = quantized(cube_variables(scenario, assembly, waves is not None), scenario, findings.accuracy)
    plan = Plan(
        scenario=scenario,
        catalog=catalog,
        assembly=assembly,
        frame_times_s=times,
        sun_track=track,
        sun_zenith_deg=zenith,
        sun_azimuth_deg=azimuth,
        variables=variables,
        skipped=findings.skipped,
        filled_in=assembly.filled_in,
        waves=waves,
        accuracy=findings.accuracy,
        faint_sunlight=findings.faint_sunlight,
        sensor=sensor,
        views=findings.views,
    )
    return plan if sensor is None else replace(plan, sensor=with_margin(plan))


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
