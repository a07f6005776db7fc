"""Conversion of numbers to JSON, which has no NaN or infinity: they become null."""

from __future__ import annotations

import math
from typing import Any

__all__ = ["json_value"]


def json_number(value: float | None) -> float | None:
    """Return a number, or None if it is missing or not finite."""
    return float(value) if value is not None and math.isfinite(value) else None


def json_value(value: Any) -> Any:
    """Return a JSON-compatible value with None for non-finite numbers; tuples and arrays (N,) become lists."""
    if isinstance(value, dict):
        return {name: json_value(item) for name, item in value.items()}
    if getattr(value, "ndim", 0):
        return [json_number(float(item)) for item in value]
    if isinstance(value, list | tuple):
        return [json_value(item) for item in value]
    return json_number(value) if isinstance(value, float) else value
