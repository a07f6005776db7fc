"""Omissions due to one view and one sun for all pixels, and the change of radiance in the corners of the image."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.error_norm import largest_error
from hcss_twin.core.errors import ProviderError, ScenarioError
from hcss_twin.physics.viewing import LinesOfSight
from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.directions import SunlitDirections
from hcss_twin.plan.few_columns import SAFETY_FACTOR, TOO_DEAR, FewColumns, Omission
from hcss_twin.plan.lines_of_sight import SunTrack
from hcss_twin.plan.views import ImageViews, may_have_own_suns
from hcss_twin.providers import Sun, View

SENSOR_ALTITUDE_M = 800e3
"""Assumed sensor altitude if the scenario has none: that of many satellites in low orbit."""

SUN_ANGLES = "sun angles of single pixels"

_CORNERS = ((1.0, 1.0), (1.0, -1.0))
"""Two neighbouring corners of the image, in coordinates from -1 to 1."""


def one_direction(
    assembly: Assembly,
    columns: FewColumns,
    track: SunTrack,
    known: Mapping[tuple[float, Sun | None], Mapping[str, Array]],
    own_views: bool,
    contrast: float | None,
) -> Iterator[Omission]:
    """Yield the omissions due to one direction for all pixels.

    Parameters
    ----------
    known : mapping of (float, Sun or None) to mapping of str to ndarray (C, B)
        Terms of the columns at some times with their sun (None: without sunlight).
    own_views : bool
        Whether view angles vary over the image.
    contrast : float or None
        Largest difference between two pixels, relative to the darker one; None if unknown.
    """
    ends = columns.ends
    totals = {frame: np.sum(list(terms.values()), axis=0)[ends] for frame, terms in known.items()}
    columns = columns.only(ends)
    no_altitude, may_have_suns = assembly.lines_of_sight is None, may_have_own_suns(assembly)
    if assembly.directions is None and (no_altitude or not own_views):
        of_suns = {sun: total for (_, sun), total in totals.items()}
        yield _one_view(assembly, columns, track, of_suns, own_views, contrast)
    lit = [(corner_suns(assembly, track, time_s), total) for (time_s, sun), total in totals.items() if sun is not None]
    if lit and not assembly.own_suns and (no_altitude or not own_views or not may_have_suns):
        bound = _bound_of_suns(assembly, columns, lit)
        corners = "providers do not know it in the corners" if bound is None else "the bound is for the corners"
        needs, decision = "a smaller image: no key computes it", ""
        if no_altitude and may_have_suns:
            needs, decision = "platform.altitude", TOO_DEAR
        instead = "the sun is that of the image centre"
        if isinstance(assembly.directions, SunlitDirections):
            instead = "the sun is that of one place in each direction and frame"
            corners = "the bound is for the farthest place seen along it"
        yield Omission(SUN_ANGLES, f"{instead}; {corners}", bound, needs=needs, decision=decision)


def _one_view(
    assembly: Assembly,
    columns: FewColumns,
    track: SunTrack,
    known: Mapping[Sun | None, Array],
    own_air: bool,
    contrast: float | None,
) -> Omission:
    """Return the omission of one view: of pixels that see the same clouds, and of those that see others."""
    views, apart = corner_views(assembly, track, own_air)
    bound = largest = _bound_of_views(assembly, columns, views, known)
    lines, air = assembly.lines_of_sight, assembly.air_over_field
    altitude_km = (SENSOR_ALTITUDE_M if lines is None else lines.altitude_m) / 1e3
    corners = f"corners of the image seen from {altitude_km:.0f} km, {apart:.2g} deg off"
    elsewhere_m = max((_elsewhere_m(assembly, view) for view in views), default=0.0)
    estimate, sense = None, ""
    if elsewhere_m > 0.0 and bound is not None and lines is None:
        # Clouds are displaced by whole points: however little directions differ, some pixels see the next ones. Where
        # the sensor's altitude is known they are displaced along the line of sight of each point.
        pixels = elsewhere_m / assembly.grid.pixel_size_m
        corners += (
            f", where clouds stand up to {elsewhere_m:.2g} m ({pixels:.2g} pixels) from where these rays see them"
        )
        estimate, sense = bound, "pixels that see the same clouds"
        bound = None if contrast is None else bound + contrast
    return Omission(
        "view angles of single pixels",
        f"rays are parallel, one direction{' and one air' if air.varies and not own_air else ''} for the whole image; "
        + (f"providers do not know {corners}" if largest is None else f"the bound is for {corners}"),
        bound,
        estimate,
        sense,
        needs="platform.altitude" if lines is None else "an atmosphere that knows these angles: no key computes it",
        decision=TOO_DEAR if lines is None else "",
    )


def corner_views(assembly: Assembly, track: SunTrack, own_air: bool = False) -> tuple[tuple[View, ...], float]:
    """Return the view from two neighbouring corners of the image, and how far it turns, in degrees.

    To first order the opposite corners differ equally in the opposite sense. The corner with the larger change of
    zenith angle is first. ``own_air``: each pixel has its own air anyway, so the
    views use that of the image centre.
    """
    lines, air = assembly.lines_of_sight, assembly.air_over_field
    if lines is None:
        view = assembly.view
        lines = LinesOfSight(
            track.latitude_deg, track.longitude_deg, view.zenith_deg, view.azimuth_deg, SENSOR_ALTITUDE_M
        )
    centre = air.centre_deg if air.varies and not own_air else None
    views = ImageViews(assembly.grid, lines, centre_deg=centre).at(_CORNERS)
    apart = max(_between_deg(view, assembly.view) for view in views)
    return tuple(sorted(views, key=lambda view: -abs(view.zenith_deg - assembly.view.zenith_deg))), apart


def _elsewhere_m(assembly: Assembly, view: View) -> float:
    """Distance between the places at which the highest clouds appear along a line of sight and along the middle's."""
    if not (assembly.slant.parallax and assembly.has_cloud):
        return 0.0
    along, of_middle = (_direction(one) for one in (view, assembly.view))
    return assembly.highest_met_m * float(np.linalg.norm(along[:2] / along[2] - of_middle[:2] / of_middle[2]))


