"""Radiosonde soundings of the Integrated Global Radiosonde Archive (IGRA), version 2."""

from __future__ import annotations

import math
import re
from datetime import UTC, datetime

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import CatalogError, Problem
from hcss_twin.models.atmosphere.time_choice import chosen, nearest

_HEAD = re.compile(r"#\w{11} (\d{4}) ([ \d]\d) ([ \d]\d) ([ \d]\d) [ \d]{4} ([ \d]{4})")

_FIELDS = {"pressure": (9, 15, 1.0), "geopotential_height": (16, 21, 1.0), "temperature": (22, 27, 0.1),
                "relative_humidity": (28, 33, 0.1), "depression": (34, 39, 0.1)}  # fmt: skip
"""Columns of a level, and the unit: Pa, m, degC, percent, K."""


def is_igra(text: str) -> bool:
    """Whether a text begins as soundings of version 2 of the Integrated Global Radiosonde Archive."""
    return _HEAD.match(text.lstrip()) is not None


def read_igra(text: str, name: str, time: datetime | None) -> tuple[tuple[str, ...], dict[str, Array], tuple[str, ...]]:
    """Return levels, values and notes of the sounding of an IGRA 2 file that is nearest to a time.

    Values are in Pa, m, degC and percent; missing ones are NaN.

    Source: I. Durre, "Format description of IGRA 2 sounding data files", NOAA NCEI (2016).

    Raises
    ------
    CatalogError
        If a line is malformed, or the file has several soundings and no time is given.
    """
    lines = [(number, line) for number, line in enumerate(text.splitlines(), start=1) if line.strip()]
    heads = [index for index, (_, line) in enumerate(lines) if line.startswith("#")]
    dates = [_date(*lines[index], name) for index in heads]
    notes: tuple[str, ...] = ()
    index = 0
    if len(heads) > 1:
        if time is None:
            raise CatalogError(f"{name}: {len(heads)} soundings; allowed: one, or a scenario's time to choose by")
        index = nearest(dates, time)
        notes = (chosen(name, "sounding of", dates[index], time, "%Y-%m-%d %H"),)
    end = heads[index + 1] if index + 1 < len(heads) else len(lines)
    levels = lines[heads[index] + 1 : end]
    found = _HEAD.match(lines[heads[index]][1])
    stated = int(found[5]) if found else 0
    if stated != len(levels):
        raise CatalogError(
            f"{name}, line {lines[heads[index]][0]}: the header states {stated} levels, {len(levels)} follow"
        )
    where = [f"line {number}" for number, _ in levels]
    values = {field: np.array([_value(*level, field, name) for level in levels]) for field in _FIELDS}
    values["dewpoint"] = values["temperature"] - values.pop("depression")
    return tuple(where), values, notes


def _date(number: int, line: str, name: str) -> datetime:
    found = _HEAD.match(line)
    try:
        if found is None:
            raise ValueError(line)
        year, month, day, hour = map(int, found.groups()[:4])
        return datetime(year, month, day, hour % 99, tzinfo=UTC)  # 99: unknown
    except ValueError as error:
        raise CatalogError(
            f"{name}, line {number}: {Problem.shown(line)} has no date; allowed: a header of IGRA 2 with year, month, "
            "day and hour"
        ) from error


def _value(number: int, line: str, field: str, name: str) -> float:
    """Return a value of a level; -9999 and -8888 (removed by quality control) are missing."""
    first, last, unit = _FIELDS[field]
    if len(line) < last:
        raise CatalogError(
            f"{name}, line {number}: {len(line)} characters; allowed: levels of IGRA 2, of at least {last} with a "
            f"{field}"
        )
    text = line[first:last].strip()
    try:
        value = float(text)
    except ValueError:
        raise CatalogError(f"{name}, line {number}: {field} '{text}' is not a number") from None
    return math.nan if value in (-9999.0, -8888.0) else unit * value
