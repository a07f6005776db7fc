"""What a plan leaves out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcss_twin.cube.variables import VariableSpec
from hcss_twin.scene.building.assembly import Assembly
from hcss_twin.scene.ledger.slant_skipped import slant_skipped
from hcss_twin.scene.sun_track import SunTrack

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Skipped:
    """Something that is left out, why, and how much radiance it could have carried.

    ``bound`` is relative to the band radiance; 0 means nothing is lost, None that the replacement is
    equal in law (or as ``why`` says) and not pixel by pixel.
    """

    what: str
    why: str
    bound: float | None


def skipped_parts(
    assembly: Assembly,
    variables: tuple[VariableSpec, ...],
    track: SunTrack,
    time_s: Array,
    sun_zenith_deg: Array,
) -> list[Skipped]:
    """Return what the scene does without, but for its waves, which ``choose_waves`` tells."""
    skipped: list[Skipped] = []
    radiance = any(spec.kind in ("radiance", "derived") for spec in variables)
    if not radiance:
        skipped.append(Skipped("all radiance", "no requested variable needs it", 0.0))
    if np.all(sun_zenith_deg >= 90.0):
        skipped.append(Skipped("sunlight", "the sun is below the horizon in every frame", 0.0))
    if not assembly.layers:
        skipped.append(Skipped("cloud optics and cloudy columns", "the scenario has no cloud layer", 0.0))
    elif not assembly.has_cloud:
        skipped.append(Skipped("cloudy columns", "coverage is 0", 0.0))
    several = len(assembly.layers) > 1
    for layer, generator, cloudy in zip(
        assembly.layers, assembly.generators, assembly.cloudy_layers, strict=True
    ):
        if several and assembly.has_cloud and not cloudy:
            skipped.append(Skipped(f"columns with {layer.name}", "its coverage is 0", 0.0))
        for what, why in getattr(generator, "skipped", ()):
            skipped.append(Skipped(f"{layer.name}: {what}" if several else what, why, None))
    skipped += [Skipped(*each) for each in slant_skipped(assembly, track, time_s, radiance)]
    return skipped
