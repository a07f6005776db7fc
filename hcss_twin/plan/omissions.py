"""Omissions of a plan, and the largest radiance change that each can cause."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import product

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.error_norm import largest_error
from hcss_twin.cube.variables import SHADOW_MASK, TERM_PREFIX, VariableSpec
from hcss_twin.plan.air_over_field import AirOverField
from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.clear_sky_sizes import RAREST, change_by_sea, size_of_texture, typical_sea_K, typical_vapour
from hcss_twin.plan.climate_over_image import climate_over_image
from hcss_twin.plan.combinations import NotComputed
from hcss_twin.plan.few_columns import (
    CROSSED,
    SAFETY_FACTOR,
    SKIP_SHARE,
    SWITCHED_OFF,
    TOO_DEAR,
    FewColumns,
    Omission,
    few_columns,
    largest_contrast,
    omitted,
    typical_contrast,
)
from hcss_twin.plan.numerics import for_spectra
from hcss_twin.plan.one_direction import one_direction
from hcss_twin.plan.slant_paths import sea_sun_terms
from hcss_twin.plan.sunlight import SunFrames, Sunlight, low_sun, toward_glint
from hcss_twin.providers import ColumnSetting, Sun
from hcss_twin.scenario.scenario import Scenario

_SINGLE_PIXELS, _CHECKED = "radiance of single pixels", "; the run's certificate tries them"


def without_certificate(omissions: tuple[Omission, ...]) -> tuple[Omission, ...]:
    """Return the omissions of a scene none of whose pixels is checked; without radiance there is nothing to check."""
    if all(each.what != _SINGLE_PIXELS for each in omissions):
        return omissions
    none = Omission("the certificate", "output.certificate is 0: no pixel is checked", 0.0)
    return (none, *(replace(each, why=each.why.removesuffix(_CHECKED)) for each in omissions))


def unrequested(requested: tuple[VariableSpec, ...], possible: tuple[VariableSpec, ...]) -> Iterator[Omission]:
    """Yield available output that was not requested.

    Parameters
    ----------
    requested, possible : tuple of VariableSpec
        Variables of the cube, and all that the scene can have.
    """
    names = {spec.name for spec in requested}
    left = [spec for spec in possible if spec.name not in names]
    radiance = any(spec.needs_radiance for spec in requested)
    if not radiance:
        yield Omission("all radiance", "no requested variable needs it", 0.0)
    terms = [spec.name for spec in left if spec.name.startswith(TERM_PREFIX)] if radiance else []
    if terms:
        yield Omission(
            "look-up of terms of the radiance",
            f"not requested; the total has all: {', '.join(name.removeprefix(TERM_PREFIX) for name in terms)}",
            0.0,
        )
    others = [spec.name for spec in left if spec.kind == "truth" or (radiance and spec.kind == "derived")]
    if others:
        yield Omission("other variables", f"not requested: {', '.join(others)}", 0.0)


GLINT_SAFETY_FACTOR = 1.05
"""Safety factor on the share of sunlight, for suns between the examined frames; the share is at most 1."""


def slant_skipped(
    assembly: Assembly, sun: SunFrames, contrast: float | None, typical: float | None, radiance: bool
) -> Iterator[Omission]:
    """Yield the omissions of parallax and shadows.

    Parameters
    ----------
    contrast, typical : float or None
        Largest difference between two pixels, relative to the darker one, and to their mean; None if unknown.
    radiance : bool
        Whether radiance is requested.
    """
    slant = assembly.slant
    if not assembly.has_cloud:
        return
    farthest = slant.farthest_m(assembly.highest_met_m)
    without = slant.why_not.get("parallax")
    if farthest == 0.0:
        if slant.parallax:
            yield Omission("parallax of clouds", "the view is vertical: it displaces nothing", 0.0)
    elif without is not None and assembly.directions is None:
        pixels = farthest / assembly.grid.pixel_size_m
        rms = None if typical is None else _DISPLACED * typical * math.sqrt(min(1.0, math.sqrt(2.0) * pixels))
        yield omitted(
            Omission("parallax of clouds", "", contrast, rms, "" if rms is None else "rms over many images, at most"),
            without,
            f"each cloud stands over the sea point seen through it, up to {farthest:.0f} m ({pixels:.1f} pixels) from "
            "where the line of sight meets it; the bound is for single pixels",
        )
    without = slant.why_not.get("shadows")
    if without is None or not radiance or not sun.up.size:
        return
    what, instead = "shadows of clouds on the sea", "clear points are in full sun"
    if not assembly.has_clear_sky:
        yield Omission(what, f"{without.why}: {instead}, and there are none", 0.0)
        return
    share = largest_glint_share(assembly, sun)
    of_sea = " from the sea" if sea_sun_terms(assembly.model) else ""
    yield omitted(
        Omission(what, "", share),
        without,
        f"{instead}; the bound is the largest share of sunlight{of_sea} in the clear radiance of a band, at the first, "
        "the last and the frame nearest to the mirror direction",
    )


def negligible_shadows(scenario: Scenario, assembly: Assembly, sun: SunFrames, accuracy: float) -> NotComputed | None:
    """Return why shadows are skipped that a scene leaves to the plan; None if they matter, or are wanted."""
    slant = assembly.slant
    wanted = slant.options.shadows == "on" or SHADOW_MASK in scenario.output.variables
    if not slant.shadows or wanted or not sun.up.size:
        return None
    if not (assembly.has_cloud and assembly.has_clear_sky):
        return NotComputed("no pixel can be cloudy" if assembly.has_clear_sky else "clouds hide the sea everywhere")
    if largest_glint_share(assembly, sun) > SKIP_SHARE * accuracy:
        return None
    return NotComputed("they would change less than their share of the accuracy asked for")


def largest_glint_share(assembly: Assembly, sun: SunFrames) -> float:
    """Return the largest share of sea-reflected direct sunlight in the clear radiance of any band.

    Evaluated at three frames with the sun above the horizon: the first, the last, and the one with the sun's mirror
    direction nearest to the view, with a safety factor; of a camera, also toward the views nearest to the mirror
    directions. If the radiance model does not declare the terms of this
    sunlight, all sunlight is used.
    """
    model, grid = assembly.model, assembly.spectral_grid
    named = sea_sun_terms(model) or tuple(model.solar_terms)
    share, frames = 0.0, (sun.mirror(assembly.view), int(sun.up[0]), int(sun.up[-1]))
    suns = [position for _, position in sun.at(frames)] if named else []
    for scene, position in product(toward_glint(assembly, suns), suns):
        terms = scene.clear(grid.wavenumber_cm1, position)
        bands = {name: grid.weights_cm1 @ np.asarray(values) for name, values in terms.items()}
        glint = np.sum([bands[name] for name in named], axis=0)
        total = np.sum(list(bands.values()), axis=0)
        share = max(share, float(np.max(glint[total > 0.0] / total[total > 0.0], initial=0.0)))
    return min(GLINT_SAFETY_FACTOR * share, 1.0)


_DISPLACED = math.sqrt(0.5)
"""Rms difference between two uncorrelated masks, sqrt(2 c (1 - c)), at the coverage c of 0.5 where it is greatest; the
analysis of a scene serves all its coverages. Displaced by less than a pixel, along both axes by at most sqrt(2) times
as much together, only that share of the points lies in another pixel."""


def list_omissions(
    scenario: Scenario,
    assembly: Assembly,
    variables: tuple[VariableSpec, ...],
    possible: tuple[VariableSpec, ...],
    sun: SunFrames,
    sunlight: Sunlight,
    waves: bool,
    accuracy: float,
    views: bool = False,
) -> Iterator[Omission]:
    """Yield the omissions of a scene whose pixels are checked, except for waves, which :func:`choose_waves` reports.

    Parameters
    ----------
    variables, possible : tuple of VariableSpec
        Variables of the cube, and all that the scene can have.
    sunlight : Sunlight
        Computed, or omitted because it is faint.
    waves : bool
        Whether waves are resolved.
    accuracy : float
        Relative to the radiance.
    views : bool
        Whether view angles vary over the image.
    """
    radiance = any(spec.needs_radiance for spec in variables)
    # Terms of omitted sunlight are zero, whether they are looked up or not.
    lit = sunlight.matters(sun.zenith_deg)
    gone = set() if lit else {TERM_PREFIX + name for name in assembly.model.solar_terms}
    possible = tuple(spec for spec in possible if spec.name not in gone)
    yield from unrequested(variables, possible)
    yield from _sunlight(sun, radiance, sunlight)
    yield from _clouds(assembly)
    if not radiance:
        # Masks change by whole pixels, and there is no radiance to bound.
        yield from slant_skipped(assembly, sun, None, None, radiance)
        return
    stand_in = f"tables of few wavenumbers, cloud thicknesses and instants stand for it{_CHECKED}"
    yield Omission(_SINGLE_PIXELS, stand_in, accuracy)
    frames = sun.extremes(assembly.view)
    if not sunlight.is_computed:
        frames = [(frames[0][0], None)]
    # Bounds are relative changes, which hardly depend on the numerical level.
    assembly = for_spectra(assembly)
    columns = few_columns(assembly)
    of_frames = columns.terms_in(assembly.model, [assembly.setting(position) for _, position in frames])
    known = dict(zip(frames, of_frames, strict=True))
    yield from low_sun(assembly, columns, known)
    # Waves make clear pixels brighter or darker than any of the columns.
    contrast = None if waves else largest_contrast(assembly, list(known.values()))
    yield from one_direction(assembly, columns, sun.track, known, views, contrast)
    yield from _changes_of_air(scenario, assembly, columns, known)
    typical = typical_contrast(list(known.values()))
    if assembly.has_cloud and assembly.samples_per_pixel == 1:
        why = "one point for each pixel: a pixel is what its centre sees; the bound is for a pixel"
        # Where a share f of the footprint is cloudy, the centre errs by 2 f (1 - f) steps on average: 1/3 over all f.
        size, of = typical / 3.0, CROSSED
        if not assembly.has_clear_sky and sum(assembly.cloudy_layers) == 1:
            # No edges. Over a distance, a thickness with the spectrum of turbulence changes with its power 1/3.
            size, of = (
                size / min(assembly.grid.rows, assembly.grid.columns) ** (1.0 / 3.0),
                "rms, at most: no pixel holds an edge",
            )
        needs = "image.samples_per_pixel = 2 or more"
        yield Omission("clouds within the footprint of a pixel", why, contrast, size, of, needs, TOO_DEAR)
    yield from slant_skipped(assembly, sun, contrast, typical, radiance)


def texture_of_sea(assembly: Assembly, suns: Sequence[Sun | None], why: str, needs: str = "") -> Omission:
    """Return the omission of the texture of the sea's temperature.

    Parameters
    ----------
    suns : sequence of Sun or None
        Of some frames.
    why : str
        Why the sea has one temperature.
    needs : str
        Key and value that would avoid it.
    """
    typical_K = typical_sea_K(assembly.grid)
    share = change_by_sea(assembly, typical_K)
    size = f"measured seas vary by up to {typical_K:.2g} K (standard deviation) within an image of this size"
    bound, needs = RAREST * share, needs if share else ""
    typical, sense = size_of_texture(assembly, suns, warmer_K=typical_K).relative, f"rms, {typical_K:.2g} K of the sea"
    return Omission("texture of the sea's temperature", f"{why}; {size}", bound, typical, sense, needs)


def _even_vapour(assembly: Assembly, suns: Sequence[Sun | None]) -> Iterator[Omission]:
    """Yield the texture of water vapour, if it has none."""
    even = assembly.even_vapour
    if even is None:
        return
    what, deviation = "texture of water vapour", typical_vapour(assembly.grid)
    if assembly.has_bound_air:  # nothing else can be computed, not even its size
        yield Omission(what, even.why, None)
        return
    size = size_of_texture(assembly, suns, vapour_factor=1.0 - deviation)
    typical = (
        f"measured columns vary by up to {100.0 * deviation:.2g} % (standard deviation) within an image of this size, "
        f"which is {size.kelvin:.2g} K"
    )
    texture = Omission(what, "", RAREST * size.largest, size.relative, f"rms, {size.kelvin:.2g} K")
    told = omitted(texture, even, typical)
    yield replace(told, decision=told.decision or TOO_DEAR) if even.needs else told


def _one_sea_temperature(scenario: Scenario, assembly: Assembly, suns: Sequence[Sun | None]) -> Iterator[Omission]:
    """Yield the texture of the sea's temperature, if the sea has one temperature."""
    why, needs, decision = "sea.temperature_texture is 0", "sea.temperature_texture = 0.3", SWITCHED_OFF
    if scenario.sea.temperature_texture != 0.0:
        from hcss_twin.plan.texture import why_one_temperature  # not for scenes without texture

        why, needs, decision = why_one_temperature(scenario, assembly), "", ""
    if assembly.surface is None and why:
        yield replace(texture_of_sea(assembly, suns, why, needs), decision=decision)


