"""Mean orbital elements for SGP4: orbit mean-elements messages (OMM) in text, XML, JSON or CSV, and two-line elements.

Catalogue numbers of two-line elements end at 339999; messages have no such limit. Source: CCSDS 502.0-B-3, "Orbit Data
Messages" (2023), section 4.
"""

from __future__ import annotations

import csv
import json
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from functools import cached_property
from pathlib import Path
from typing import Any

from hcss_payload.checks import PayloadError, require_utc
from hcss_payload.earth_rotation import EarthOrientation
from hcss_payload.message_text import SCALES, message_lines, message_text, shown, utc_of
from hcss_payload.two_lines import Sgp4Orbit, TwoLineElements, require_orbit, satrec, two_lines_of

_NUMBERS = {
    "MEAN_MOTION": "rev/day",
    "ECCENTRICITY": "",
    "INCLINATION": "deg",
    "RA_OF_ASC_NODE": "deg",
    "ARG_OF_PERICENTER": "deg",
    "MEAN_ANOMALY": "deg",
    "BSTAR": "1/ER",
}

_STATED = {
    "CENTER_NAME": ("EARTH", "EARTH"),
    "REF_FRAME": ("TEME", "TEME"),
    "TIME_SYSTEM": ("|".join(SCALES), ", ".join(SCALES)),
    "MEAN_ELEMENT_THEORY": ("SGP4|SGP/SGP4|SGP", "SGP4"),
    "EPHEMERIS_TYPE": ("0|2", "0, that of SGP4"),
}
"""Keys that may be missing, with the values that mean elements of SGP4, as a pattern and in words."""

_EPOCH_LABEL = re.compile(r"(^|,)\s*\"?EPOCH\"?\s*(,|$)", re.I)
"""Of the line of labels of a table in CSV."""

_EPOCH_0 = datetime(1949, 12, 31, tzinfo=UTC)


@dataclass(frozen=True)
class MeanElements(Sgp4Orbit):
    """An orbit from an orbit mean-elements message by SGP4; needs the extra ``tle`` (package sgp4).

    Parameters
    ----------
    keys : mapping
        Keys of the message with their values as text.
    start : datetime
        Time 0, in UTC.
    orientation : EarthOrientation
        Orientation of the Earth.
    """

    keys: Mapping[str, str]
    start: datetime
    orientation: EarthOrientation = field(default_factory=EarthOrientation)

    def __post_init__(self) -> None:
        require_utc("trajectory.start", self.start)
        for key, (pattern, allowed) in _STATED.items():
            value = self.keys.get(key)
            if value is not None and not re.fullmatch(pattern, value.strip().upper()):
                raise PayloadError(f"trajectory: {key} {value}; allowed: {allowed}")
        if not 0.0 <= self._number("ECCENTRICITY") < 1.0:
            raise PayloadError(f"trajectory: ECCENTRICITY {self.keys['ECCENTRICITY']}; allowed: 0 to below 1")
        require_orbit(
            "trajectory", self._number("MEAN_MOTION"), self._number("ECCENTRICITY"), self._number("INCLINATION")
        )
        for key in _NUMBERS:
            self._number(key)
        self.epoch  # noqa: B018 - its errors come now

    @cached_property
    def epoch(self) -> datetime:
        """Time of the elements, in UTC."""
        if "EPOCH" not in self.keys:
            raise PayloadError("trajectory: EPOCH is missing; allowed: all keys of mean elements")
        return utc_of(self.keys["EPOCH"], "trajectory: EPOCH", self.keys.get("TIME_SYSTEM", "UTC").strip().upper())

    def _number(self, key: str) -> float:
        """Return a number, whose unit may follow in brackets."""
        if key not in self.keys:
            raise PayloadError(f"trajectory: {key} is missing; allowed: all of EPOCH, {', '.join(_NUMBERS)}")
        text, _, unit = self.keys[key].partition("[")
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not math.isfinite(value) or unit.strip(" ]") not in ("", _NUMBERS[key]):
            of_unit = f", in {_NUMBERS[key]}" if _NUMBERS[key] else ""
            raise PayloadError(f"trajectory: {key} {shown(self.keys[key])!r}; allowed: a number{of_unit}")
        return value

    @cached_property
    def _satellite(self) -> Any:
        motion, eccentricity, *angles, drag = (self._number(key) for key in _NUMBERS)
        inclination, node, argument, anomaly = map(math.radians, angles)
        satellite, gravity = satrec()
        # Number and derivatives of the mean motion do not matter to SGP4.
        days, motion = (self.epoch - _EPOCH_0).total_seconds() / 86400.0, motion * math.pi / 720.0
        satellite.sgp4init(
            gravity, "i", 0, days, drag, 0.0, 0.0, eccentricity, argument, inclination, anomaly, motion, node
        )
        return satellite


def read_elements(path: Path, start: datetime, orientation: EarthOrientation) -> Sgp4Orbit:
    """Return the orbit of a file with two-line elements or a mean-elements message in text, XML, JSON or CSV.

    Raises
    ------
    PayloadError
        If it has none, or those of several satellites.
    """
    text = message_text(path)
    begins = text.lstrip()[:1]
    if begins in ("{", "[") and begins:
        return MeanElements(_json_keys(path, text), start, orientation)
    if _EPOCH_LABEL.search(text.lstrip().partition("\n")[0]):
        return MeanElements(_csv_keys(path, text), start, orientation)
    if begins == "<" or "CCSDS_OMM_VERS" in text:
        return MeanElements(_keys(path), start, orientation)
    return TwoLineElements(*two_lines_of(path.name, text), start, orientation)


def _json_keys(path: Path, text: str) -> dict[str, str]:
    try:
        data = json.loads(text)
    except ValueError as error:
        raise PayloadError(f"{path}: not JSON: {error}") from error
    messages = data if isinstance(data, list) else [data]
    if len(messages) != 1 or not isinstance(messages[0], dict):
        raise PayloadError(f"{path}: {len(messages)} satellites; allowed: the message of one")
    return {str(key): str(value) for key, value in messages[0].items() if value is not None}


def _csv_keys(path: Path, text: str) -> dict[str, str]:
    """Return the keys of a table with labels, as services list messages."""
    rows = list(csv.DictReader(text.strip().splitlines(), restval="", strict=True, skipinitialspace=True))
    if len(rows) != 1 or None in rows[0]:
        raise PayloadError(f"{path}: {len(rows)} rows below the labels; allowed: one, the message of one satellite")
    return {key.strip().upper(): value for key, value in rows[0].items() if value.strip()}


def _keys(path: Path) -> dict[str, str]:
    keys: dict[str, str] = {}
    for number, line in message_lines(path):
        if not line or line.split()[0] == "COMMENT" or line in ("META_START", "META_STOP"):
            continue
        key, equals, value = (word.strip() for word in line.partition("="))
        if not equals:
            raise PayloadError(f"{path}: line {number}: {shown(line)!r}; allowed: KEY = value")
        if key in keys:
            raise PayloadError(f"{path}: line {number}: a second {key}; allowed: the message of one satellite")
        keys[key] = value
    if "CCSDS_OMM_VERS" not in keys:
        raise PayloadError(f"{path}: no CCSDS_OMM_VERS; allowed: two-line elements, or a mean-elements message (OMM)")
    return keys
