"""CCSDS orbit and attitude ephemeris messages (OEM, AEM), in their text form (KVN) or in XML.

Sources: CCSDS 502.0-B-3, "Orbit Data Messages" (2023), section 5; CCSDS 504.0-B-2, "Attitude Data Messages" (2024),
section 4.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from datetime import datetime, timedelta
from pathlib import Path
from typing import TypeVar

import numpy as np
from scipy.spatial.transform import Rotation

from hcss_payload.attitude import Attitude, AttitudeTable
from hcss_payload.checks import PayloadError, require_utc
from hcss_payload.earth_rotation import EarthOrientation, days_since_2000
from hcss_payload.examination import largest_turn_rad, require_consistent_velocities, require_radius
from hcss_payload.message_text import SCALES, message_lines, shown, utc_of
from hcss_payload.spans import Spans
from hcss_payload.trajectory import LARGEST_DEGREE, USUAL_DEGREE, PositionTable, Trajectory, velocity_m_s
from hcss_twin.core.arguments import checked
from hcss_twin.core.files import Writing

_AnyTable = TypeVar("_AnyTable", PositionTable, AttitudeTable)

BODY_FRAME, EARTH_FRAME = "SC_BODY_1", "ITRF2020"

_OEM, _AEM = "CCSDS_OEM_VERS", "CCSDS_AEM_VERS"

_VERSIONS = {_OEM: ("1.0", "2.0", "3.0"), _AEM: ("1.0", "2.0")}

_MARKS = {
    "META_START": "metadata",
    "META_STOP": "data",
    "DATA_START": "data",
    "DATA_STOP": "between",
    "COVARIANCE_START": "covariance",
    "COVARIANCE_STOP": "between",
}
"""Lines that begin and end parts of a message, and the part that follows."""

_FRAMES = {r"ITRF[-_ ]?\d*|WGS-?84": "", "TEME": "TEME", r"GCRF|ICRF[-_ ]?\d*": "GCRF", "EME2000|J2000": "EME2000"}
"""Names of reference frames as patterns; of those that do not turn with the Earth, the name of the turn."""

_WIDE_RAD = 0.2
"""Turn between points up to which velocities are left out where no interpolation is stated: through eight positions the
error is below 0.5 m in low orbits at the ends, too, and velocities are often rounded, or means over some seconds."""

_SLACK = timedelta(seconds=1)
"""By how much states may lie outside START_TIME to STOP_TIME, which some programs round."""


@dataclass(frozen=True)
class _Segment:
    """Keys of one block of metadata, and the numbers and times of its lines."""

    path: Path
    line: int
    keys: dict[str, str] = field(default_factory=dict)
    times: list[datetime] = field(default_factory=list)
    values: list[list[float]] = field(default_factory=list)
    lines: list[int] = field(default_factory=list)

    @property
    def where(self) -> str:
        """File and first line, for messages."""
        return f"{self.path}: segment of line {self.line}"

    def one_of(self, key: str, allowed: str, pattern: str) -> str:
        """Return the value of a key of which only some values can be read."""
        value = self.keys.get(key, "missing").upper()
        if not re.fullmatch(pattern, value):
            raise PayloadError(f"{self.where}: {key} {self.keys.get(key, 'missing')}; allowed: {allowed}")
        return value

    def utc(self, text: str, where: str) -> datetime:
        """Return a time of the segment's scale in UTC."""
        return utc_of(text, where, self.one_of("TIME_SYSTEM", ", ".join(SCALES), "|".join(SCALES)))

    def usable_s(self, start: datetime) -> tuple[float, float]:
        """Return the first and last time that may be used, which the times of the keys must contain."""
        known = {
            key: self.utc(self.keys[key], f"{self.where}: {key}")
            for key in ("START_TIME", "USEABLE_START_TIME", "USEABLE_STOP_TIME", "STOP_TIME")
            if key in self.keys
        }
        first, last = self.times[0], self.times[-1]
        begin, end = known.get("USEABLE_START_TIME", first), known.get("USEABLE_STOP_TIME", last)
        problems = {
            "USEABLE_START_TIME": not first - _SLACK <= begin < end,
            "USEABLE_STOP_TIME": end > last + _SLACK,
            "START_TIME": known.get("START_TIME", first) > first + _SLACK,
            "STOP_TIME": known.get("STOP_TIME", last) < last - _SLACK,
        }
        for key, wrong in problems.items():
            if wrong:
                raise PayloadError(
                    f"{self.where}: {key} {self.keys.get(key)}, with states from {_stamp(first)} to {_stamp(last)}; "
                    "allowed: START_TIME, first state, USEABLE_START_TIME, USEABLE_STOP_TIME, last state and STOP_TIME "
                    "in this order"
                )
        first_s, last_s = _seconds([max(begin, first), min(end, last)], start)
        return first_s, last_s


