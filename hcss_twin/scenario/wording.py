"""How values are written in messages: as the user would type them, and never a screenful."""

from __future__ import annotations

import json
from datetime import date, time

LONGEST = 80


def shown(value: object) -> str:
    """Write a value as it stands in a scenario file, cut to 80 characters."""
    if isinstance(value, bool):
        text = str(value).lower()
    elif isinstance(value, date | time):
        text = value.isoformat()
    else:
        try:
            text = repr(value)
        except ValueError:  # integers beyond Python's limit for conversion to text
            text = "a number of thousands of digits"
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 3]}..."


def listed(value: object) -> str | None:
    """Write ``value`` as the only entry of a list; None for what cannot be an entry."""
    return json.dumps([value]) if isinstance(value, str) and len(value) < LONGEST else None


def count(number: int, noun: str, plural: str) -> str:
    """Write a number of things: ``1 entry``, ``2 entries``."""
    return f"{number} {noun if number == 1 else plural}"
