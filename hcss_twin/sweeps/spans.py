"""The values between two ends: numbers, quantities with a unit, or instants."""

from __future__ import annotations

import re
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Any

from hcss_twin.scenario.wording import shown

DIGITS = 12
"""Significant digits of computed values, so that 0.1 to 0.9 in steps of 0.2 has 0.3 and not 0.30000000000000004."""

_WITH_UNIT = re.compile(r"\s*([-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?)\s*(\S+)\s*")


@dataclass(frozen=True)
class Span:
    """Two or more given values as plain numbers, and the way back.

    Attributes
    ----------
    numbers : tuple of float
    value : callable
        What a scenario takes for a number: a number, text with the unit, or an instant.
    is_time : bool
    """

    numbers: tuple[float, ...]
    value: Callable[[float], Any]
    is_time: bool = False


def span_of(*given: Any) -> Span:
    """Read values that belong together: all numbers, all with the same unit, or all instants with a zone.

    Raises
    ------
    ValueError
        With what is wrong, if they are none of these.
    """
    instants = tuple(map(_read_instant, given))
    if all(isinstance(each, datetime) for each in instants):
        return _instants(instants)
    if all(isinstance(each, int | float) and not isinstance(each, bool) for each in given):
        whole = all(isinstance(each, int) for each in given)
        return Span(tuple(map(float, given)), lambda number: _plain(number, whole))
    matches = [_WITH_UNIT.fullmatch(each) if isinstance(each, str) else None for each in given]
    units = {match.group(2) for match in matches if match is not None}
    if None in matches or len(units) != 1:
        listed = ", ".join(map(shown, given))
        raise ValueError(
            f"{listed}: allowed: numbers, texts with one and the same unit, or dates and times with a zone"
        )
    (unit,) = units
    numbers = tuple(float(match.group(1)) for match in matches if match is not None)
    return Span(numbers, lambda number: f"{_plain(number, False):.{DIGITS}g} {unit}")


def _read_instant(value: Any) -> Any:
    """Read ISO 8601 text, as JSON has it; leave everything else as it is."""
    if isinstance(value, str) and "T" in value:
        with suppress(ValueError):
            return datetime.fromisoformat(value)
    return value


def _plain(number: float, whole: bool) -> float | int:
    rounded = float(f"{number:.{DIGITS}g}")
    return int(rounded) if whole and rounded.is_integer() else rounded


def _instants(given: tuple[Any, ...]) -> Span:
    first: datetime = given[0]
    for each in given:
        if each.utcoffset() is None:
            closest = f"{each.isoformat()}+00:00"
            raise ValueError(f"{each.isoformat()} has no zone; closest valid choice is {closest}")

    def instant(number: float) -> datetime:
        return first + timedelta(seconds=round(number, 6))

    return Span(tuple((each - first).total_seconds() for each in given), instant, True)
