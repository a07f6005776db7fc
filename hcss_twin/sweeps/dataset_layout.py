"""Which sweeps fit into one dataset, and what its dimensions are called.

Coordinates of swept keys, and time where points start at different instants.

What is not the same in all cubes of a sweep, besides the data.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np

from hcss_twin.core.errors import Problem, ScenarioError, SweepError
from hcss_twin.cube.coordinates import GRID_MAPPING
from hcss_twin.cube.header import FORMAT_ATTRIBUTE
from hcss_twin.scenario.scenario import SWEEP
from hcss_twin.scenario.section_types import parse_instant
from hcss_twin.sweeps.design import Design
from hcss_twin.sweeps.points import Point, value_at

OF_ALL_POINTS = ("image.rows", "image.columns", "image.pixel_size", "frames", "bands", "output.variables")
"""Keys that points of one dataset have in common, because its dimensions and coordinates come from them."""


def require_one_layout(design: Design, points: Sequence[Point]) -> None:
    """Check, before any point is computed, that all of them fit into one dataset.

    Raises
    ------
    ScenarioError
        Naming the key that separates them.
    """
    if design.combine != "product":
        told = "a dataset needs a dimension for each key; allowed: combine = 'product', or no dataset"
        raise ScenarioError([Problem(f"{SWEEP}.combine", told)], design.origin)
    first = _layout(points[0])
    for point in points[1:]:
        for key, value in _layout(point).items():
            if value != first[key]:
                told = f"differs between points 0 and {point.number}; a dataset needs it in common, allowed: no dataset"
                raise ScenarioError([Problem(f"{SWEEP}: {key}", told)], design.origin)


def _layout(point: Point) -> Mapping[str, Any]:
    plain = json.loads(point.scenario.to_json())
    return {key: value_at(plain, key) for key in OF_ALL_POINTS}


def dimension_of(key: str) -> str:
    """Return the name of the dimension of a swept key: ``view_zenith`` of ``view.zenith``.

    A cube has a ``time`` of its own, so that the scenario's becomes ``start_time``.
    """
    return "start_time" if key == "time" else re.sub(r"\W", "_", key, flags=re.ASCII)


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


NOT_COMPARED = frozenset({"date_created", "history", "id", FORMAT_ATTRIBUTE})
"""Global attributes of a cube that its dataset does not take over."""


@dataclass(frozen=True)
class Differences:
    """What a dataset needs its own dimensions for.

    Attributes
    ----------
    attributes : mapping
        Global attributes whose values differ, with the type of a variable that holds them.
    variables : frozenset of str
        Coordinates whose values differ.
    starts : bool
        Whether the first frames are at different instants.
    moves : bool
        Whether images lie at different places.
    """

    attributes: Mapping[str, Any]
    variables: frozenset[str]
    starts: bool
    moves: bool


def differences(cubes: Mapping[int, Path]) -> Differences:
    """Compare all cubes with the first, one at a time.

    Raises
    ------
    SweepError
        If one has other variables, or variables of other sizes.
    """
    numbers = sorted(cubes)
    attributes: dict[str, Any] = {}
    variables: set[str] = set()
    starts = moves = False
    with netCDF4.Dataset(cubes[numbers[0]]) as first:
        first.set_auto_maskandscale(False)
        layout = _layout_of_cube_differences(first)
        for number in numbers[1:]:
            with netCDF4.Dataset(cubes[number]) as other:
                other.set_auto_maskandscale(False)
                _require_same_layout(layout, _layout_of_cube_differences(other), numbers[0], number)
                for name in sorted({*first.ncattrs(), *other.ncattrs()} - NOT_COMPARED):
                    one, another = (getattr(each, name, None) for each in (first, other))
                    if one != another:
                        known = another if one is None else one
                        attributes[name] = str if isinstance(known, str) else "f8"
                for name, variable in first.variables.items():
                    twin = other.variables[name]
                    if "grid_mapping" in variable.ncattrs():
                        continue
                    if not np.array_equal(variable[...], twin[...]):
                        variables.add(name)
                starts |= first.variables["time"].units != other.variables["time"].units
                plane, another_plane = first.variables[GRID_MAPPING], other.variables[GRID_MAPPING]
                moves |= any(plane.getncattr(name) != another_plane.getncattr(name) for name in plane.ncattrs())
    return Differences(attributes, frozenset(variables), starts, moves)


def _layout_of_cube_differences(cube: Any) -> dict[str, tuple[str, tuple[str, ...], tuple[int, ...]]]:
    return {name: (str(each.dtype), each.dimensions, each.shape) for name, each in cube.variables.items()}


def _require_same_layout(first: Mapping[str, Any], other: Mapping[str, Any], one: int, another: int) -> None:
    unlike = sorted(name for name in {*first, *other} if first.get(name) != other.get(name))
    if unlike:
        raise SweepError(
            f"cannot write one dataset: cubes of points {one} and {another} differ in the variables "
            f"{', '.join(unlike)} or their sizes; the cubes themselves are complete"
        )
