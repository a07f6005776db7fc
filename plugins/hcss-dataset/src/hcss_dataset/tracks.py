"""Curved tracks of targets: great circles, and those of a table."""

from __future__ import annotations

import csv
import math
from functools import lru_cache
from pathlib import Path

import numpy as np

from hcss_dataset.errors import DatasetError
from hcss_twin.core.reading import Reading
from hcss_twin.providers import EARTH_RADIUS_M, Array

TRACKS = ("level", "great-circle")
"""Forms of tracks besides a table."""

_POINTS = 33
_PLANE, _GLOBE = ("x", "y"), ("latitude", "longitude")

Track = tuple[tuple[float, float, float, float], ...]
"""Points [time, x, y, altitude] of a track, s and m."""


def great_circle(
    start_m: tuple[float, float],
    altitude_m: float,
    speed_m_s: float,
    heading_deg: float,
    times_s: Array,
    first_s: float,
) -> Array:
    """Return x and y (N, 2) at times of what flies along a great circle, in the plane of the image.

    The plane shows distance and bearing from its centre truly. The Earth is a sphere here; headings are from the y axis
    of the plane, which is carried along from its centre.

    Parameters
    ----------
    start_m : (float, float)
        East and north at ``first_s``.
    """
    away, bearing = math.hypot(*start_m) / EARTH_RADIUS_M, math.atan2(*start_m)
    radial = np.array([math.cos(away) * math.sin(bearing), math.cos(away) * math.cos(bearing), -math.sin(away)])
    across = np.array([math.cos(bearing), -math.sin(bearing), 0.0])
    place = np.array([math.sin(away) * math.sin(bearing), math.sin(away) * math.cos(bearing), math.cos(away)])
    turn = math.radians(heading_deg) - bearing
    ahead = math.cos(turn) * radial + math.sin(turn) * across
    angle = ((times_s - first_s) * speed_m_s / (EARTH_RADIUS_M + altitude_m))[:, None]
    there = place * np.cos(angle) + ahead * np.sin(angle)
    flat = np.hypot(there[:, 0], there[:, 1])
    distance = EARTH_RADIUS_M * np.arctan2(flat, there[:, 2])
    return distance[:, None] * there[:, :2] / np.where(flat > 0.0, flat, 1.0)[:, None]


def great_circle_path(
    start_m: tuple[float, float], altitude_m: float, speed_m_s: float, heading_deg: float, times_s: tuple[float, float]
) -> Track:
    """Return the points of a great circle from a second before the first time to a second after the last."""
    times = np.linspace(times_s[0] - 1.0, times_s[1] + 1.0, _POINTS)
    places = great_circle(start_m, altitude_m, speed_m_s, heading_deg, times, times_s[0])
    return tuple((float(time), float(x), float(y), altitude_m) for time, (x, y) in zip(times, places, strict=True))


@lru_cache(8)
def read_tracks(path: Path) -> tuple[Array, ...]:
    """Return the tracks of a CSV file, each with rows of time, x, y and altitude.

    Columns are source, time (s), altitude (m), and x and y (m) or latitude and longitude (degrees), of which only
    differences from the first row of a source count.

    Raises
    ------
    DatasetError
        If the file cannot be read, lacks a column, or times do not ascend.
    """
    with Reading(path, DatasetError), path.open(encoding="utf-8-sig", newline="") as file:
        rows = list(csv.DictReader((line for line in file if not line.startswith("#")), skipinitialspace=True))
    names = set(rows[0]) if rows else set()
    across = _GLOBE if _GLOBE[0] in names else _PLANE
    missing = [name for name in ("source", "time", *across, "altitude") if name not in names]
    if missing:
        raise DatasetError(
            f"{path}: column '{missing[0]}' is missing; allowed: source, time, x, y or latitude, longitude, "
            "and altitude"
        )
    try:
        sources = [row["source"] for row in rows]
        values = np.array([[float(row[name]) for name in ("time", *across, "altitude")] for row in rows])
    except (TypeError, ValueError) as error:
        raise DatasetError(f"{path}: {error}; allowed: numbers") from error
    tracks = []
    for source in dict.fromkeys(sources):
        track = values[[each == source for each in sources]]
        if len(track) < 2 or np.any(np.diff(track[:, 0]) <= 0.0) or not np.all(np.isfinite(track)):
            raise DatasetError(f"{path}: source {source}: allowed: at least two finite rows whose times ascend")
        if np.any(track[:, 3] < 0.0):
            raise DatasetError(f"{path}: source {source}: altitude {track[:, 3].min():g}; allowed: 0 or more")
        tracks.append(_on_plane(track) if across == _GLOBE else track)
    return tuple(tracks)


def _on_plane(track: Array) -> Array:
    """Return a track in degrees as m east and north of its first row, by distance and bearing on a sphere."""
    latitude, longitude = np.radians(track[:, 1]), np.radians(track[:, 2] - track[0, 2])
    first = latitude[0]
    toward_east = np.cos(latitude) * np.sin(longitude)
    toward_north = np.cos(first) * np.sin(latitude) - np.sin(first) * np.cos(latitude) * np.cos(longitude)
    up = np.sin(first) * np.sin(latitude) + np.cos(first) * np.cos(latitude) * np.cos(longitude)
    flat = np.hypot(toward_east, toward_north)
    scale = EARTH_RADIUS_M * np.arctan2(flat, up) / np.where(flat > 0.0, flat, 1.0)
    return np.column_stack((track[:, 0], scale * toward_east, scale * toward_north, track[:, 3]))


def table_path(track: Array, start_m: tuple[float, float], times_s: tuple[float, float]) -> Track:
    """Return a track of a table from a place and a time on, longer by a second at both ends in straight lines.

    Raises
    ------
    ValueError
        If it is shorter than the sequence.
    """
    lasts, wanted = track[-1, 0] - track[0, 0], times_s[1] - times_s[0]
    if lasts < wanted:
        raise ValueError(f"track of {lasts:g} s in a sequence of {wanted:g} s; allowed: a table of longer tracks")
    moved = track - [track[0, 0] - times_s[0], track[0, 1] - start_m[0], track[0, 2] - start_m[1], 0.0]
    before, after = (
        moved[end] + (moved[end] - moved[next_to]) / abs(moved[end, 0] - moved[next_to, 0])
        for end, next_to in ((0, 1), (-1, -2))
    )
    whole = np.vstack((before, moved, after))
    whole[:, 3] = np.maximum(whole[:, 3], 0.0)
    return tuple((float(time), float(x), float(y), float(z)) for time, x, y, z in whole)


def position_at(path: Track, time_s: float) -> tuple[float, float, float]:
    """Return the place on a track at a time, linear between its points."""
    times, *places = zip(*path, strict=True)
    x, y, z = (float(np.interp(time_s, times, values)) for values in places)
    return x, y, z


def velocity_at(path: Track, time_s: float) -> tuple[float, float, float]:
    """Return the velocity on a track at a time."""
    points = np.array(path)
    after = int(np.clip(np.searchsorted(points[:, 0], time_s, side="right"), 1, len(points) - 1))
    rate = np.diff(points[after - 1 : after + 1], axis=0)[0]
    east, north, up = (float(each) for each in rate[1:] / rate[0])
    return east, north, up
