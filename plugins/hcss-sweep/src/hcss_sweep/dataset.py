"""One dataset of all points, with the swept keys as leading dimensions before those of a cube."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hcss_sweep.design import Design
from hcss_sweep.errors import SweepError
from hcss_sweep.folder import INDEX, LOG, PointRecord, is_cube_name
from hcss_twin.core.arguments import checked
from hcss_twin.core.files import Writing
from hcss_twin.core.reading import Reading
from hcss_twin.cube.frame_selection import FrameSelection
from hcss_twin.providers import CubeError, NetcdfFile
from hcss_twin.reports.provenance import Provenance

if TYPE_CHECKING:
    import xarray as xr

MARK = "hcss_sweep"
"""Global attribute of a dataset, with the hash of the sweep."""


@checked
@Reading.argument(CubeError)
def open_sweep(path: str | os.PathLike[str]) -> xr.Dataset:
    """Open the dataset of a sweep; values are loaded from the file on use.

    Swept keys, bands and cloud layers are selected by value or name: ``open_sweep(path).radiance.sel(view_zenith=30,
    band="mwir")``. Close the dataset after use.

    Raises CubeError if the file is missing or not a dataset of a sweep.
    """
    if not os.path.isfile(path):
        raise CubeError(f"cannot read {os.fspath(path)}: there is no such file")
    dataset = NetcdfFile.open_with_xarray(path, decode_coords="all", cache=False)
    if MARK not in dataset.attrs:
        dataset.close()
        raise CubeError(f"cannot read {os.fspath(path)}: it is not a sweep dataset; open_cube reads cubes")
    described = FrameSelection.coordinates(dataset)
    of_points = [str(name) for name in dataset.variables if str(name).startswith("point_")]
    named = dataset.set_coords([*described, *of_points])
    names = {
        dim: f"{dim}_name"
        for dim in ("band", "layer")
        if f"{dim}_name" in dataset and dataset[f"{dim}_name"].dims == (dim,)
    }
    named = named.assign_coords({dim: (dim, dataset[name].to_numpy().astype(str)) for dim, name in names.items()})
    # closing a derived dataset does not close its file
    named.set_close(dataset.close)
    return named


def require_replaceable(path: Path, folder: Path, digest: str, force: bool) -> None:
    """Check, before any computation, that the dataset can be written here.

    Raises SweepError if another file has this name, or its folder does not exist.
    """
    is_in_folder = path.absolute().parent == folder.absolute()
    if is_in_folder and (path.name in (INDEX, LOG) or is_cube_name(path.name)):
        raise SweepError(f"cannot write {path}: the sweep has another file of that name; allowed: another name")
    if not is_in_folder and not path.absolute().parent.is_dir():
        raise SweepError(f"cannot write {path}: there is no folder {path.absolute().parent}")
    Writing(path, SweepError, "NetCDF").check()
    if not path.exists() or force:
        return
    known = None
    with suppress(Exception), NetcdfFile(path) as old:  # the file may be of any kind
        known = getattr(old, MARK, None)
    if known != digest:
        raise SweepError(f"{path} exists and is not the dataset of this sweep; allowed: another name, or --force")


def write_dataset(path: Path, design: Design, digest: str, folder: Path, records: Sequence[PointRecord]) -> None:
    """Write the dataset from the cubes, keeping one frame in memory at a time; the file appears once it is complete.

    Points without a cube have missing values: NaN, or ``_FillValue`` for integers.

    Raises SweepError if no point has a cube, cubes do not have the same variables, or the file cannot be written.
    """
    cubes = {record.point: folder / record.file for record in records if record.file is not None}
    if not cubes:
        raise SweepError(f"cannot write {path}: no point has a cube")
    found = differences(cubes)
    with Writing(path, SweepError, "NetCDF") as draft, NetcdfFile(draft, "w") as target:
        _Writer(target, design, records, cubes, found).write(digest)


_MISSING_INTEGER = 255
PACKING = ("scale_factor", "add_offset")


class _Writer:
    def __init__(
        self, target: Any, design: Design, records: Sequence[PointRecord], cubes: Mapping[int, Path], found: Differences
    ) -> None:
        self._target, self._design, self._records = target, design, records
        self._cubes, self._found = cubes, found
        self._dims = tuple(dimension_of(axis.key) for axis in design.axes)
        self._first = min(cubes)

    def write(self, digest: str) -> None:
        self._target.set_fill_off()
        with NetcdfFile(self._cubes[self._first]) as template:
            template.set_auto_maskandscale(False)
            self._define(template, digest)
        for record in self._records:
            index = np.unravel_index(record.point, self._design.shape)
            self._set("point_state", index, int(record.state != "done"))
            self._set("point_number", index, record.point)
            if record.point in self._cubes:
                with NetcdfFile(self._cubes[record.point]) as cube:
                    cube.set_auto_maskandscale(False)
                    self._copy(cube, index)
            else:
                self._leave_out(index)

    def _set(self, name: str, index: Any, value: Any) -> None:
        self._target.variables[name][index] = value

    def _define(self, template: Any, digest: str) -> None:
        target, found = self._target, self._found
        stamp = Provenance.creation_time().strftime("%Y-%m-%dT%H:%M:%SZ")
        same = {name: template.getncattr(name) for name in template.ncattrs() if name not in NOT_COMPARED}
        same = {name: value for name, value in same.items() if name not in found.attributes}
        target.setncatts(
            {
                **same,
                MARK: digest,
                "id": f"hcss-sweep-{digest[:16]}",
                "date_created": stamp,
                "history": f"{stamp} created by hcss_twin",
            }
        )
        for name, axis in zip(self._dims, self._design.axes, strict=True):
            target.createDimension(name, len(axis.values))
        for name, dimension in template.dimensions.items():
            target.createDimension(name, dimension.size)
        for number, axis in enumerate(self._design.axes):
            self._define_swept(number, axis.key)
        self._define_of_points("point_number", "i4", "number of the point")
        state = self._define_of_points("point_state", "i1", "outcome of the point")
        state.setncatts({"flag_values": np.array([0, 1], np.int8), "flag_meanings": "done failed"})
        for name, kind in found.attributes.items():
            self._define_of_points(_of_point(name), kind, f"global attribute {name} of the point's cube")
        for name, variable in template.variables.items():
            if name == "time" and found.starts:
                self._define_times(variable)
            else:
                self._define_variable(name, variable)

    def _define_of_points(self, name: str, kind: Any, long_name: str) -> Any:
        variable = self._target.createVariable(name, kind, self._dims, fill_value=None if kind is str else False)
        variable.setncatts({"long_name": long_name, "coverage_content_type": "auxiliaryInformation"})
        return variable

    def _define_swept(self, axis_number: int, key: str) -> None:
        shape = self._design.shape
        step = int(np.prod(shape[axis_number + 1 :]))
        values = [self._records[number * step].values[key] for number in range(shape[axis_number])]
        numbers, kind, attributes = swept_coordinate(key, values)
        name, fill = self._dims[axis_number], None if kind is str else False
        coordinate = self._target.createVariable(name, kind, (name,), fill_value=fill)
        coordinate.setncatts(attributes)
        coordinate[:] = np.array(numbers, dtype=object if kind is str else kind)

    def _define_variable(self, name: str, variable: Any) -> None:
        found = self._found
        if name == FrameSelection.GRID_MAPPING and found.moves:
            return  # CF allows no plane per location; latitude and longitude remain
        is_data = _is_data(variable)
        of_point = "_FillValue", "packing_maximum_relative_error", "packing_maximum_error_kelvin"
        attributes = {key: variable.getncattr(key) for key in variable.ncattrs() if key not in of_point}
        if found.moves:
            attributes.pop("grid_mapping", None)
        if found.starts and "time" in variable.dimensions and "coordinates" in attributes:
            attributes["coordinates"] += f" {ELAPSED_TIME} {FRAME_TIME}"
        dims = (*self._dims, *variable.dimensions) if is_data or name in found.variables else variable.dimensions
        kind = str if variable.dtype is str else variable.dtype
        fill: Any = variable.getncattr("_FillValue") if "_FillValue" in variable.ncattrs() else False
        if is_data and len(self._cubes) < len(self._records) and PACKING[0] not in attributes:
            fill = np.nan if np.dtype(kind).kind == "f" else _MISSING_INTEGER
        filters = variable.filters() or {}
        layout: dict[str, Any] = {}
        if is_data and filters.get("zlib"):
            chunk = (*(1 for _ in self._dims), *variable.chunking())
            layout = {"compression": "zlib", "complevel": filters["complevel"], "chunksizes": chunk}
        elif kind is not str:
            layout = {"contiguous": True}
        copy = self._target.createVariable(name, kind, dims, fill_value=None if kind is str else fill, **layout)
        copy.set_auto_maskandscale(False)
        copy.setncatts(attributes)
        if not is_data and name not in found.variables:
            copy[...] = variable[...]

    def _define_times(self, variable: Any) -> None:
        """Define variables for time since the start of a point, and for absolute time."""
        elapsed = self._target.createVariable(ELAPSED_TIME, "f8", ("time",), fill_value=False)
        elapsed.setncatts(_ELAPSED_ATTRIBUTES)
        elapsed[:] = variable[:]
        dated = self._target.createVariable(FRAME_TIME, "f8", (*self._dims, "time"), fill_value=np.nan)
        dated.setncatts(_FRAME_TIME_ATTRIBUTES)

    def _copy(self, cube: Any, index: Any) -> None:
        found = self._found
        for name, kind in found.attributes.items():
            self._set(_of_point(name), index, getattr(cube, name, _nothing(kind)))
        if found.starts:
            start = seconds_since_epoch(cube.variables["time"].units)
            self._set(FRAME_TIME, index, start + cube.variables["time"][...])
        for name, variable in cube.variables.items():
            if _is_data(variable):
                for frame in range(variable.shape[0]):
                    self._set(name, (*index, frame), variable[frame])
            elif name in found.variables:
                self._set(name, index, variable[...])

    def _leave_out(self, index: Any) -> None:
        for name, variable in self._target.variables.items():
            is_of_points = variable.dimensions[: len(self._dims)] == self._dims
            if not is_of_points or name in self._dims or name.startswith("point_"):
                continue
            missing = _PACKED_MISSING if PACKING[0] in variable.ncattrs() else _nothing(variable.dtype)
            for frame in range(variable.shape[len(self._dims)]) if "time" in variable.dimensions else (Ellipsis,):
                self._set(name, (*index, frame), missing)
        for name, kind in self._found.attributes.items():
            self._set(_of_point(name), index, _nothing(kind))


def _is_data(variable: Any) -> bool:
    """Whether a variable of a cube is an image, and no coordinate."""
    return not {"grid_mapping", "coordinates"}.isdisjoint(variable.ncattrs())


def _same(one: Any, other: Any) -> bool:
    """Whether two coordinates are equal; places of pixels that miss the ground are NaN in both."""
    return np.array_equal(one, other, equal_nan=np.asarray(one).dtype.kind == "f")


def _nothing(kind: Any) -> Any:
    """Return the placeholder for a missing value."""
    if kind is str:
        return ""
    return np.nan if np.dtype(kind).kind == "f" else _MISSING_INTEGER


def _of_point(attribute: str) -> str:
    return f"point_{attribute.removeprefix('hcss_')}"


def dimension_of(key: str) -> str:
    """Return the name of the dimension of a swept key: ``view_zenith`` of ``view.zenith``.

    A cube already has a dimension ``time``, so the scenario's becomes ``start_time``.
    """
    return "start_time" if key == "time" else re.sub(r"\W", "_", key, flags=re.ASCII)


FRAME_TIME = "frame_time"
"""Variable with the absolute time of each frame of each point, used if points start at different times."""

ELAPSED_TIME = "elapsed_time"
"""Variable with the time since the start of a point in that case; ``time`` then has no coordinate."""

_EPOCH = "seconds since 1970-01-01 00:00:00"


def _instant(value: Any) -> datetime:
    return value if isinstance(value, datetime) else datetime.fromisoformat(value)


def swept_coordinate(key: str, values: Sequence[Any]) -> tuple[list[Any], Any, dict[str, Any]]:
    """Return the values along a dimension, their type and their attributes.

    Numbers and text are unchanged, dates and times become seconds since 1970, and everything else becomes JSON.
    """
    attributes: dict[str, Any] = {
        "long_name": f"swept key {key}",
        "hcss_key": key,
        "coverage_content_type": "coordinate",
    }
    if key == "time":
        seconds = [_instant(value).timestamp() for value in values]
        of_time = {"units": _EPOCH, "calendar": "standard", "units_metadata": "leap_seconds: none"}
        return seconds, "f8", {**attributes, **of_time}
    if all(isinstance(value, int) and not isinstance(value, bool) for value in values):
        return list(values), "i8", attributes
    if all(isinstance(value, int | float) and not isinstance(value, bool) for value in values):
        return list(map(float, values)), "f8", attributes
    return [value if isinstance(value, str) else json.dumps(value) for value in values], str, attributes


_ELAPSED_ATTRIBUTES = {
    "long_name": "time of the frame after the start of the point",
    "comment": f"Instants are in {FRAME_TIME}.",
    "units": "s",
    "coverage_content_type": "coordinate",
}


_FRAME_TIME_ATTRIBUTES = {
    "long_name": "time of the frame",
    "standard_name": "time",
    "units": _EPOCH,
    "units_metadata": "leap_seconds: none",
    "calendar": "standard",
    "coverage_content_type": "coordinate",
}


def seconds_since_epoch(units: str) -> float:
    """Return the reference time in a cube's time units, in seconds since 1970."""
    start = datetime.fromisoformat(units.removeprefix("seconds since "))
    return start.replace(tzinfo=UTC).timestamp()


