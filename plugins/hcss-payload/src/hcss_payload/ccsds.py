"""CCSDS orbit and attitude ephemeris messages (OEM, AEM) in their text form (KVN).

Sources: CCSDS 502.0-B-3, "Orbit Data Messages" (2023), section 5; CCSDS 504.0-B-2, "Attitude Data Messages" (2024),
section 4. Positions in ITRF or TEME are read; other frames need precession and nutation, which other tools provide.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from hcss_payload.attitude import Attitude, AttitudeTable
from hcss_payload.checks import PayloadError, require_utc
from hcss_payload.earth_rotation import EarthOrientation, days_since_2000
from hcss_payload.trajectory import PositionTable, Trajectory, velocity_m_s
from hcss_twin.core.arguments import checked
from hcss_twin.core.files import atomic_write
from hcss_twin.core.reading import reading

BODY_FRAME, EARTH_FRAME = "SC_BODY_1", "ITRF2020"


@dataclass(frozen=True)
class _Segment:
    """Keys of one block of metadata, and the numbers and times of its lines."""

    keys: dict[str, str]
    times: list[datetime]
    values: list[list[float]]

    def one_of(self, path: Path, key: str, allowed: Sequence[str]) -> str:
        """Return the value of a key of which only some values can be read; a value may begin like an allowed one."""
        value = self.keys.get(key, "missing")
        if not any(value.upper().startswith(each) for each in allowed):
            raise PayloadError(f"{path}: {key} {value}; allowed: {', '.join(allowed)}")
        return value.upper()


@checked
def read_oem(path: str | Path, start: datetime, orientation: EarthOrientation | None = None) -> PositionTable:
    """Return the trajectory of an orbit ephemeris message.

    Parameters
    ----------
    start : datetime
        Time 0 of the trajectory, in UTC.
    orientation : EarthOrientation, optional
        For positions in TEME.

    Raises
    ------
    PayloadError
        If the file is not such a message with one segment in UTC and ITRF or TEME.
    """
    path = Path(path)
    segment = _read(path, "CCSDS_OEM_VERS")
    frame = segment.one_of(path, "REF_FRAME", ("ITRF", "TEME"))
    positions = 1e3 * np.array([line[:3] for line in segment.values])
    if frame.startswith("TEME"):
        earth = orientation or EarthOrientation()
        days = [days_since_2000(time) for time in segment.times]
        positions = np.array([earth.earth_fixed(each, day) for each, day in zip(positions, days, strict=True)])
    return PositionTable(_seconds(segment.times, start), positions)  # type: ignore[arg-type]


@checked
def write_oem(path: str | Path, trajectory: Trajectory, start: datetime, times_s: Sequence[float], name: str) -> None:
    """Write a trajectory at some times, in ITRF, as an orbit ephemeris message."""
    lines = []
    for time_s in times_s:
        state = np.concatenate((trajectory.at(time_s), velocity_m_s(trajectory, time_s))) / 1e3
        lines.append(f"{_utc(start, time_s)} " + " ".join(f"{value:.9f}" for value in state))
    keys = {"CENTER_NAME": "EARTH", "REF_FRAME": EARTH_FRAME}
    _write(Path(path), ("CCSDS_OEM_VERS", "2.0"), keys, start, times_s, name, lines, data_marks=False)


@checked
def read_aem(path: str | Path, start: datetime) -> AttitudeTable:
    """Return the attitude of an attitude ephemeris message with quaternions between the body and ITRF.

    The standard's quaternion from A to B turns the axes of A into those of B, so that its inverse turns components.

    Parameters
    ----------
    start : datetime
        Time 0 of the attitude, in UTC.

    Raises
    ------
    PayloadError
        If the file is not such a message with one segment.
    """
    path = Path(path)
    segment = _read(path, "CCSDS_AEM_VERS")
    if segment.one_of(path, "ATTITUDE_TYPE", ("QUATERNION",)) != "QUATERNION":
        raise PayloadError(f"{path}: ATTITUDE_TYPE {segment.keys['ATTITUDE_TYPE']}; allowed: QUATERNION")
    first, second = (segment.one_of(path, f"REF_FRAME_{each}", ("ITRF", "SC_")) for each in "AB")
    if first.startswith("ITRF") == second.startswith("ITRF"):
        raise PayloadError(f"{path}: REF_FRAME_A {first}, REF_FRAME_B {second}; allowed: ITRF and a frame SC_...")
    values = np.array([line[:4] for line in segment.values])
    # Version 2 of the standard has no such keys: its scalar part is last, and its direction from A to B.
    if segment.keys.get("QUATERNION_TYPE", "LAST").upper() == "FIRST":
        values = np.roll(values, -1, axis=1)
    backward = segment.keys.get("ATTITUDE_DIR", "A2B").upper() == "B2A"
    # A turn of ITRF's axes into those of the body is also the turn of components in the body into those in ITRF.
    if first.startswith("ITRF") == backward:
        values = values * np.array([-1.0, -1.0, -1.0, 1.0])
    return AttitudeTable(_seconds(segment.times, start), values)  # type: ignore[arg-type]


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
    _write(Path(path), ("CCSDS_AEM_VERS", "1.0"), keys, start, times_s, name, lines, data_marks=True)


def _read(path: Path, version: str) -> _Segment:
    """Read a message with one segment; lines of comments and covariances are skipped."""
    with reading(path, PayloadError, "not a text file"):
        text = path.read_text(encoding="utf-8")
    keys: dict[str, str] = {}
    times: list[datetime] = []
    values: list[list[float]] = []
    for number, line in _lines(text):
        key, equals, value = (part.strip() for part in line.partition("="))
        if equals:
            if key == "OBJECT_NAME" and key in keys:
                raise PayloadError(f"{path}: more than one segment; allowed: one (line {number})")
            keys[key] = value
            continue
        try:
            time, *fields = line.split()
            times.append(_parsed(time))
            values.append([float(each) for each in fields])
        except ValueError as error:
            raise PayloadError(f"{path}: line {number}: {line!r} is no time with numbers") from error
        if len(values[-1]) != len(values[0]) or len(values[-1]) < 4 - (version == "CCSDS_OEM_VERS"):
            raise PayloadError(f"{path}: line {number}: {len(values[-1])} numbers; allowed: as many as in a state")
    if version not in keys:
        raise PayloadError(f"{path}: no {version}; allowed: a message of this kind in text form (KVN)")
    segment = _Segment(keys, times, values)
    segment.one_of(path, "TIME_SYSTEM", ("UTC",))
    return segment


def _lines(text: str) -> Iterator[tuple[int, str]]:
    """Yield numbered lines with keys and data."""
    covariance = False
    for number, line in enumerate(text.splitlines(), 1):
        line = line.strip()
        covariance = (covariance or line == "COVARIANCE_START") and line != "COVARIANCE_STOP"
        if covariance or not line or line.startswith("COMMENT") or line.endswith(("_START", "_STOP")):
            continue
        yield number, line


def _parsed(text: str) -> datetime:
    """Return a time of either form of the standard, yyyy-mm-dd or yyyy-ddd."""
    text = text.removesuffix("Z")
    date, _, clock = text.partition("T")
    if date.count("-") == 1:
        year, day = date.split("-")
        date = (datetime(int(year), 1, 1) + timedelta(days=int(day) - 1)).strftime("%Y-%m-%d")
    return datetime.fromisoformat(f"{date}T{clock}").replace(tzinfo=UTC)


def _seconds(times: Sequence[datetime], start: datetime) -> list[float]:
    require_utc("start", start)
    return [(time - start).total_seconds() for time in times]


def _utc(start: datetime, time_s: float) -> str:
    return (start + timedelta(seconds=float(time_s))).strftime("%Y-%m-%dT%H:%M:%S.%f")


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
    with atomic_write(path, PayloadError) as draft:
        draft.write_text("\n".join(text) + "\n", encoding="utf-8")
