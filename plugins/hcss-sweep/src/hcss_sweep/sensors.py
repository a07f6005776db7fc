"""One sky, many sensors: ``[[sensors]]`` tables, each of which looks at the same clouds with keys of its own."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from hcss_twin import Scenario
from hcss_twin.providers import Problem

SENSORS = "sensors"
"""List of tables of a file, and the axis of a sweep that they are."""

_OF_THE_SKY = ("seed", "time", "place", "clouds", "atmosphere", "sea", "surfaces", "elements")
_OF_THE_SENSOR = ("platform_speed",)
"""Keys of ``[motion]`` that move the sensor; the others move clouds."""

_ALLOWED = (
    "[[sensors]] tables, each with a `name` and keys of its own, for example "
    '{name = "geo", platform.longitude = 140.7, image.pixel_size = "2 km"}'
)

LARGEST_POINT_M = 60.0
"""Largest distance of the points of a pixel: generators make other clouds for larger ones. Films of simulations have
cells of 50 m for points up to 70 m, and larger ones beyond, whose clouds stand elsewhere."""

MOST_SAMPLES = 64
"""Most points along the side of a pixel, as `image.samples_per_pixel` allows."""


def sensors_of(raw: Any) -> tuple[dict[str, dict[str, Any]], list[Problem]]:
    """Return the keys of each sensor by its name, and what is wrong with ``[[sensors]]``."""
    if not isinstance(raw, list) or not raw or not all(isinstance(table, Mapping) for table in raw):
        return {}, [Problem(SENSORS, f"{Problem.shown(raw)}; allowed: {_ALLOWED}")]
    sensors: dict[str, dict[str, Any]] = {}
    problems: list[Problem] = []
    for number, table in enumerate(raw):
        field, keys = f"{SENSORS}[{number}]", dict(table)
        name = keys.pop("name", None)
        if not isinstance(name, str) or not name.strip() or name in sensors:
            problems.append(Problem(f"{field}.name", f"{Problem.shown(name)}; allowed: a text of its own for each"))
            continue
        sensors[name] = keys
        problems += _of_the_sky(field, keys)
    return sensors, problems


def _of_the_sky(field: str, keys: Mapping[str, Any]) -> Iterator[Problem]:
    motion = keys.get("motion")
    moving = sorted(set(motion) - set(_OF_THE_SENSOR)) if isinstance(motion, Mapping) else []
    for key in (*(key for key in _OF_THE_SKY if key in keys), *(f"motion.{name}" for name in moving)):
        yield Problem(f"{field}.{key}", "belongs to the sky, which all sensors see; allowed: outside [[sensors]]")


def merged(scene: Mapping[str, Any], sensor: Mapping[str, Any]) -> dict[str, Any]:
    """Return the keys of a scene with those of a sensor; tables are merged key by key, all else is replaced."""
    both = dict(scene)
    for key, value in sensor.items():
        known = both.get(key)
        both[key] = merged(known, value) if isinstance(known, Mapping) and isinstance(value, Mapping) else value
    return both


def samples_for_one_sky(scenario: Scenario, given: Mapping[str, Any]) -> dict[str, int]:
    """Return the key for points that show the sky in detail; none if pixels have them, or ``given`` keys state some."""
    image = given.get("image")
    needed = min(math.ceil(scenario.image.pixel_size / LARGEST_POINT_M), MOST_SAMPLES)
    stated = isinstance(image, Mapping) and "samples_per_pixel" in image
    return {} if stated or needed <= scenario.image.samples_per_pixel else {"image.samples_per_pixel": needed}


def with_one_sky(scenarios: Sequence[Scenario]) -> list[Scenario]:
    """Return the scenarios of all sensors with the clouds of the one that has the finest points.

    The generator of a cloud type depends on the size of points, and a coverage of each frame on what the frame shows:
    both would give each sensor a sky of its own.

    Raises
    ------
    ScenarioError
        If the clouds of the finest cannot be those of another.
    """
    points_m = [scenario.image.pixel_size / scenario.image.samples_per_pixel for scenario in scenarios]
    clouds = json.loads(scenarios[points_m.index(min(points_m))].to_json())["clouds"]
    for layer in clouds["layers"]:
        layer["coverage_mode"] = "field"
    return [
        Scenario.from_dict(
            {**json.loads(scenario.to_json()), "clouds": clouds}, base=scenario.base, origin=scenario.origin
        )
        for scenario in scenarios
    ]
