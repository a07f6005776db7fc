"""One direction of the view and one of the sun stand for all pixels of a frame: how much that could change."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import ProviderError, ScenarioError
from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.lines_of_sight import SunTrack
from hcss_twin.plan.omissions.bounds import SAFETY_FACTOR, FewColumns, Omission, largest_change
from hcss_twin.plan.views import ImageViews
from hcss_twin.providers import RadianceModel, Sun, View

SENSOR_ALTITUDE_M = 800e3
"""Where a scenario has no altitude of the sensor that of many satellites of low orbit stands for it."""

_CORNERS = ((1.0, 1.0), (1.0, -1.0))
"""Two neighbouring ones, of the image from -1 to 1."""


def one_direction(
    assembly: Assembly,
    columns: FewColumns,
    track: SunTrack,
    known: Mapping[tuple[float, Sun | None], Mapping[str, Array]],
    own_views: bool,
) -> Iterator[Omission]:
    """Yield what one direction for all pixels leaves out.

    Parameters
    ----------
    known : mapping of (float, Sun or None) to mapping of str to ndarray (C, B)
        Terms of the columns at some times with their sun, None where radiance is computed without.
    own_views : bool
        Whether pixels have views of their own.
    """
    ends = columns.ends
    totals = {frame: np.sum(list(terms.values()), axis=0)[ends] for frame, terms in known.items()}
    columns = columns.only(ends)
    if not own_views:
        yield _one_view(assembly, columns, {sun: total for (_, sun), total in totals.items()})
    lit = [(corner_suns(assembly, track, time_s), total) for (time_s, sun), total in totals.items() if sun is not None]
    if lit:
        bound = _bound_of_suns(assembly, columns, lit)
        told = "providers do not know it in the corners" if bound is None else "the bound is for the corners"
        yield Omission("sun angles of single pixels", f"the sun is that of the image centre; {told}", bound)


def _one_view(assembly: Assembly, columns: FewColumns, known: Mapping[Sun | None, Array]) -> Omission:
    views, apart = corner_views(assembly)
    bound = _bound_of_views(assembly, columns, views, known)
    lines = assembly.lines_of_sight
    altitude_km = (SENSOR_ALTITUDE_M if lines is None else lines.altitude_m) / 1e3
    corners = f"corners of the image seen from {altitude_km:.0f} km, {apart:.2g} deg off"
    return Omission(
        "view angles of single pixels",
        "rays are parallel, one direction for the whole image; "
        + (f"providers do not know {corners}" if bound is None else f"the bound is for {corners}"),
        bound,
    )


def corner_views(assembly: Assembly) -> tuple[tuple[View, ...], float]:
    """Return the view from two neighbouring corners of the image, and how far it turns, in degrees.

    To first order the other corners differ by as much the other way. That whose zenith angle changes more is first.
    """
    lines = assembly.lines_of_sight
    views = _far_views(assembly) if lines is None else ImageViews(assembly.grid, lines).at(_CORNERS)
    apart = max(_between_deg(view, assembly.view) for view in views)
    return tuple(sorted(views, key=lambda view: -abs(view.zenith_deg - assembly.view.zenith_deg))), apart


def _far_views(assembly: Assembly) -> list[View]:
    """Return the view from the corners as if the sensor were at a common altitude over a flat Earth."""
    zenith, azimuth = math.radians(assembly.view.zenith_deg), math.radians(assembly.view.azimuth_deg)
    aside = SENSOR_ALTITUDE_M * math.tan(zenith)
    sensor = np.array([aside * math.sin(azimuth), aside * math.cos(azimuth), SENSOR_ALTITUDE_M])
    views = []
    for x, y in _corners_m(assembly):
        ray = sensor - np.array([x, y, 0.0])
        bearing = math.degrees(math.atan2(ray[0], ray[1])) % 360.0
        views.append(View(math.degrees(math.atan2(math.hypot(ray[0], ray[1]), ray[2])), bearing))
    return views


def _between_deg(one: View, other: View) -> float:
    """Angle between two directions."""
    a, b = (_direction(view) for view in (one, other))
    return math.degrees(math.atan2(float(np.linalg.norm(np.cross(a, b))), float(a @ b)))


def _direction(view: View) -> Array:
    zenith, azimuth = math.radians(view.zenith_deg), math.radians(view.azimuth_deg)
    across = math.sin(zenith)
    return np.array([across * math.sin(azimuth), across * math.cos(azimuth), math.cos(zenith)])


def corner_suns(assembly: Assembly, track: SunTrack, time_s: float) -> tuple[Sun | None, ...]:
    """Return the sun at two neighbouring corners of the image, None below the horizon, as :func:`corner_views`."""
    zenith = track.at(time_s).zenith_deg
    suns = [track.at(time_s, corner) for corner in _corners_m(assembly)]
    suns.sort(key=lambda sun: -abs(sun.zenith_deg - zenith))
    return tuple(sun if sun.is_up else None for sun in suns)


def _corners_m(assembly: Assembly) -> tuple[tuple[float, float], ...]:
    """Outer edges of the image in the north-east and south-east."""
    grid = assembly.grid
    x, y = 0.5 * grid.columns * grid.pixel_size_m, 0.5 * grid.rows * grid.pixel_size_m
    return tuple((across * x, up * y) for across, up in _CORNERS)


def _bound_of_views(
    assembly: Assembly, columns: FewColumns, views: Sequence[View], known: Mapping[Sun | None, Array]
) -> float | None:
    """Return the bound; None where providers do not know other views, as imported atmospheres of one angle."""
    low, high = assembly.transmittance.declares.valid.get("view_zenith", (0.0, 90.0))
    if not all(low <= view.zenith_deg <= high for view in views):
        return None
    largest = 0.0
    try:
        for corner, view in enumerate(views):
            model = assembly.model_toward(view)
            for sun, total in known.items():
                largest = max(largest, _change(columns, model, sun, total, corner))
    except (ProviderError, ScenarioError):
        return None
    return SAFETY_FACTOR * largest


def _bound_of_suns(
    assembly: Assembly, columns: FewColumns, lit: Sequence[tuple[Sequence[Sun | None], Array]]
) -> float | None:
    """Return the bound; None where the sun is so low in a corner that providers do not know it."""
    largest = 0.0
    try:
        for corners, total in lit:
            for corner, sun in enumerate(corners):
                largest = max(largest, _change(columns, assembly.model, sun, total, corner))
    except ProviderError:
        return None
    return SAFETY_FACTOR * largest


def _change(columns: FewColumns, model: RadianceModel, sun: Sun | None, known: Array, corner: int) -> float:
    """Return the largest change; in corners but the first that of clear sky alone, which feels bearings most."""
    if corner == 0 or not columns.clear:
        return largest_change(columns.total(model, sun), known)
    return largest_change(columns.only(np.zeros(1, dtype=np.intp)).total(model, sun), known[:1])
