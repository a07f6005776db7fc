"""Instants in a scenario: a date and time with zone, never a bare number or a local time."""

from __future__ import annotations

from datetime import UTC, date, datetime, timedelta
from typing import Annotated

from pydantic import AwareDatetime, BeforeValidator
from pydantic_core import PydanticCustomError

from hcss_twin.scenario.wording import shown

ALLOWED = "allowed: a date and time with zone, for example 2024-04-20T12:30:00+10:00"


def parse_instant(value: object) -> datetime:
    """Return a date and time with zone, from one or from ISO 8601 text.

    Raises
    ------
    PydanticCustomError
        If it is neither, has no zone or one with seconds, or lies outside the years 1 to 9999 in UTC.
    """
    instant = _from_text(value) if isinstance(value, str) else value
    if isinstance(instant, datetime):
        offset = instant.utcoffset()
        if offset is None:
            raise _refused(
                value, f"has no zone; {ALLOWED}; closest valid choice is {instant.isoformat()}+00:00"
            )
        if offset % timedelta(minutes=1):
            raise _refused(value, f"has a zone that is not in whole minutes; {ALLOWED}")
        try:
            instant.astimezone(UTC)
        except OverflowError as error:
            raise _refused(value, "is out of range; allowed: years 1 to 9999 in UTC") from error
        return instant
    if isinstance(instant, date):
        day = instant.isoformat()
        raise _refused(
            value, f"has no time of day and no zone; {ALLOWED}; closest valid choice is {day}T00:00:00+00:00"
        )
    raise _refused(value, f"is not a date and time with zone; {ALLOWED}")


def _from_text(text: str) -> datetime:
    try:
        return datetime.fromisoformat(text)
    except ValueError as error:
        raise _refused(text, f"is not a date and time with zone; {ALLOWED}") from error


def _refused(value: object, why: str) -> PydanticCustomError:
    return PydanticCustomError("instant", f"{shown(value)} {why}")


Instant = Annotated[AwareDatetime, BeforeValidator(parse_instant)]