@checked
def read_oem(path: str | Path, start: datetime, orientation: EarthOrientation | None = None) -> Spans[PositionTable]:
    """Return the trajectory of an orbit ephemeris message.

    Each segment holds in its usable span. Its interpolation is the one that it states (HERMITE, LAGRANGE or LINEAR),
    otherwise of degree 7, with velocities where points are far apart or few.

    Parameters
    ----------
    start : datetime
        Time 0 of the trajectory, in UTC.
    orientation : EarthOrientation, optional
        For positions in frames that do not turn with the Earth.

    Raises
    ------
    PayloadError
        If the file is not such a message of one object around the Earth, in a frame and time scale that can be read, or
        its states are impossible.
    """
    segments = _read(Path(path), _OEM)
    tables = [_positions(segment, start, orientation or EarthOrientation()) for segment in segments]
    return _spans("trajectory", segments, tables, start)


def _positions(segment: _Segment, start: datetime, earth: EarthOrientation) -> PositionTable:
    where = segment.where
    segment.one_of("CENTER_NAME", "EARTH", "EARTH")
    named = segment.one_of("REF_FRAME", "ITRF, TEME, GCRF, ICRF, EME2000", "|".join(_FRAMES))
    frame = next(frame for pattern, frame in _FRAMES.items() if re.fullmatch(pattern, named))
    if frame == "TEME" and "REF_FRAME_EPOCH" in segment.keys:
        raise PayloadError(
            f"{where}: REF_FRAME_EPOCH {segment.keys['REF_FRAME_EPOCH']} with TEME; allowed: TEME of date"
        )
    count = len(segment.values[0])
    if count not in (3, 6, 9):
        raise PayloadError(f"{where}: line {segment.lines[0]}: {count} numbers; allowed: 6, 9 with accelerations, or 3")
    states = 1e3 * np.array(segment.values)
    positions, velocities = states[:, :3], states[:, 3:6] if count > 3 else None
    require_radius(where, segment.lines, positions)
    if frame:
        days = [days_since_2000(time) for time in segment.times]
        positions, velocities = earth.states(frame, positions, velocities, days)
    times_s = np.array(_seconds(segment.times, start))
    if velocities is not None:
        require_consistent_velocities(where, segment.lines, times_s, positions, velocities)
    hermite, degree = _interpolation(segment, velocities is not None)
    if "INTERPOLATION" not in segment.keys and times_s.size > USUAL_DEGREE:
        hermite = hermite and largest_turn_rad(times_s, positions) > _WIDE_RAD
    return PositionTable(times_s, positions, velocities if hermite else None, degree)


def _interpolation(segment: _Segment, has_velocities: bool) -> tuple[bool, int]:
    """Return whether the interpolation uses velocities, and its degree."""
    if "INTERPOLATION" not in segment.keys:
        return has_velocities, USUAL_DEGREE
    method = segment.one_of("INTERPOLATION", "HERMITE, LAGRANGE, LINEAR", "HERMITE|LAGRANGE|LINEAR")
    if method == "HERMITE" and not has_velocities:
        raise PayloadError(
            f"{segment.where}: INTERPOLATION HERMITE without velocities; allowed: with them, or LAGRANGE"
        )
    most = 1 if method == "LINEAR" else LARGEST_DEGREE
    text = segment.keys.get("INTERPOLATION_DEGREE", str(min(USUAL_DEGREE, most)))
    if not (text.isdecimal() and 1 <= int(text) <= most):
        raise PayloadError(
            f"{segment.where}: INTERPOLATION_DEGREE {text} with INTERPOLATION {method}; allowed: 1 to {most}"
        )
    return method == "HERMITE", int(text)


