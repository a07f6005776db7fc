"""Texts of orbit messages: byte-order marks, times in several scales, and XML as the lines of the text form.

Sources: CCSDS 502.0-B-3, "Orbit Data Messages" (2023), sections 5 and 7; CCSDS 505.0-B-3, "XML Specification for
Navigation Data Messages" (2023). In XML a message has the keys of its text form, so one parser reads both.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from datetime import UTC, datetime, timedelta
from pathlib import Path
from types import MappingProxyType
from xml.parsers import expat

from hcss_payload.checks import PayloadError
from hcss_payload.earth_rotation import tai_minus_utc_s
from hcss_twin.core.reading import Reading

SCALES: Mapping[str, float | None] = MappingProxyType({"UTC": None, "TAI": 0.0, "GPS": 19.0, "TT": -32.184})
"""TAI minus time in each scale, s; None: leap seconds."""

_TIME = re.compile(r"(\d{4})-(\d{3}|\d\d-\d\d)T(\d\d):(\d\d):(\d\d(?:\.\d*)?)Z?")

_UNITS = frozenset({"", "km", "km/s", "km/s**2", "km**2", "km**2/s", "km**2/s**2", "deg", "rev/day", "1/ER", "s"})


def message_text(path: Path) -> str:
    """Return the text of a file, without byte-order marks: Windows writes them, and joined files have several.

    Raises
    ------
    PayloadError
        If it is no text.
    """
    with Reading(path, PayloadError, "not a text file"):
        content = path.read_bytes()
        wide = content.startswith((b"\xff\xfe", b"\xfe\xff"))
        return content.decode("utf-16" if wide else "utf-8").replace("\ufeff", "")


def message_lines(path: Path) -> list[tuple[int, str]]:
    """Return the lines of a message's text form with their numbers in the file, also of a file in XML."""
    text = message_text(path)
    if text.lstrip().startswith("<"):
        return _XmlLines(path).read(text)
    return list(enumerate(map(str.strip, text.splitlines()), start=1))


def utc_of(text: str, where: str, scale: str = "UTC") -> datetime:
    """Return the UTC of a time of either form of the standard, yyyy-mm-dd or yyyy-ddd.

    Raises
    ------
    PayloadError
        If it is no such time, is within a leap second, or leap seconds are not known, as they are with the extra
        ``frames``.
    """
    found = _TIME.fullmatch(text)
    try:
        if found is None:
            raise ValueError(text)
        year, date, hour, minute, second = found.groups()
        day = datetime.strptime(f"{year}-{date}", "%Y-%m-%d" if "-" in date else "%Y-%j").replace(tzinfo=UTC)
        if int(hour) > 23 or int(minute) > 59 or float(second) >= 60.0:
            raise ValueError(text)
    except ValueError as error:
        leap = found is not None and 60.0 <= float(found.group(5)) < 61.0
        why = "is within a leap second" if leap else "is no time with numbers"
        raise PayloadError(
            f"{where}: {shown(text)!r} {why}; allowed: {scale}, as 2024-04-20T02:30:00.0 or 2024-111T02:30:00.0"
        ) from error
    time = day + timedelta(hours=int(hour), minutes=int(minute), seconds=float(second))
    before_tai = SCALES[scale]
    if before_tai is None:
        return time
    tai = time + timedelta(seconds=before_tai)
    return tai - timedelta(seconds=tai_minus_utc_s(tai - timedelta(seconds=tai_minus_utc_s(tai))))


def shown(text: str) -> str:
    """Return a line of a file for a message, at most 200 characters."""
    line = " ".join(text.split())
    return line if len(line) <= 200 else f"{line[:197]}..."


class _XmlLines:
    """Turns a message in XML into the lines of its text form, with the line of the file where each begins."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._open: list[str] = []
        self._text = ""
        self._state: list[str] = []
        self._lines: list[tuple[int, str]] = []
        self._parser = expat.ParserCreate()
        self._parser.StartElementHandler = self._start
        self._parser.EndElementHandler = self._end
        self._parser.CharacterDataHandler = self._characters

    def read(self, text: str) -> list[tuple[int, str]]:
        """Return the lines."""
        try:
            self._parser.Parse(text.strip().encode(), True)
        except expat.ExpatError as error:
            raise PayloadError(
                f"{self._path}: line {error.lineno}: not XML: {expat.ErrorString(error.code)}"
            ) from error
        return self._lines

    def _add(self, line: str) -> None:
        self._lines.append((self._parser.CurrentLineNumber, line))

    def _start(self, name: str, attributes: dict[str, str]) -> None:
        tag = name.rpartition(":")[2]
        self._open.append(tag)
        self._text = ""
        unit = attributes.get("units", "")
        if unit not in _UNITS:
            raise PayloadError(
                f"{self._path}: line {self._parser.CurrentLineNumber}: {tag} in {unit}; allowed: km, km/s and deg"
            )
        if tag in ("oem", "aem", "omm") and not self._lines:
            self._add(f"CCSDS_{tag.upper()}_VERS = {attributes.get('version', 'missing')}")
        elif tag == "metadata":
            self._add("META_START")
        elif tag in ("stateVector", "quaternionEphemeris", "quaternionState"):
            self._state = []

    def _characters(self, text: str) -> None:
        self._text += text

    def _end(self, name: str) -> None:
        tag = self._open.pop()
        value = " ".join(self._text.split())
        self._text = ""
        if tag == "metadata":
            self._add("META_STOP")
        elif tag in ("stateVector", "quaternionEphemeris", "quaternionState"):
            self._add(" ".join(self._state))
        elif "stateVector" in self._open or any(part.startswith("quaternion") for part in self._open):
            if value and tag != "COMMENT":
                self._state.append(value)
        elif tag != "COMMENT" and self._open and self._open[-1] in ("metadata", "meanElements", "tleParameters"):
            self._add(f"{tag} = {value}")
