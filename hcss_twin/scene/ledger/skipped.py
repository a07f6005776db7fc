"""What a plan leaves out."""

from __future__ import annotations

from collections.abc import Iterator

from hcss_twin.cube.variables import TERM_PREFIX, VariableSpec
from hcss_twin.scenario.scenario import Scenario
from hcss_twin.scene.building.assembly import Assembly
from hcss_twin.scene.ledger.contrast import largest_contrast
from hcss_twin.scene.ledger.entry import Skipped
from hcss_twin.scene.ledger.few_columns import few_columns
from hcss_twin.scene.ledger.low_sun import low_sun
from hcss_twin.scene.ledger.one_direction import one_direction
from hcss_twin.scene.ledger.slant_skipped import slant_skipped
from hcss_twin.scene.ledger.sun_frames import SunFrames
from hcss_twin.scene.ledger.unrequested import unrequested


def skipped_parts(
    scenario: Scenario,
    assembly: Assembly,
    variables: tuple[VariableSpec, ...],
    possible: tuple[VariableSpec, ...],
    sun: SunFrames,
    faint_sunlight: float | None,
    waves: bool,
    accuracy: float,
    views: bool = False,
) -> Iterator[Skipped]:
    """Yield what the scene does without, but for its waves, which ``choose_waves`` tells.

    Parameters
    ----------
    variables, possible : tuple of VariableSpec
        Of the cube, and all that the scene has.
    faint_sunlight : float or None
        Largest share of sunlight in a scene that is computed without; None where it is computed with it.
    waves : bool
        Whether waves are drawn.
    accuracy : float
        Relative to the radiance.
    views : bool
        Whether pixels have views of their own.
    """
    radiance = any(spec.needs_radiance for spec in variables)
    # Terms of sunlight that is not computed are nothing, whether they are looked up or not.
    dark = not sun.up.size or faint_sunlight is not None
    gone = {TERM_PREFIX + name for name in assembly.model.solar_terms} if dark else set()
    possible = tuple(spec for spec in possible if spec.name not in gone)
    yield from unrequested(variables, possible, scenario.output.certificate > 0)
    yield from _sunlight(sun, radiance, faint_sunlight)
    yield from _clouds(assembly)
    if not radiance:
        # Masks change by whole pixels, and no radiance is there to be bounded.
        yield from slant_skipped(assembly, sun, None, radiance)
        return
    yield Skipped(
        "radiance of single pixels",
        "tables of few wavenumbers, cloud thicknesses and instants stand for it"
        + ("; the run's certificate tries them" if scenario.output.certificate else ""),
        accuracy,
    )
    frames = sun.telling(assembly.view)
    if faint_sunlight is not None:
        frames = [(frames[0][0], None)]
    columns = few_columns(assembly)
    known = {frame: columns.terms(assembly.model, frame[1]) for frame in frames}
    yield from low_sun(assembly, columns, known)
    yield from one_direction(assembly, columns, sun.track, known, views)
    yield Skipped(
        "changes of air and sea over image and frames",
        "the scenario has one profile, one temperature of the sea and one wind",
        0.0,
    )
    # Waves make clear pixels brighter and darker than any of the columns.
    contrast = None if waves else largest_contrast(assembly, list(known.values()))
    if assembly.has_cloud and scenario.image.samples_per_pixel == 1:
        why = "image.samples_per_pixel is 1: a pixel is what its centre sees; the bound is for a pixel"
        yield Skipped("clouds within the footprint of a pixel", why, contrast)
    yield from slant_skipped(assembly, sun, contrast, radiance)


def _sunlight(sun: SunFrames, radiance: bool, faint: float | None) -> Iterator[Skipped]:
    frames, lit = sun.time_s.size, sun.up.size
    if not lit:
        yield Skipped("sunlight", "the sun is below the horizon in every frame", 0.0)
    elif lit < frames and radiance:
        yield Skipped(
            "sunlight in some frames", f"the sun is below the horizon in {frames - lit} of {frames}", 0.0
        )
    if faint is not None:
        yield Skipped("sunlight", "in every band it is less than a tenth of the accuracy asked for", faint)


def _clouds(assembly: Assembly) -> Iterator[Skipped]:
    if not assembly.layers:
        yield Skipped("cloud optics and cloudy columns", "the scenario has no cloud layer", 0.0)
    elif not assembly.has_cloud:
        yield Skipped("cloudy columns", "coverage is 0", 0.0)
    several = len(assembly.layers) > 1
    for layer, generator, cloudy in zip(
        assembly.layers, assembly.generators, assembly.cloudy_layers, strict=True
    ):
        if several and assembly.has_cloud and not cloudy:
            yield Skipped(f"columns with {layer.name}", "its coverage is 0", 0.0)
        for what, why in getattr(generator, "skipped", ()):
            yield Skipped(f"{layer.name}: {what}" if several else what, why, None)
