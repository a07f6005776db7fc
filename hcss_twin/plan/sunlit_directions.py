"""Suns of the places that an image with directions of its own sees, where one sun for all is not accurate enough.

Along a direction, frames of a camera in motion see one place after another: the place is a polynomial of the direction
and of the time, and each time with tables has a sun for each direction.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.cache import kept_result
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import HcssError
from hcss_twin.physics.geodesy import Ellipsoid
from hcss_twin.plan.accuracy import requested_accuracy
from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.directions import EXPONENTS, OF_TIME, SunlitDirections, powers
from hcss_twin.plan.few_columns import OMISSION_SHARE, few_columns
from hcss_twin.plan.lines_of_sight import SunTrack
from hcss_twin.plan.one_direction import SUN_ANGLES, one_direction
from hcss_twin.plan.output import computed_variables, cube_variables, wants_radiance
from hcss_twin.plan.rays import Rays
from hcss_twin.plan.scene_analysis import inputs_of_analysis
from hcss_twin.plan.sunlight import SunFrames
from hcss_twin.plan.views import EDGES, EXTREMES, SUNS_WITHIN_M
from hcss_twin.scenario.scenario import Scenario

SIDE, TIMES = 5, 5
"""Pixels along each side of the image whose places are asked for, and frames."""

LEAST = (1e-1, 3e-2, 1e-2, 3e-3, 1e-3, 1e-6)
"""Smallest singular values of fits, relative to the largest: small ones change little within frames and much beyond."""

GAIN = 0.25
"""Part of the distance from the centre that may remain between the place of a direction and those that frames see along
it: more is not worth a sun for each view."""

BEYOND_M = 1.5e6
"""Farthest place from the middle of a frame along a direction of the pass that the frame does not see: such suns are
tabulated, too."""


@dataclass(frozen=True)
class OneSun:
    """Whether one sun for all pixels is accurate enough."""

    suffices: bool


def needs_own_suns(scenario: Scenario, assembly: Assembly, catalog: Catalog, suns: SunFrames) -> bool:
    """Whether one sun for all pixels exceeds its share of the accuracy.

    The bound is that of the omission, with the fewest streams, so that the scene is analysed once, with its own suns.
    """
    variables = computed_variables(scenario, assembly, True, cube_variables(scenario, assembly, True))
    may_have = not assembly.own_suns and not assembly.air_over_field.varies and suns.up.size > 0
    if not may_have or not wants_radiance(variables):
        return False
    parts = {**inputs_of_analysis(scenario, assembly, catalog), "for": "suns of places"}
    return not kept_result(parts, catalog, partial(_one_sun, scenario, assembly, suns), (OneSun,)).suffices


def _one_sun(scenario: Scenario, assembly: Assembly, suns: SunFrames) -> OneSun:
    few, frames = assembly.at_level(0), suns.extremes(assembly.view)
    columns = few_columns(few)
    try:
        limit = OMISSION_SHARE * requested_accuracy(scenario, few, [sun for _, sun in frames]).relative
        terms = columns.terms_in(few.model, [few.setting(sun) for _, sun in frames])
        known = dict(zip(frames, terms, strict=True))
        omissions = [*one_direction(few, columns, suns.track, known, True, None)]
    except HcssError:  # the analysis of the scene names the field
        return OneSun(True)
    return OneSun(not any(item.what == SUN_ANGLES and item.exceeds(limit) for item in omissions))


def with_own_suns(
    rays: Rays, scenario: Scenario, assembly: Assembly, suns: SunFrames
) -> tuple[Assembly, SunFrames] | None:
    """Return the scene with a sun for each direction, and the suns of its centre.

    ``reach_m`` of the scene is then how far places that frames see are from those of their direction and time. None if
    frames see too different places along a direction, are wider than images with suns of their own, or see the night.
    """
    directions = assembly.directions
    if directions is None or assembly.reach_m is None:
        return None
    chosen = np.unique(np.linspace(0, suns.time_s.size - 1, TIMES).round().astype(np.intp))
    times_s = suns.time_s[chosen]
    positions, seen_m = _places(rays, scenario, times_s.tolist())
    middles = np.mean(seen_m, axis=1, keepdims=True)
    if np.any(np.isnan(positions)) or np.max(np.linalg.norm(seen_m - middles, axis=-1)) > SUNS_WITHIN_M:
        return None
    span_s = 0.5 * float(times_s[0] + times_s[-1]), 0.5 * float(times_s[-1] - times_s[0]) or 1.0
    time = np.broadcast_to(((times_s - span_s[0]) / span_s[1])[:, None], positions.shape[:2])
    terms, of_place = powers(positions[..., 0], positions[..., 1], time).reshape(-1, len(EXPONENTS)), len(OF_TIME[0])
    at_m = seen_m.reshape(-1, 2)
    # One place along each direction, if that will do; else the least that changes beyond what frames see.
    for count, least in ((of_place, LEAST[-1]), *((len(EXPONENTS), least) for least in LEAST)):
        coefficients = np.zeros((len(EXPONENTS), 2))
        coefficients[:count] = np.linalg.lstsq(terms[:, :count], at_m, rcond=least)[0]
        left_m = np.max(np.abs(terms @ coefficients - at_m), axis=0)
        if np.hypot(*left_m) <= GAIN * np.hypot(*assembly.reach_m):
            break
    else:
        return None
    is_timed = count > of_place
    sunlit = SunlitDirections(directions, (scenario.place.latitude, scenario.place.longitude), coefficients, span_s)
    track = replace(suns.track, is_timed=is_timed)
    if is_timed and not _is_lit(sunlit, track, times_s.tolist()):
        return None
    across, up = np.array(EXTREMES + EDGES).T
    for number, of_frame in enumerate(time[:, 0].tolist()):
        reached_m = powers(across, up, np.full_like(up, of_frame)) @ coefficients
        if np.max(np.linalg.norm(reached_m - middles[number], axis=-1)) > BEYOND_M:
            return None
    zenith, azimuth = suns.zenith_deg, suns.azimuth_deg
    if is_timed:
        middle = np.zeros_like(suns.time_s)
        in_middle = powers(middle, middle, (suns.time_s - span_s[0]) / span_s[1]) @ coefficients
        zenith, azimuth, _ = track.positions(suns.time_s, (in_middle[:, 0], in_middle[:, 1]))
    reaching = replace(assembly, directions=sunlit, reach_m=(float(left_m[0]), float(left_m[1])))
    return reaching, SunFrames(track, suns.time_s, zenith, azimuth)


def _places(rays: Rays, scenario: Scenario, times_s: Sequence[float]) -> tuple[Array, Array]:
    """Return positions (T, N, 2) of some pixels at times, and the places that they see, m east and north."""
    centre_deg = scenario.place.latitude, scenario.place.longitude
    sizes = rays.image.rows, rays.image.columns
    rows, columns = (np.linspace(0, size - 1, SIDE).astype(int).tolist() for size in sizes)
    pixels = [(slice(row, row + 1), slice(column, column + 1)) for row in rows for column in columns]
    at = [[rays.positions(pixel, time_s) for pixel in pixels] for time_s in times_s]
    seen_deg = [[rays.locations_deg(pixel, time_s, scenario) for pixel in pixels] for time_s in times_s]
    latitude, longitude = np.moveaxis(np.array(seen_deg)[..., 0, 0], -1, 0)
    seen_m = np.stack(Ellipsoid.to_plane(latitude, longitude, *centre_deg), axis=-1)
    return np.array(at)[..., 0, 0], seen_m


def _is_lit(sunlit: SunlitDirections, track: SunTrack, times_s: Sequence[float]) -> bool:
    """Whether the sun is up in all places along directions, and in the centre."""
    views = sunlit.passing(EXTREMES + EDGES)
    suns = [(time_s, track.at(time_s)) for time_s in times_s]
    return all(sun.is_up and all(view.at(time_s).of_place(sun).is_up for view in views) for time_s, sun in suns)