def _between_deg(one: View, other: View) -> float:
    """Angle between two directions."""
    a, b = (_direction(view) for view in (one, other))
    return math.degrees(math.atan2(float(np.linalg.norm(np.cross(a, b))), float(a @ b)))


def _direction(view: View) -> Array:
    zenith, azimuth = math.radians(view.zenith_deg), math.radians(view.azimuth_deg)
    across = math.sin(zenith)
    return np.array([across * math.sin(azimuth), across * math.cos(azimuth), math.cos(zenith)])


def corner_suns(assembly: Assembly, track: SunTrack, time_s: float) -> tuple[Sun | None, ...]:
    """Return the sun at two neighbouring corners (None: below the horizon), ordered as in :func:`corner_views`."""
    zenith = track.at(time_s).zenith_deg
    suns = [track.at(time_s, corner) for corner in _corners_m(assembly)]
    suns.sort(key=lambda sun: -abs(sun.zenith_deg - zenith))
    return tuple(sun if sun.is_up else None for sun in suns)


def _corners_m(assembly: Assembly) -> tuple[tuple[float, float], ...]:
    """Outer corners of what is seen, in the north-east and south-east."""
    grid = assembly.grid
    of_grid = 0.5 * grid.columns * grid.pixel_size_m, 0.5 * grid.rows * grid.pixel_size_m
    x, y = of_grid if assembly.reach_m is None else assembly.reach_m
    return tuple((across * x, up * y) for across, up in _CORNERS)


def _bound_of_views(
    assembly: Assembly, columns: FewColumns, views: Sequence[View], known: Mapping[Sun | None, Array]
) -> float | None:
    """Return the bound; None if providers support no other view, like imported single-angle atmospheres."""
    low, high = assembly.transmittance.declares.valid.get("view_zenith", (0.0, 90.0))
    if not all(low <= view.zenith_deg <= high for view in views):
        return None
    largest = 0.0
    try:
        for corner, view in enumerate(views):
            largest = max(largest, _change(columns, assembly.toward(view), list(known.items()), corner))
    except (ProviderError, ScenarioError):
        return None
    return SAFETY_FACTOR * largest


def _bound_of_suns(
    assembly: Assembly, columns: FewColumns, lit: Sequence[tuple[Sequence[Sun | None], Array]]
) -> float | None:
    """Return the bound; None if the sun in a corner is too low for the providers."""
    largest = 0.0
    try:
        for corner in range(len(_CORNERS)):
            under = [(corners[corner], total) for corners, total in lit]
            largest = max(largest, _change(columns, assembly, under, corner))
    except ProviderError:
        return None
    return SAFETY_FACTOR * largest


def _change(columns: FewColumns, scene: Assembly, known: Sequence[tuple[Sun | None, Array]], corner: int) -> float:
    """Return the largest change from known columns, under each sun.

    After the first corner only of clear sky, which is the most sensitive to azimuth.
    """
    if corner > 0 and columns.clear:
        columns = columns.only(np.zeros(1, dtype=np.intp))
    totals = columns.totals_in(scene.model, [scene.setting(sun) for sun, _ in known])
    changes = (largest_error(total, of_sun[: len(total)]) for total, (_, of_sun) in zip(totals, known, strict=True))
    return max(changes, default=0.0)
