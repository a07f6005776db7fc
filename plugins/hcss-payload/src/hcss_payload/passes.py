"""Passes of a camera above a place: when, and how high."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from datetime import datetime, timedelta

import numpy as np

from hcss_payload.checks import NoStateAtTimeError
from hcss_payload.ray_geometry import LARGEST_ZENITH_DEG
from hcss_payload.trajectory import Trajectory
from hcss_twin.physics.geodesy import Ellipsoid
from hcss_twin.physics.sun import sun_position
from hcss_twin.providers import Array

STEP_S = 60.0
"""Step between which an elevation has at most one maximum: low orbits take ten minutes from horizon to horizon."""

LOWEST_DEG = 90.0 - LARGEST_ZENITH_DEG
"""Elevation from which cameras see the ground."""

AHEAD_S = 3.0 * 86400.0
"""How far ahead the next pass is looked for."""


@dataclass(frozen=True)
class Pass:
    """A pass above a place.

    Attributes
    ----------
    rise_s, set_s : float or None
        When the elevation passes its lowest allowed value; None: before, or after the times that were searched.
    highest_s : float
        Time of the highest elevation.
    highest_deg, azimuth_deg : float
        Elevation, geometric, and bearing of the camera at that time.
    sun_deg : float
        Elevation of the sun at that time.
    """

    rise_s: float | None
    highest_s: float
    set_s: float | None
    highest_deg: float
    azimuth_deg: float
    sun_deg: float


def direction_deg(trajectory: Trajectory, place_deg: tuple[float, float], time_s: float) -> tuple[float, float]:
    """Return elevation and bearing of a camera seen from a place of the ellipsoid; NaN where its table has no time."""
    place = np.float64(place_deg[0]), np.float64(place_deg[1])
    ground_m: Array = Ellipsoid.to_earth_centred(*place)  # type: ignore[arg-type]
    try:
        away: Array = trajectory.at(time_s) - ground_m
    except NoStateAtTimeError:
        return np.nan, np.nan
    east, north, up = (float(axis @ away) for axis in Ellipsoid.east_north_up(*place))  # type: ignore[arg-type]
    return float(np.degrees(np.arctan2(up, np.hypot(east, north)))), float(np.degrees(np.arctan2(east, north)) % 360.0)


def find_passes(
    trajectory: Trajectory,
    place_deg: tuple[float, float],
    start: datetime,
    first_s: float,
    last_s: float,
    lowest_deg: float = LOWEST_DEG,
) -> tuple[Pass, ...]:
    """Return the passes between two times, in their order.

    Parameters
    ----------
    start : datetime
        Time 0, in UTC.
    lowest_deg : float
        Elevation that a pass exceeds.
    """

    def elevation(time_s: float) -> float:
        return direction_deg(trajectory, place_deg, time_s)[0]

    times = np.linspace(first_s, last_s, max(int(np.ceil((last_s - first_s) / STEP_S)), 1) + 1)
    heights = np.array([elevation(time_s) for time_s in times.tolist()])
    found: list[tuple[float, float]] = []
    for at_s, highest_deg in _maxima(elevation, times, heights):
        if highest_deg <= lowest_deg:
            continue
        between = (times > found[-1][0]) & (times < at_s) if found else np.zeros(times.size, np.bool_)
        if found and not np.any(heights[between] < lowest_deg):  # two maxima of one pass
            found[-1] = max(found[-1], (at_s, highest_deg), key=lambda each: each[1])
        else:
            found.append((at_s, highest_deg))
    passes = []
    for at_s, highest_deg in found:
        before, after = times < at_s, times > at_s
        ends = [
            _crossing(elevation, times[side][::step], heights[side][::step], at_s, lowest_deg)
            for side, step in ((before, -1), (after, 1))
        ]
        azimuth = direction_deg(trajectory, place_deg, at_s)[1]
        sun = 90.0 - float(sun_position([start + timedelta(seconds=at_s)], *place_deg)[0][0])
        passes.append(Pass(ends[0], at_s, ends[1], highest_deg, azimuth, sun))
    return tuple(passes)


def _maxima(elevation: Callable[[float], float], times: Array, heights: Array) -> Iterator[tuple[float, float]]:
    """Yield time and height of each maximum; those at the ends of what is known, too."""
    from scipy.optimize import minimize_scalar  # cameras need no passes, and a server must start quickly

    beside = np.concatenate(([np.nan], heights, [np.nan]))
    for index in np.flatnonzero(~(beside[:-2] >= heights) & ~(beside[2:] > heights) & ~np.isnan(heights)).tolist():
        known = [other for other in (index - 1, index, index + 1) if not np.isnan(beside[other + 1])]
        low_s, high_s = float(times[known[0]]), float(times[known[-1]])
        at_s, highest_deg = float(times[index]), float(heights[index])
        if high_s > low_s:
            peak = minimize_scalar(lambda time_s: -elevation(time_s), bounds=(low_s, high_s), options={"xatol": 1e-3})
            if -peak.fun > highest_deg:
                at_s, highest_deg = float(peak.x), -float(peak.fun)
        yield at_s, highest_deg


def _crossing(
    elevation: Callable[[float], float], outward_s: Array, heights: Array, highest_s: float, lowest_deg: float
) -> float | None:
    """Return when the elevation passes its lowest value on the way from the highest; None if that is not known."""
    from scipy.optimize import brentq

    outside = np.flatnonzero(~(heights >= lowest_deg))
    if not outside.size or np.isnan(heights[outside[0]]):
        return None
    beyond_s = float(outward_s[outside[0]])
    return float(brentq(lambda time_s: elevation(time_s) - lowest_deg, beyond_s, highest_s, xtol=1e-3))


def next_pass(trajectory: Trajectory, place_deg: tuple[float, float], start: datetime, after_s: float) -> str:
    """Return a sentence on the next pass from which a camera sees the ground at a place."""
    found = find_passes(trajectory, place_deg, start, after_s, after_s + AHEAD_S)
    where = f"{place_deg[0]:g} N {place_deg[1]:g} E"
    if not found:
        return f"no pass above {LOWEST_DEG:g} deg at {where} within {AHEAD_S / 86400.0:g} days"
    highest = start + timedelta(seconds=found[0].highest_s)
    return (
        f"the next pass above {LOWEST_DEG:g} deg at {where} is highest, {found[0].highest_deg:.0f} deg, at "
        f"{highest.isoformat(timespec='seconds')} (hcss passes lists them)"
    )
