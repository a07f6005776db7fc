"""Coordinates of swept keys, and time where points start at different instants."""

from __future__ import annotations

import json
from collections.abc import Sequence
from datetime import UTC, datetime
from typing import Any

from hcss_twin.scenario.instant import parse_instant

FRAME_TIME = "frame_time"
"""Instant of each frame of each point, where points do not start together."""

ELAPSED_TIME = "elapsed_time"
"""Time along the dimension ``time`` then, which has no coordinate of its own."""

_EPOCH = "seconds since 1970-01-01 00:00:00"


def swept_coordinate(key: str, values: Sequence[Any]) -> tuple[list[Any], Any, dict[str, Any]]:
    """Return the values along a dimension, their type and their attributes.

    Numbers stay numbers, instants become seconds since 1970, text stays text and everything else becomes JSON.
    """
    attributes: dict[str, Any] = {
        "long_name": f"swept key {key}",
        "hcss_key": key,
        "coverage_content_type": "coordinate",
    }
    if key == "time":
        seconds = [parse_instant(each).timestamp() for each in values]
        of_time = {"units": _EPOCH, "calendar": "standard", "units_metadata": "leap_seconds: none"}
        return seconds, "f8", {**attributes, **of_time}
    if all(isinstance(each, int) and not isinstance(each, bool) for each in values):
        return list(values), "i8", attributes
    if all(isinstance(each, int | float) and not isinstance(each, bool) for each in values):
        return list(map(float, values)), "f8", attributes
    return [each if isinstance(each, str) else json.dumps(each) for each in values], str, attributes


def elapsed_attributes() -> dict[str, Any]:
    """Return the attributes of the time that counts from the start of each point."""
    return {
        "long_name": "time of the frame after the start of the point",
        "comment": f"Instants are in {FRAME_TIME}.",
        "units": "s",
        "coverage_content_type": "coordinate",
    }


def frame_time_attributes() -> dict[str, Any]:
    """Return the attributes of the instants of frames."""
    return {
        "long_name": "time of the frame",
        "standard_name": "time",
        "units": _EPOCH,
        "units_metadata": "leap_seconds: none",
        "calendar": "standard",
        "coverage_content_type": "coordinate",
    }


def seconds_since_epoch(units: str) -> float:
    """Return the start that the units of a cube's time name, in seconds since 1970."""
    start = datetime.fromisoformat(units.removeprefix("seconds since "))
    return start.replace(tzinfo=UTC).timestamp()