def _changes_of_air(
    scenario: Scenario,
    assembly: Assembly,
    columns: FewColumns,
    known: Mapping[tuple[float, Sun | None], Mapping[str, Array]],
) -> Iterator[Omission]:
    """Yield the neglected changes over the image, and the interpolation error between several profiles.

    The interpolation error is estimated by leaving out one profile of the file: it is the change of radiance at the
    place of that profile, reduced to the distance between two profiles.
    """
    what, air = "changes of air and sea over image and frames", assembly.air_over_field
    first = [sun for _, sun in known][:1]
    yield from _one_sea_temperature(scenario, assembly, first)
    yield from _even_vapour(assembly, first)
    texture = ", around which they have texture" if assembly.has_texture else ""
    if not (air.varies or air.is_of_place):
        yield from climate_over_image(assembly, columns, first)
        yield Omission(what, f"the scenario has one profile, one temperature of the sea and one wind{texture}", 0.0)
        return
    sea = "wind" if air.of(assembly.view).sea is not None else "temperature of the sea and one wind"
    yield Omission(what, f"the scenario has one {sea}{texture}; the air is that of the first frame's place", 0.0)
    ends, largest = columns.only(columns.ends), 0.0
    for factor, *pair in air.left_out():
        exact, guess = (
            ends.totals_in(assembly.model, [_in_air(assembly.setting(sun), air_of_profile) for _, sun in known])
            for air_of_profile in pair
        )
        changes = (largest_error(one, other) for one, other in zip(guess, exact, strict=True))
        largest = max(largest, *(factor * change for change in changes))
    if not largest:
        return
    yield Omission(
        "air between the profiles of the file",
        "interpolated; the bound is the effect of leaving out a profile near the image centre, reduced to the "
        "distance between two (with only two, the whole difference)",
        SAFETY_FACTOR * largest,
        needs="a finer grid of profiles: no key computes it",
    )


