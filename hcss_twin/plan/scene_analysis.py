"""What would fail half-way through a scene is found out while it is planned: one wavenumber, one pixel.

What a plan finds out by asking the radiance model for a few columns.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import CatalogError, Problem, ProviderError, ScenarioError
from hcss_twin.cube.variables import TERM_PREFIX, VariableSpec
from hcss_twin.plan.accuracy import RequestedAccuracy, requested_accuracy, share_out
from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.few_columns import Omission
from hcss_twin.plan.lines_of_sight import SunTrack
from hcss_twin.plan.omissions import skipped_parts
from hcss_twin.plan.output import cube_variables, quantized, wants_radiance
from hcss_twin.plan.sunlight import SunFrames, negligible_sunlight
from hcss_twin.plan.views import ViewAxis, choose_views
from hcss_twin.plan.waves import DrawnWaves, choose_waves
from hcss_twin.providers import Sun
from hcss_twin.scenario.scenario import Scenario


def probe_particles(assembly: Assembly) -> None:
    """Find out now that the optics provider cannot have a layer's particles, or its files; one wavenumber of each."""
    wavenumber = assembly.spectral_grid.wavenumber_cm1[:1]
    problems = []
    for layer, cloudy, field in zip(assembly.layers, assembly.cloudy_layers, assembly.particle_fields, strict=True):
        if cloudy:
            try:
                assembly.optics.single_scattering(layer.microphysics, wavenumber)
            except ProviderError as error:
                problems.append(Problem(field, str(error)))
            except CatalogError as error:
                problems.append(Problem("optics.provider", str(error)))
    if problems:
        raise ScenarioError(list(dict.fromkeys(problems)))


def probe_lowest_sun(assembly: Assembly, track: SunTrack, times: Array, zenith_deg: Array) -> None:
    """Find out now, not after the scene is half computed, that a provider cannot follow the sun so low.

    One wavenumber of the columns at the frame with the lowest sun above the horizon.
    """
    up = np.flatnonzero(zenith_deg < 90.0)
    if up.size == 0:
        return
    frame = up[np.argmax(zenith_deg[up])]
    sun = track.at(float(times[frame]))
    wavenumber = assembly.spectral_grid.wavenumber_cm1[:1]
    try:
        assembly.model.clear(wavenumber, sun)
        if assembly.has_cloud:
            assembly.model.cloudy(wavenumber, assembly.extreme_thicknesses_m, sun)
    except ProviderError as error:
        message = (
            f"with the sun at zenith {zenith_deg[frame]:.2f} deg (frame {frame}): {error}; allowed: times with the "
            "sun higher or below the horizon"
        )
        raise ScenarioError([Problem("time", message)]) from error


def probe_last_frame(assembly: Assembly, last_s: float) -> None:
    """Find out now that a generator cannot follow the motion to the end; one pixel, where it gives windows."""
    for generator in assembly.generators:
        if generator.declares.tileable:
            try:
                generator.thickness_m(last_s, slice(0, 1), slice(0, 1))
            except ProviderError as error:
                raise ScenarioError([Problem("frames", str(error))]) from error


SUNS = 5
"""Frames whose sun the bound on waves considers."""


@dataclass(frozen=True)
class SceneAnalysis:
    """What was found out.

    Attributes
    ----------
    accuracy : RequestedAccuracy
        As a share of the radiance of every band.
    faint_sunlight : float or None
        Largest share of sunlight in any band, where radiance is computed without it by day; else None.
    skipped : tuple of Omission
        The ledger.
    views : ViewAxis or None
        Views that have tables; None where that of the image centre stands for all pixels.
    """

    accuracy: RequestedAccuracy
    faint_sunlight: float | None
    skipped: tuple[Omission, ...]
    views: ViewAxis | None = None


def analyse_scene(scenario: Scenario, assembly: Assembly, sun: SunFrames) -> tuple[SceneAnalysis, DrawnWaves | None]:
    """Try what the run will need, and decide what it does without; also the waves to draw, if any.

    Raises
    ------
    ScenarioError
        If a provider cannot have what the scene needs, naming the field.
    """
    radiance = wants_radiance(cube_variables(scenario, assembly, True))
    if radiance:
        probe_particles(assembly)
        probe_lowest_sun(assembly, sun.track, sun.time_s, sun.zenith_deg)
    telling = [position for _, position in sun.telling(assembly.view)] if radiance else []
    accuracy = requested_accuracy(scenario, assembly, telling)
    views = choose_views(scenario, assembly, telling, share_out(accuracy.relative).views)
    suns: list[Sun | None] = [position for _, position in sun.evenly(SUNS)] if radiance else []
    waves, no_waves = choose_waves(scenario, assembly, suns, accuracy.relative)
    drawn = waves is not None
    variables = quantized(cube_variables(scenario, assembly, drawn), scenario, accuracy)
    faint = None
    # Its share is judged for one view.
    if radiance and not drawn and views is None and _may_lack_sunlight(assembly, variables):
        faint = negligible_sunlight(assembly, sun, share_out(accuracy.relative).faint_sunlight)
    possible = cube_variables(scenario, assembly, drawn, ("all",))
    skipped = skipped_parts(
        scenario, assembly, variables, possible, sun, faint, drawn, accuracy.relative, views is not None
    )
    # A scene without radiance has no sea whose waves it could do without.
    told = (*skipped, *((no_waves,) if no_waves is not None and radiance else ()))
    return SceneAnalysis(accuracy, faint, told, views), waves


def _may_lack_sunlight(assembly: Assembly, variables: tuple[VariableSpec, ...]) -> bool:
    """Whether faint sunlight may be left out: shadows are made of it, and a term asked for would be nothing."""
    terms = {TERM_PREFIX + name for name in assembly.model.solar_terms}
    return not assembly.slant.shadows and not any(spec.name in terms for spec in variables)