def _spans(field: str, segments: Sequence[_Segment], tables: Sequence[_AnyTable], start: datetime) -> Spans[_AnyTable]:
    """Return the tables of the segments of one object, whose usable spans follow one another."""
    for key in ("OBJECT_ID", "OBJECT_NAME"):
        objects = list(dict.fromkeys(segment.keys[key] for segment in segments if key in segment.keys))
        if len(objects) > 1:
            raise PayloadError(f"{segments[0].path}: {key} {', '.join(objects)}; allowed: segments of one object")
    found = zip(segments, tables, (table.usable_s(start) for table in segments), strict=True)
    ordered = sorted(found, key=lambda found_span: found_span[2])
    for (_, _, before), (segment, _, after) in itertools.pairwise(ordered):
        if after[0] < before[1]:
            raise PayloadError(
                f"{segment.where}: usable from {after[0]:g} s, and the segment before it up to {before[1]:g} s after "
                "the start; allowed: segments whose usable spans do not overlap"
            )
    return Spans(field, [table for _, table, _ in ordered], [usable for _, _, usable in ordered])


@checked
def write_oem(path: str | Path, trajectory: Trajectory, start: datetime, times_s: Sequence[float], name: str) -> None:
    """Write a trajectory at some times, in ITRF, as an orbit ephemeris message."""
    lines = []
    for time_s in times_s:
        state = np.concatenate((trajectory.at(time_s), velocity_m_s(trajectory, time_s))) / 1e3
        lines.append(f"{_utc(start, time_s)} " + " ".join(f"{value:.9f}" for value in state))
    keys = {"CENTER_NAME": "EARTH", "REF_FRAME": EARTH_FRAME}
    _write(Path(path), (_OEM, "2.0"), keys, start, times_s, name, lines, data_marks=False)


@checked
def read_aem(path: str | Path, start: datetime) -> Spans[AttitudeTable]:
    """Return the attitude of an attitude ephemeris message with quaternions between the body and ITRF.

    Each segment holds in its usable span.

    Parameters
    ----------
    start : datetime
        Time 0 of the attitude, in UTC.

    Raises
    ------
    PayloadError
        If the file is not such a message of one object.
    """
    segments = _read(Path(path), _AEM)
    return _spans("attitude", segments, [_quaternions(segment, start) for segment in segments], start)


def _quaternions(segment: _Segment, start: datetime) -> AttitudeTable:
    """Return the turns of a segment.

    The standard's quaternion from A to B turns the axes of A into those of B, so that its inverse turns components.
    """
    segment.one_of("ATTITUDE_TYPE", "QUATERNION", "QUATERNION")
    first, second = (segment.one_of(f"REF_FRAME_{side}", "ITRF, SC_", "(ITRF|SC_).*") for side in "AB")
    if first.startswith("ITRF") == second.startswith("ITRF"):
        raise PayloadError(
            f"{segment.where}: REF_FRAME_A {first}, REF_FRAME_B {second}; allowed: ITRF and a frame SC_..."
        )
    values = np.array([line[:4] for line in segment.values])
    # Version 2 of the standard has no such keys: its scalar part is last, and its direction from A to B.
    if segment.keys.get("QUATERNION_TYPE", "LAST").upper() == "FIRST":
        values = np.roll(values, -1, axis=1)
    backward = segment.keys.get("ATTITUDE_DIR", "A2B").upper() == "B2A"
    # A turn of ITRF's axes into those of the body is also the turn of components in the body into those in ITRF.
    if first.startswith("ITRF") == backward:
        values = values * np.array([-1.0, -1.0, -1.0, 1.0])
    return AttitudeTable(np.array(_seconds(segment.times, start)), values)


@checked
def write_aem(path: str | Path, attitude: Attitude, start: datetime, times_s: Sequence[float], name: str) -> None:
    """Write an attitude at some times as an attitude ephemeris message, from ITRF to the body."""
    lines = []
    for time_s in times_s:
        unit = Rotation.from_quat(attitude.at(time_s)).as_quat(canonical=True)
        lines.append(f"{_utc(start, time_s)} " + " ".join(f"{value:.15f}" for value in unit))
    keys = {
        "REF_FRAME_A": EARTH_FRAME,
        "REF_FRAME_B": BODY_FRAME,
        "ATTITUDE_DIR": "A2B",
        "ATTITUDE_TYPE": "QUATERNION",
        "QUATERNION_TYPE": "LAST",
    }
    _write(Path(path), (_AEM, "1.0"), keys, start, times_s, name, lines, data_marks=True)


