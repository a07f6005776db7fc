"""What is not the same in all cubes of a sweep, besides the data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np

from hcss_twin.cube.coordinates import GRID_MAPPING
from hcss_twin.cube.header import FORMAT_ATTRIBUTE
from hcss_twin.errors import SweepError

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
        layout = _layout(first)
        for number in numbers[1:]:
            with netCDF4.Dataset(cubes[number]) as other:
                other.set_auto_maskandscale(False)
                _require_same_layout(layout, _layout(other), numbers[0], number)
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
                moves |= any(
                    plane.getncattr(name) != another_plane.getncattr(name) for name in plane.ncattrs()
                )
    return Differences(attributes, frozenset(variables), starts, moves)


def _layout(cube: Any) -> dict[str, tuple[str, tuple[str, ...], tuple[int, ...]]]:
    return {name: (str(each.dtype), each.dimensions, each.shape) for name, each in cube.variables.items()}


def _require_same_layout(first: Mapping[str, Any], other: Mapping[str, Any], one: int, another: int) -> None:
    unlike = sorted(name for name in {*first, *other} if first.get(name) != other.get(name))
    if unlike:
        raise SweepError(
            f"cannot write one dataset: cubes of points {one} and {another} differ in the variables "
            f"{', '.join(unlike)} or their sizes; the cubes themselves are complete"
        )