def _in_air(setting: ColumnSetting, air: AirOverField.Air) -> ColumnSetting:
    return replace(setting, profile=air.profile, transmittance=air.transmittance, air_memory=None)


def _sunlight(sun: SunFrames, radiance: bool, sunlight: Sunlight) -> Iterator[Omission]:
    frames, lit = sun.time_s.size, sun.up.size
    if not lit:
        yield Omission("sunlight", "the sun is below the horizon in every frame", 0.0)
    elif lit < frames and radiance:
        yield Omission("sunlight in some frames", f"the sun is below the horizon in {frames - lit} of {frames}", 0.0)
    if not sunlight.is_computed:
        yield Omission("sunlight", "in every band it is less than a tenth of the accuracy asked for", sunlight.share)


OTHER_TOP_M = 100.0
"""Depth by which the temperature of other cloud tops is told."""


def _clouds(assembly: Assembly) -> Iterator[Omission]:
    if not assembly.layers:
        yield Omission("cloud optics and cloudy columns", "the scenario has no cloud layer", 0.0)
    elif not assembly.has_cloud:
        yield Omission("cloudy columns", "coverage is 0", 0.0)
    several = len(assembly.layers) > 1
    for layer, generator, cloudy in zip(assembly.layers, assembly.generators, assembly.cloudy_layers, strict=True):
        if several and assembly.has_cloud and not cloudy:
            yield Omission(f"columns with {layer.name}", "its coverage is 0", 0.0)
        if cloudy and layer.anchor == "top" and getattr(generator, "cloud_top_range_m", None) is None:
            top, below = (float(assembly.profile.temperature_at(layer.top_m - depth)) for depth in (0.0, OTHER_TOP_M))
            why = f"all lie at {layer.top_m:.0f} m; {OTHER_TOP_M:.0f} m lower ones differ by {below - top:+.2g} K"
            needs = "a generator whose clouds have tops of their own: no key computes it"
            yield Omission(f"tops of {layer.name} at altitudes of their own", why, None, needs=needs)
        for what, why in getattr(generator, "skipped", ()):
            yield Omission(f"{layer.name}: {what}" if several else what, why, None)