def _read(path: Path, version: str) -> list[_Segment]:
    """Read the segments of a message; comments and covariances are skipped."""
    header: dict[str, str] = {}
    segments: list[_Segment] = []
    part = "header"
    for number, line in message_lines(path):
        if not line or line.split()[0] == "COMMENT":
            continue
        if line in _MARKS:
            part = _MARKS[line]
            if line == "META_START":
                segments.append(_Segment(path, number))
        elif part == "data" and "=" not in line:
            _add_state(segments[-1], number, line, version)
        elif part in ("header", "metadata"):
            keys = header if part == "header" else segments[-1].keys
            key, equals, value = (word.strip() for word in line.partition("="))
            if not equals or key in keys:
                raise PayloadError(f"{path}: line {number}: {shown(line)!r}; allowed: KEY = value, each key once")
            keys[key] = value
        elif part != "covariance":
            raise PayloadError(
                f"{path}: line {number}: {shown(line)!r} is no state; allowed: a block that begins with META_START"
            )
    if version not in header:
        raise PayloadError(f"{path}: no {version}; allowed: a message of this kind, as text (KVN) or XML")
    if header[version] not in _VERSIONS[version]:
        raise PayloadError(f"{path}: {version} {header[version]}; allowed: {', '.join(_VERSIONS[version])}")
    short = next((segment for segment in segments if len(segment.times) < 2), None)
    if short is not None or not segments:
        where = path if short is None else short.where
        raise PayloadError(f"{where}: {0 if short is None else len(short.times)} states; allowed: two or more")
    return segments


def _add_state(segment: _Segment, number: int, line: str, version: str) -> None:
    """Add a line with a time and numbers to a segment."""
    where = f"{segment.path}: line {number}"
    time, *fields = line.split()
    try:
        moment, values = segment.utc(time, where), [float(number) for number in fields]
    except ValueError as error:
        raise PayloadError(f"{where}: {shown(line)!r} is no time with numbers") from error
    if not np.all(np.isfinite(values)):
        raise PayloadError(f"{where}: {shown(line)!r} is not finite; allowed: finite numbers")
    count = len(segment.values[0]) if segment.values else len(values)
    if len(values) != count or count < 4 - (version == _OEM):
        raise PayloadError(f"{where}: {len(values)} numbers; allowed: as many as in a state")
    if segment.times and moment <= segment.times[-1]:
        raise PayloadError(f"{where}: {time} is not later than the epoch before; allowed: epochs that ascend")
    segment.times.append(moment)
    segment.values.append(values)
    segment.lines.append(number)


def _stamp(time: datetime) -> str:
    return time.strftime("%Y-%m-%dT%H:%M:%S.%f")


def _seconds(times: Sequence[datetime], start: datetime) -> list[float]:
    require_utc("start", start)
    return [(time - start).total_seconds() for time in times]


def _utc(start: datetime, time_s: float) -> str:
    return _stamp(start + timedelta(seconds=float(time_s)))


def _write(
    path: Path,
    version: tuple[str, str],
    keys: dict[str, str],
    start: datetime,
    times_s: Sequence[float],
    name: str,
    lines: Sequence[str],
    *,
    data_marks: bool,
) -> None:
    """Write a message with one segment."""
    require_utc("start", start)
    if not len(times_s):
        raise PayloadError("times_s: no times; allowed: one or more")
    header = {version[0]: version[1], "CREATION_DATE": _utc(start, 0.0), "ORIGINATOR": "HCSS_TWIN"}
    span = {"START_TIME": _utc(start, times_s[0]), "STOP_TIME": _utc(start, times_s[-1])}
    meta = {"OBJECT_NAME": name, "OBJECT_ID": name, **keys, "TIME_SYSTEM": "UTC", **span}
    text = [
        *(f"{key} = {value}" for key, value in header.items()),
        "META_START",
        *(f"{key} = {value}" for key, value in meta.items()),
        "META_STOP",
        *(["DATA_START"] if data_marks else []),
        *lines,
        *(["DATA_STOP"] if data_marks else []),
    ]
    with Writing(path, PayloadError) as draft:
        draft.write_text("\n".join(text) + "\n", encoding="utf-8")