_PACKED_MISSING = -32768
"""Number of missing values in packed variables of cubes."""

NOT_COMPARED = frozenset({"date_created", "history", "id", "hcss_cube_format"})
"""Global attributes of a cube that are not copied to the dataset."""


@dataclass(frozen=True)
class Differences:
    """Attributes and coordinates that differ between cubes and get the swept dimensions.

    ``attributes`` are global attributes with the types of their variables, ``variables`` coordinates; ``starts`` states
    whether the first frames are at different times, ``moves`` whether the images are at different locations.
    """

    attributes: Mapping[str, Any]
    variables: frozenset[str]
    starts: bool
    moves: bool


def differences(cubes: Mapping[int, Path]) -> Differences:
    """Compare all cubes with the first, one at a time.

    Raises SweepError if one has other variables, or variables of other sizes.
    """
    numbers = sorted(cubes)
    attributes: dict[str, Any] = {}
    variables: set[str] = set()
    starts = moves = False
    with NetcdfFile(cubes[numbers[0]]) as first:
        first.set_auto_maskandscale(False)
        layout = _layout(first)
        for number in numbers[1:]:
            with NetcdfFile(cubes[number]) as other:
                other.set_auto_maskandscale(False)
                _require_same_layout(layout, _layout(other), numbers[0], number)
                for name in sorted({*first.ncattrs(), *other.ncattrs()} - NOT_COMPARED):
                    one, another = (getattr(cube, name, None) for cube in (first, other))
                    if one != another:
                        known = another if one is None else one
                        attributes[name] = str if isinstance(known, str) else "f8"
                for name, variable in first.variables.items():
                    twin = other.variables[name]
                    if not _is_data(variable) and not _same(variable[...], twin[...]):
                        variables.add(name)
                starts |= first.variables["time"].units != other.variables["time"].units
                if FrameSelection.GRID_MAPPING in first.variables:  # images of cameras have none
                    plane, another = (file.variables[FrameSelection.GRID_MAPPING] for file in (first, other))
                    moves |= any(plane.getncattr(name) != another.getncattr(name) for name in plane.ncattrs())
    return Differences(attributes, frozenset(variables), starts, moves)


def _layout(cube: Any) -> dict[str, tuple[str, tuple[str, ...], tuple[int, ...]]]:
    return {
        name: (
            " ".join(
                [str(variable.dtype), *(f"{key} {getattr(variable, key)}" for key in PACKING if hasattr(variable, key))]
            ),
            variable.dimensions,
            variable.shape,
        )
        for name, variable in cube.variables.items()
    }


def _require_same_layout(first: Mapping[str, Any], other: Mapping[str, Any], one: int, another: int) -> None:
    unlike = sorted(name for name in {*first, *other} if first.get(name) != other.get(name))
    if unlike:
        raise SweepError(
            f"cannot write one dataset: cubes of points {one} and {another} differ in the variables "
            f"{', '.join(unlike)}, their sizes or their packing; the cubes themselves are complete"
        )
