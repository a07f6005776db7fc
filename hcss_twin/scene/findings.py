"""What a plan finds out by asking the radiance model for a few columns."""

from __future__ import annotations

from dataclasses import dataclass

from hcss_twin.cube.variables import TERM_PREFIX, VariableSpec
from hcss_twin.providers import Sun
from hcss_twin.scenario.scenario import Scenario
from hcss_twin.scene.accuracy import RequestedAccuracy, requested_accuracy
from hcss_twin.scene.budget import share_out
from hcss_twin.scene.building.assembly import Assembly
from hcss_twin.scene.cube_variables import cube_variables, wants_radiance
from hcss_twin.scene.ledger.entry import Skipped
from hcss_twin.scene.ledger.skipped import skipped_parts
from hcss_twin.scene.ledger.sun_frames import SunFrames
from hcss_twin.scene.ledger.sunless import negligible_sunlight
from hcss_twin.scene.probes import probe_lowest_sun, probe_particles
from hcss_twin.scene.quantization import quantized
from hcss_twin.scene.views.view_axis import ViewAxis
from hcss_twin.scene.views.view_choice import choose_views
from hcss_twin.scene.waves.wave_choice import DrawnWaves, choose_waves

SUNS = 5
"""Frames whose sun the bound on waves considers."""


@dataclass(frozen=True)
class Findings:
    """What was found out.

    Attributes
    ----------
    accuracy : RequestedAccuracy
        As a share of the radiance of every band.
    faint_sunlight : float or None
        Largest share of sunlight in any band, where radiance is computed without it by day; else None.
    skipped : tuple of Skipped
        The ledger.
    views : ViewAxis or None
        Views that have tables; None where that of the image centre stands for all pixels.
    """

    accuracy: RequestedAccuracy
    faint_sunlight: float | None
    skipped: tuple[Skipped, ...]
    views: ViewAxis | None = None


def find_out(scenario: Scenario, assembly: Assembly, sun: SunFrames) -> tuple[Findings, DrawnWaves | None]:
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
    return Findings(accuracy, faint, told, views), waves


def _may_lack_sunlight(assembly: Assembly, variables: tuple[VariableSpec, ...]) -> bool:
    """Whether faint sunlight may be left out: shadows are made of it, and a term asked for would be nothing."""
    terms = {TERM_PREFIX + name for name in assembly.model.solar_terms}
    return not assembly.slant.shadows and not any(spec.name in terms for spec in variables)
