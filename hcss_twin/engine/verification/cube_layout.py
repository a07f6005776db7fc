"""Which frames, bands and variables of a cube are which of its recomputation."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.errors import CubeError
from hcss_twin.cube.coordinates import COORDINATES, GRID_MAPPING, coordinate_values
from hcss_twin.cube.geometry import PixelGeometry
from hcss_twin.cube.header import CubeHeader
from hcss_twin.cube.reader import stored_arrays
from hcss_twin.cube.variables import GEOMETRY, LAYER, VariableSpec
from hcss_twin.engine.recorded import Change, VariableCheck
from hcss_twin.engine.verification.value_comparison import ValueComparison

if TYPE_CHECKING:
    import xarray as xr


_SAME_TIME_NS = 1000
"""Nanoseconds between times of one frame, for readers and writers that round."""


class CubeLayout:
    """Times, bands and layers of a cube.

    Parameters
    ----------
    path : path
    dataset : Dataset
        The cube, open; it is not kept.
    """

    def __init__(self, path: str | os.PathLike[str], dataset: xr.Dataset) -> None:
        self.path = path
        time = dataset["time"].to_numpy() if "time" in dataset else np.empty(0)
        if time.ndim != 1 or time.dtype.kind != "M":
            raise CubeError(f"cannot read {os.fspath(path)}: it has no times of frames (coordinate time)")
        self.time_ns: NDArray[np.int64] = time.astype("datetime64[ns]").astype(np.int64)
        self.names = {
            dim: [str(each) for each in dataset[dim].to_numpy()] for dim in ("band", LAYER) if dim in dataset.coords
        }

    @property
    def frames(self) -> int:
        """Number of frames."""
        return int(self.time_ns.size)

    @contextmanager
    def matched(self, header: CubeHeader) -> Iterator[MatchedCube]:
        """Open the cube beside what its recomputation will have.

        Raises
        ------
        CubeError
            If the file cannot be read, also while it is used.
        """
        with ExitStack() as stack:
            with _reading(self.path):
                file = stack.enter_context(stored_arrays(self.path))
            yield MatchedCube(self, header, file)


class MatchedCube:
    """A cube whose frames, bands and layers are matched by time and name with those of a header.

    Attributes
    ----------
    frames : list of (int, int)
        Numbers of the frames that both have, in the cube and in the recomputation.
    """

    def __init__(self, layout: CubeLayout, header: CubeHeader, file: Any) -> None:
        self._path, self._file, self._header = layout.path, file, header
        self._changes: list[Change] = []
        self.frames = self._matched_frames(layout, header)
        ours = {"band": [band.name for band in header.bands], LAYER: [layer.name for layer in header.layers]}
        if LAYER not in header.sizes:
            del ours[LAYER]
        # Numbers along each named dimension, of the cube and of the recomputation.
        self._common = {dim: self._matched_names(dim, layout.names.get(dim, []), ours[dim]) for dim in ours}
        self._labels = {dim: [ours[dim][index] for index in pair[1]] for dim, pair in self._common.items()}
        same_image = True
        for dim in ("y", "x"):
            size = file.dimensions[dim].size if dim in file.dimensions else 0
            if size != header.sizes[dim]:
                self._tell("rows" if dim == "y" else "columns", size, header.sizes[dim])
                same_image = False
        specs = self._present() if same_image else []
        self._specs = {spec.name: spec for spec in specs}
        self._checks = {spec.name: ValueComparison(spec, self._labels) for spec in specs}
        self._coordinates = list(self._compared_coordinates())
        self._geometry = PixelGeometry(header)
        located = self._present_geometry() if same_image else []
        self._located = {spec.name: ValueComparison(spec, self._labels) for spec in located}
        self._compare_geometry(self._geometry.of_image, None, 0.0, None)

    @property
    def changes(self) -> tuple[Change, ...]:
        """What the cube does not have as its scenario makes it."""
        return tuple(self._changes)

    def compare_part(self, number: int, place: tuple[slice, slice] | None, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Compare frame ``number`` of the cube, or the rows and columns ``place`` of it, with the recomputation."""
        index = number if place is None else (number, ..., *place)
        corner = (0, 0) if place is None else (place[0].start, place[1].start)
        for name, check in self._checks.items():
            dims = [dim for dim in self._specs[name].dims if dim != "time"]
            cube = self._read(name, index)
            check.add(self._taken(cube, dims, 0), self._taken(arrays[name], dims, 1), dims, number, corner)
        time_s = self._header.frame_times_s[dict(self.frames)[number]]
        self._compare_geometry(self._geometry.of_frames, number, time_s, place)

    def results(self) -> tuple[VariableCheck, ...]:
        """Return what was found, coordinates first."""
        checks = (*self._located.values(), *self._checks.values())
        return (*self._coordinates, *(check.result() for check in checks))

    def _tell(self, what: str, cube: object, ours: object) -> None:
        self._changes.append(Change(what, str(cube), str(ours)))

    def _matched_frames(self, layout: CubeLayout, header: CubeHeader) -> list[tuple[int, int]]:
        start = np.datetime64(header.start_utc.replace(tzinfo=None), "ns").astype(np.int64)
        ours = start + np.round(np.asarray(header.frame_times_s) * 1e9).astype(np.int64)
        # The first of ours that is not earlier by more than what readers round.
        nearest = np.minimum(np.searchsorted(ours, layout.time_ns - _SAME_TIME_NS), ours.size - 1)
        pairs = [
            (theirs, int(index))
            for theirs, index in enumerate(nearest)
            if abs(int(ours[index]) - int(layout.time_ns[theirs])) <= _SAME_TIME_NS
        ]
        if layout.frames != header.frames:
            self._tell("frames", layout.frames, header.frames)
        elif [index for _, index in pairs] != list(range(header.frames)):
            self._tell("times of frames", _span(layout.time_ns), _span(ours))
        return pairs

    def _matched_names(self, dim: str, cube: Sequence[str], ours: Sequence[str]) -> tuple[list[int], list[int]]:
        if list(cube) != list(ours):
            self._tell(f"{dim}s", ", ".join(cube) or "none", ", ".join(ours))
        common = [name for name in ours if name in cube]
        return [list(cube).index(name) for name in common], [list(ours).index(name) for name in common]

    def _present(self) -> list[VariableSpec]:
        """Return the variables that can be compared, and tell of those that cannot."""
        specs = {spec.name: spec for spec in self._header.variables}
        others = {spec.name for spec in (*COORDINATES, *GEOMETRY)} | {GRID_MAPPING}
        cube = [name for name, each in self._file.variables.items() if name not in others and "time" in each.dimensions]
        if set(cube) != set(specs):
            self._tell("variables", ", ".join(cube) or "none", ", ".join(specs))
        present = []
        for name, spec in specs.items():
            if name not in cube:
                continue
            found = self._file[name]
            if found.dtype != np.dtype(spec.dtype):
                self._tell(f"type of {name}", found.dtype, spec.dtype)
            if found.dimensions != spec.dims:
                self._tell(f"dimensions of {name}", ", ".join(found.dimensions), ", ".join(spec.dims))
            else:
                present.append(spec)
        return present

    def _present_geometry(self) -> list[VariableSpec]:
        """Return the coordinates of pixels that can be compared, and tell of those that cannot."""
        wanted = {spec.name: spec for spec in self._header.geometry}
        cube = [spec.name for spec in GEOMETRY if spec.name in self._file.variables]
        if set(cube) != set(wanted):
            self._tell("coordinates of pixels", ", ".join(cube) or "none", ", ".join(wanted) or "none")
        present = [spec for name, spec in wanted.items() if name in cube]
        for spec in present:
            if (found := self._file[spec.name].dimensions) != spec.dims:
                self._tell(f"dimensions of {spec.name}", ", ".join(found), ", ".join(spec.dims))
        return [spec for spec in present if self._file[spec.name].dimensions == spec.dims]

    def _compare_geometry(
        self, names: tuple[str, ...], frame: int | None, time_s: float, inside: tuple[slice, slice] | None
    ) -> None:
        """Compare coordinates of pixels, of one frame or of all, part by part; of all rows and columns by default."""
        present = tuple(name for name in names if name in self._located)
        for place, values in self._geometry.parts(present, time_s=time_s, inside=inside):
            corner = place[0].start, place[1].start
            for name, ours in values.items():
                cube = self._read(name, place if frame is None else (frame, *place))
                self._located[name].add(cube, ours, ("y", "x"), frame, corner)

    def _compared_coordinates(self) -> Iterator[VariableCheck]:
        """Compare all coordinates but the times and names that frames and bands were matched by."""
        values = coordinate_values(self._header)
        for spec in COORDINATES:
            if spec.name == "time" or spec.name not in values or spec.dtype == "str":
                continue
            if spec.name not in self._file.variables:
                self._tell(f"coordinate {spec.name}", "none", "written")
                continue
            cube = self._taken(self._read(spec.name, ...), spec.dims, 0)
            ours = self._taken(values[spec.name], spec.dims, 1)
            if cube.shape != ours.shape:
                if not {"x", "y"} & set(spec.dims):  # told already
                    self._tell(f"shape of {spec.name}", cube.shape, ours.shape)
                continue
            check = ValueComparison(spec, self._labels)
            check.add(cube, ours, spec.dims)
            yield check.result()

    def _read(self, name: str, index: Any) -> NDArray[Any]:
        with _reading(self._path):
            return np.asarray(self._file[name][index])

    def _taken(self, array: NDArray[Any], dims: Sequence[str], which: int) -> NDArray[Any]:
        """Take what both have, along frames, bands and layers, of the cube (0) or of the recomputation (1)."""
        for axis, dim in enumerate(dims):
            common = [pair[which] for pair in self.frames] if dim == "time" else None
            if dim in self._common:
                common = self._common[dim][which]
            if common is not None and common != list(range(array.shape[axis])):
                array = array.take(common, axis)
        return array


@contextmanager
def _reading(path: str | os.PathLike[str]) -> Iterator[None]:
    try:
        yield
    except (OSError, RuntimeError, IndexError) as error:
        raise CubeError(f"cannot read {os.fspath(path)}: {error}") from error


def _span(time_ns: NDArray[np.int64]) -> str:
    if not time_ns.size:
        return "none"
    first, last = (np.datetime64(int(each), "ns").astype("datetime64[ms]") for each in (time_ns[0], time_ns[-1]))
    return f"{time_ns.size} from {first} to {last} UTC"
