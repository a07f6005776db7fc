"""What a plan says about shadows and parallax that are left out, and how much they could change."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from hcss_twin.scene.building.assembly import Assembly
from hcss_twin.scene.slant.sea_sun import sea_sun_terms
from hcss_twin.scene.slant.slant_paths import displacement_m, reference_height_m
from hcss_twin.scene.sun_track import SunTrack

Array = NDArray[np.float64]


def slant_skipped(
    assembly: Assembly, track: SunTrack, time_s: Array, radiance: bool
) -> Iterator[tuple[str, str, float | None]]:
    """Yield what is left out, why, and the bound relative to the band radiance (None: not pixel by pixel).

    Parameters
    ----------
    time_s : ndarray (F,)
        Of the frames.
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
            yield "parallax of clouds", "the view is vertical: it displaces nothing", 0.0
    elif not slant.parallax:
        pixels = farthest / assembly.grid.pixel_size_m
        yield (
            "parallax of clouds",
            f"slant.parallax is off: each cloud stands over the sea point seen through it, up to {farthest:.0f} m "
            f"({pixels:.1f} pixels) from where the line of sight meets it",
            None,
        )
    if not slant.shadows and radiance and slant.sun_zenith_deg.size:
        share = largest_glint_share(assembly, track, time_s)
        if share is not None:
            yield (
                "shadows of clouds on the sea",
                "slant.shadows is off: clear points are in full sun; the bound is the largest share of sunlight from "
                "the sea in the clear radiance of a band, at the first, the last and the frame nearest to the mirror "
                "direction",
                share,
            )


def largest_glint_share(assembly: Assembly, track: SunTrack, time_s: Array) -> float | None:
    """Return the largest share of direct sunlight from the sea in the clear radiance of any band.

    At three frames of those with the sun above the horizon: the first, the last, and that in which the sun's mirror
    direction is nearest to the view. None where the radiance model does not say which its terms of it are.
    """
    model, grid = assembly.model, assembly.spectral_grid
    named = sea_sun_terms(model)
    if not named:
        return None
    zenith, azimuth, _ = track.positions(time_s)
    up = np.flatnonzero(zenith < 90.0)
    sun, view = np.radians(zenith[up]), np.radians(assembly.view.zenith_deg)
    turn = np.radians(assembly.view.azimuth_deg - azimuth[up])
    # Cosine between the view and the sun's mirror image, whose bearing is opposite to the sun's.
    nearness = np.cos(view) * np.cos(sun) - np.sin(view) * np.sin(sun) * np.cos(turn)
    share = 0.0
    for frame in {int(up[0]), int(up[-1]), int(up[np.argmax(nearness)])}:
        terms = model.clear(grid.wavenumber_cm1, track.at(float(time_s[frame])))
        bands = {name: grid.weights_cm1 @ np.asarray(values) for name, values in terms.items()}
        glint = np.sum([bands[name] for name in named], axis=0)
        share = max(share, float(np.max(glint / np.sum(list(bands.values()), axis=0))))
    return share
