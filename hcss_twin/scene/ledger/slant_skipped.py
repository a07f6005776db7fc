"""What a plan says about shadows and parallax that are left out, and how much they could change."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from hcss_twin.scene.building.assembly import Assembly
from hcss_twin.scene.ledger.entry import Skipped
from hcss_twin.scene.ledger.sun_frames import SunFrames
from hcss_twin.scene.slant.sea_sun import sea_sun_terms
from hcss_twin.scene.slant.slant_paths import displacement_m, reference_height_m

GLINT_ROOM = 1.05
"""Factor on the share of sunlight, for the sun between the frames looked at; the share is at most 1."""


def slant_skipped(
    assembly: Assembly, sun: SunFrames, contrast: float | None, radiance: bool
) -> Iterator[Skipped]:
    """Yield what is left out.

    Parameters
    ----------
    contrast : float or None
        How much brighter, relatively, one pixel can be than another; None where that is not known.
    radiance : bool
        Whether any is wanted.
    """
    slant = assembly.slant
    if not assembly.has_cloud:
        return
    zenith = slant.view.zenith_deg
    height = max(reference_height_m(layer) for layer in assembly.layers)
    farthest = float(np.max(displacement_m(height, zenith, 0.0)))
    if zenith == 0.0:
        if slant.parallax:
            yield Skipped("parallax of clouds", "the view is vertical: it displaces nothing", 0.0)
    elif not slant.parallax:
        pixels = farthest / assembly.grid.pixel_size_m
        yield Skipped(
            "parallax of clouds",
            f"slant.parallax is off: each cloud stands over the sea point seen through it, up to {farthest:.0f} m "
            f"({pixels:.1f} pixels) from where the line of sight meets it; the bound is for single pixels",
            contrast,
        )
    if slant.shadows or not radiance or not sun.up.size:
        return
    what, off = "shadows of clouds on the sea", "slant.shadows is off: clear points are in full sun"
    if not assembly.has_clear_sky:
        yield Skipped(what, f"{off}, and there are none", 0.0)
        return
    share = largest_glint_share(assembly, sun)
    why = (
        f"{off}; the bound is the largest share of sunlight from the sea in the clear radiance of a band, at the "
        "first, the last and the frame nearest to the mirror direction"
    )
    yield Skipped(what, why if sea_sun_terms(assembly.model) else why.replace(" from the sea", ""), share)


def largest_glint_share(assembly: Assembly, sun: SunFrames) -> float:
    """Return the largest share of direct sunlight from the sea in the clear radiance of any band.

    At three frames of those with the sun above the horizon: the first, the last, and that in which the sun's mirror
    direction is nearest to the view, with some room. Of all sunlight where the radiance model does not say which its
    terms of it are.
    """
    model, grid = assembly.model, assembly.spectral_grid
    named = sea_sun_terms(model) or tuple(model.solar_terms)
    share, frames = 0.0, (sun.mirror(assembly.view), int(sun.up[0]), int(sun.up[-1]))
    for _, position in sun.at(frames) if named else ():
        terms = model.clear(grid.wavenumber_cm1, position)
        bands = {name: grid.weights_cm1 @ np.asarray(values) for name, values in terms.items()}
        glint = np.sum([bands[name] for name in named], axis=0)
        total = np.sum(list(bands.values()), axis=0)
        share = max(share, float(np.max(glint[total > 0.0] / total[total > 0.0], initial=0.0)))
    return min(GLINT_ROOM * share, 1.0)
