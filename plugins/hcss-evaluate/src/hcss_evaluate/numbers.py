"""Numbers in answers as JSON."""

from __future__ import annotations

from hcss_twin.core.json_numbers import json_value


def json_number(value: float | None) -> float | None:
    """Return a number, or None if it is missing or not finite."""
    number: float | None = None if value is None else json_value(float(value))
    return number
