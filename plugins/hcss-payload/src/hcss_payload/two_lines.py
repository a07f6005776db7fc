"""Two-line elements: their text, and the orbit by SGP4."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta
from functools import cached_property
from typing import Any

import numpy as np

from hcss_payload.checks import NoStateAtTimeError, PayloadError, require_utc
from hcss_payload.earth import EARTH_M3_S2, SEMI_MAJOR_AXIS_M
from hcss_payload.earth_rotation import EarthOrientation, days_since_2000
from hcss_twin.providers import Array

_NUMBER = r"(?P<number>[ \dA-HJ-NP-Z][ \d]{3}\d)"
"""A catalogue number; from 100000 on its first digit is a letter other than I and O (Alpha-5)."""

_SMALL = r"[ +-][ \d]{5}[ +-]\d"

_LAYOUTS = {
    "line1": rf"1 {_NUMBER}[A-Z ] .{{8}} (?P<year>\d\d)(?P<day>[ \d]{{3}}\.[ \d]{{8}}) [ +-][ 0]?\.[ \d]{{7,8}} ?"
    rf" {_SMALL} {_SMALL} [ \d] [ \d]{{4}}",
    "line2": rf"2 {_NUMBER} (?P<inclination>[ \d]{{3}}\.[ \d]{{4}}) [ \d]{{3}}\.[ \d]{{4}} (?P<eccentricity>\d{{7}}) "
    r"[ \d]{3}\.[ \d]{4} [ \d]{3}\.[ \d]{4} (?P<motion>[ \d]{2}\.[ \d]{8})[ \d]{5}",
}
"""Columns of the lines without their checksum; F. R. Hoots and R. L. Roehrich, "Spacetrack Report No. 3" (1980)."""

_SGP4_ERRORS = {
    1: "the eccentricity leaves 0 to 1",
    2: "the mean motion falls below 0",
    3: "the perturbed eccentricity leaves 0 to 1",
    4: "the semi-latus rectum falls below 0",
    6: "the satellite has decayed",
}


class Sgp4Orbit:
    """An orbit that SGP4 propagates from mean elements."""

    start: datetime
    orientation: EarthOrientation

    @property
    def epoch(self) -> datetime:
        """Time of the elements, in UTC."""
        raise NotImplementedError

    @property
    def _satellite(self) -> Any:
        raise NotImplementedError

    def at(self, time_s: float) -> Array:
        """Return the position; an orbit that SGP4 cannot propagate is an error."""
        days = days_since_2000(self.start) + time_s / 86400.0
        error, kilometres, _ = self._satellite.sgp4(2451545.0, days)
        if error:
            why = _SGP4_ERRORS.get(error, "unknown")
            raise NoStateAtTimeError(f"trajectory: SGP4 fails {time_s:g} s after the start with error {error}: {why}")
        return self.orientation.earth_fixed(1e3 * np.array(kilometres), days)


@dataclass(frozen=True)
class TwoLineElements(Sgp4Orbit):
    """An orbit from two-line elements by SGP4; needs the extra ``tle`` (package sgp4).

    Parameters
    ----------
    line1, line2 : str
        The elements; blanks around them do not matter.
    start : datetime
        Time 0, in UTC.
    orientation : EarthOrientation
        Orientation of the Earth.
    """

    line1: str
    line2: str
    start: datetime
    orientation: EarthOrientation = field(default_factory=EarthOrientation)

    def __post_init__(self) -> None:
        require_utc("trajectory.start", self.start)
        for name in ("line1", "line2"):
            object.__setattr__(self, name, getattr(self, name).strip(" \t\r\n\ufeff"))
        first, second = _columns("line1", self.line1), _columns("line2", self.line2)
        if first["number"] != second["number"]:
            raise PayloadError(
                f"trajectory.line2: catalogue number {second['number'].strip()}, and {first['number'].strip()} in "
                "line1; allowed: two lines of one satellite"
            )
        day, inclination = float(first["day"].replace(" ", "0")), float(second["inclination"])
        motion, eccentricity = float(second["motion"]), 1e-7 * float(second["eccentricity"])
        if not 1.0 <= day < 367.0:
            raise PayloadError(f"trajectory.line1: day {day:g} of the year; allowed: 1 to 366")
        require_orbit("trajectory.line2", motion, eccentricity, inclination)

    @property
    def epoch(self) -> datetime:
        """Time of the elements, in UTC; years 57 to 99 are those of the last century."""
        year = int(self.line1[18:20])
        return datetime(year + (1900 if year >= 57 else 2000), 1, 1, tzinfo=UTC) + timedelta(
            days=float(self.line1[20:32].replace(" ", "0")) - 1.0
        )

    @cached_property
    def _satellite(self) -> Any:
        return type(satrec()[0]).twoline2rv(self.line1, self.line2)


def satrec() -> tuple[Any, Any]:
    """Return a satellite of sgp4 without elements, and its constants of gravity.

    Raises
    ------
    PayloadError
        Without the extra ``tle``.
    """
    try:
        from sgp4.api import WGS72, Satrec  # an extra
    except ModuleNotFoundError as missing:
        raise PayloadError("trajectory: mean elements need sgp4: pip install 'hcss-payload[tle]'") from missing
    return Satrec(), WGS72


def require_orbit(where: str, motion: float, eccentricity: float, inclination: float) -> None:
    """Raise a :class:`PayloadError` for elements of no orbit around the Earth; revolutions a day, degrees."""
    if not 0.0 <= inclination <= 180.0:
        raise PayloadError(f"{where}: inclination {inclination:g} deg; allowed: 0 to 180 deg")
    # The Earth's radius has 17.0 revolutions a day.
    if not 0.0 < motion < 17.1:
        raise PayloadError(f"{where}: {motion:g} revolutions a day; allowed: above 0 to 17")
    axis_m = (EARTH_M3_S2 / (2.0 * np.pi * motion / 86400.0) ** 2) ** (1.0 / 3.0)
    perigee_m = axis_m * (1.0 - eccentricity) - SEMI_MAJOR_AXIS_M
    if perigee_m < 0.0:
        raise PayloadError(
            f"{where}: {motion:g} revolutions a day with eccentricity {eccentricity:g} have their perigee "
            f"{-1e-3 * perigee_m:.0f} km inside the Earth; allowed: above it"
        )


def two_lines_of(name: str, text: str) -> tuple[str, str]:
    """Return the two lines of a file's text, which may begin with the name of the satellite.

    Raises
    ------
    PayloadError
        If it has other lines.
    """
    lines = [line.strip() for line in text.splitlines() if line.strip() and not line.startswith("#")]
    if len(lines) not in (2, 3):
        raise PayloadError(
            f"{name} has {len(lines)} lines; allowed: those of one satellite, two, or three with a name before"
        )
    return lines[-2], lines[-1]


def _columns(name: str, line: str) -> dict[str, str]:
    """Return the fields of a line."""
    digits = [int(mark) if mark in "0123456789" else int(mark == "-") for mark in line[:68]]
    checksum, wrong = str(sum(digits) % 10), ""
    if len(line) != 69:
        wrong = f"has {len(line)} characters"
    elif not line.startswith(f"{name[-1]} "):
        wrong = f"begins with {line[:2]!r}"
    elif line[68] != checksum:
        wrong = f"ends with {line[68]!r}, and the checksum is {checksum}"
    if wrong:
        raise PayloadError(
            f"trajectory.{name}: {line!r} {wrong}; allowed: 69 characters that begin with '{name[-1]} ' and end with "
            "the checksum of the others"
        )
    columns = re.fullmatch(_LAYOUTS[name], line[:68], re.ASCII)
    if columns is None:
        raise PayloadError(
            f"trajectory.{name}: {line!r} has other columns than two-line elements; allowed: as published, for example "
            + {"line1": "day 111.50000000 in columns 21 to 32", "line2": "98.2000 deg in columns 9 to 16"}[name]
        )
    return columns.groupdict()
