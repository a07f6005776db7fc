"""Comparison of a cube with its recomputation."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.errors import CubeError
from hcss_twin.core.reading import Reading
from hcss_twin.cube.coordinates import COORDINATES, GRID_MAPPING, coordinate_specs, coordinate_values
from hcss_twin.cube.geometry import PixelGeometry
from hcss_twin.cube.header import CubeHeader
from hcss_twin.cube.variables import GEOMETRY, LAYER, VariableSpec
from hcss_twin.engine.provenance import Change

TOLERANCE = 1e-6
"""Largest relative difference that counts as equal; single precision resolves 6e-8."""

SAME_TIME_NS = 1000
"""Tolerance for frame times, for readers and writers that round."""


@dataclass(frozen=True)
class ValueAt:
    """Position of a value: frame, row and column number from 0, band and layer name."""

    position: Mapping[str, int | str]
    cube: float
    recomputed: float


@dataclass(frozen=True)
class VariableCheck:
    """The comparison of one variable.

    Attributes
    ----------
    relative_to : str
        Reference of relative differences: ``value``, ``largest`` (of the variable in the frame, or in the tile of a
        large one) or ``exact`` if any difference counts.
    values, unequal, beyond : int
        Number of values compared, not bit-identical, and beyond the tolerance.
    largest : float
        Largest relative difference; infinite if only one of the two is a number.
    largest_at, first : ValueAt or None
        Position of the largest difference, and of the first value beyond the tolerance or, if there is none, the
        first unequal value.
    """

    name: str
    relative_to: str
    values: int = 0
    unequal: int = 0
    beyond: int = 0
    largest: float = 0.0
    largest_at: ValueAt | None = None
    first: ValueAt | None = None

    def extended(self, cube: NDArray[Any], ours: NDArray[Any], value_at: Callable[[int], ValueAt]) -> VariableCheck:
        """Return the check extended by two arrays of equal shape; ``value_at`` describes the values at an index."""
        known, unequal = replace(self, values=self.values + ours.size), _unequal(cube, ours)
        if not unequal.any():
            return known
        difference = _difference(cube, ours, self.relative_to)
        beyond = unequal & (difference > (0.0 if self.relative_to == "exact" else TOLERANCE))
        if self.first is None or (not self.beyond and beyond.any()):
            known = replace(known, first=value_at(int(np.argmax(beyond if beyond.any() else unequal))))
        at = int(np.argmax(difference))
        if self.largest_at is None or difference.flat[at] > self.largest:
            known = replace(known, largest=float(difference.flat[at]), largest_at=value_at(at))
        counts = self.unequal + int(unequal.sum()), self.beyond + int(beyond.sum())
        return replace(known, unequal=counts[0], beyond=counts[1])


def _unequal(cube: NDArray[Any], ours: NDArray[Any]) -> NDArray[np.bool_]:
    """Mask of bitwise differences of two arrays; for different types, of different values."""
    if cube.dtype != ours.dtype:
        different: NDArray[np.bool_] = (cube != ours) & ~(np.isnan(cube) & np.isnan(ours))
        return different
    one, other = (
        np.ascontiguousarray(array).reshape(array.shape).view(f"u{ours.dtype.itemsize}") for array in (cube, ours)
    )
    return np.asarray(one != other)


def _difference(cube: NDArray[Any], ours: NDArray[Any], relative_to: str) -> NDArray[np.float64]:
    """Relative difference; infinite if only one of the two is finite."""
    a, b = cube.astype(np.float64), ours.astype(np.float64)
    finite = np.isfinite(a) & np.isfinite(b)
    scale = np.maximum(np.abs(a), np.abs(b))
    largest = float(np.max(np.abs(b[np.isfinite(b)]), initial=0.0))
    if relative_to == "largest" and largest > 0.0:
        scale = np.full_like(b, largest)
    apart = np.where(finite | (np.isnan(a) & np.isnan(b)), 0.0, np.inf)
    with np.errstate(invalid="ignore"):
        np.divide(np.abs(a - b), scale, out=apart, where=finite & (scale > 0))
    return apart


class CubeComparison:
    """A cube and its recomputation: frames are matched by time, bands and layers by name.

    Parameters
    ----------
    axes : mapping of str to ndarray
        Frame times, and names of bands and layers of the cube.
    header : CubeHeader
        Header of the recomputation.

    Attributes
    ----------
    frames : list of (int, int)
        Numbers of the common frames, in the cube and in the recomputation.
    changes : list of Change
        Differences between the cube's layout and the one its scenario defines.
    checks : dict of str to VariableCheck
        Checks by variable, coordinates first.
    """

    def __init__(self, path: str, file: Any, axes: Mapping[str, NDArray[Any]], header: CubeHeader) -> None:
        self._path, self._file, self._header, self._geometry = path, file, header, PixelGeometry(header)
        self.changes: list[Change] = []
        self.checks: dict[str, VariableCheck] = {}
        self.frames = self._match_frames(axes["time"].astype("datetime64[ns]").astype(np.int64))
        # Along each dimension, indices of common entries in the cube and in the recomputation.
        self._common = {"time": tuple(zip(*self.frames, strict=True)) or ((), ())}
        self._labels: dict[str, list[str]] = {}
        names = {"band": [band.name for band in header.bands], LAYER: [layer.name for layer in header.layers]}
        for dim in ("band", *((LAYER,) if LAYER in header.sizes else ())):
            theirs, ours = [str(label) for label in axes.get(dim, [])], names[dim]
            self._expect(f"{dim}s", ", ".join(theirs), ", ".join(ours))
            self._labels[dim] = both = [name for name in ours if name in theirs]
            self._common[dim] = tuple(map(theirs.index, both)), tuple(map(ours.index, both))
        rows, columns = (
            file.dimensions[dim].size if dim in file.dimensions else 0 for dim in header.in_file(("y", "x"))
        )
        image = self._expect("rows", rows, header.sizes["y"]), self._expect("columns", columns, header.sizes["x"])
        self._specs = self._comparable(all(image))
        values = coordinate_values(header)
        for name in self._specs:
            if name in values:
                self._add(name, ..., values[name], self._specs[name].dims)
        self._add_geometry(self._geometry.of_image, None, 0.0, None)

    def add_part(
        self, theirs: int, ours: int, window: tuple[slice, slice] | None, arrays: Mapping[str, NDArray[Any]]
    ) -> None:
        """Compare a frame, or the part of it given by ``window``, with the recomputation."""
        self._add_geometry(self._geometry.of_frames, theirs, self._header.frame_times_s[ours], window)
        corner = (0, 0) if window is None else (window[0].start, window[1].start)
        index: Any = theirs if window is None else (theirs, ..., *window)
        for spec in self._header.variables:
            if spec.name in self._specs:
                dims = [dim for dim in spec.dims if dim != "time"]
                self._add(spec.name, index, arrays[spec.name], dims, theirs, corner)

    def _expect(self, what: str, cube: object, ours: object) -> bool:
        if cube != ours:
            self.changes.append(Change(what, str(cube) or "none", str(ours) or "none"))
        return cube == ours

    def _match_frames(self, theirs: NDArray[np.int64]) -> list[tuple[int, int]]:
        start = np.datetime64(self._header.start_utc.replace(tzinfo=None), "ns").astype(np.int64)
        ours = start + np.round(np.asarray(self._header.frame_times_s) * 1e9).astype(np.int64)
        # The first recomputed frame that is not earlier, within the rounding of readers.
        nearest = np.minimum(np.searchsorted(ours, theirs - SAME_TIME_NS), ours.size - 1)
        same = np.abs(ours[nearest] - theirs) <= SAME_TIME_NS
        if self._expect("frames", theirs.size, ours.size) and not same.all():
            first, now = (np.datetime64(int(times[0]), "ns").astype("datetime64[ms]") for times in (theirs, ours))
            self.changes.append(Change("times of frames", f"from {first} UTC", f"from {now} UTC"))
        return list(zip(np.flatnonzero(same).tolist(), nearest[same].tolist(), strict=True))

    def _comparable(self, same_image: bool) -> dict[str, VariableSpec]:
        """Return the common variables with equal dimensions, coordinates first; others are recorded as changes."""
        values, header = coordinate_values(self._header), self._header
        coordinates = [
            spec
            for spec in coordinate_specs(header)
            if spec.name in values and spec.dtype != "str" and spec.name != "time"
        ]
        ours = {spec.name: spec for spec in (*coordinates, *header.geometry, *header.variables)}
        # Variables that a cube may have in addition.
        known = {spec.name for spec in COORDINATES} - set(ours) | {GRID_MAPPING}
        located = {spec.name for spec in GEOMETRY}
        theirs = {
            name: ", ".join(variable.dimensions)
            for name, variable in self._file.variables.items()
            if name in ours or (name not in known and ("time" in variable.dimensions or name in located))
        }
        dims = {name: ", ".join(header.in_file(spec.dims)) for name, spec in ours.items()}
        lacking, extra = ({f"{n} ({d})" for n, d in dims.items()}, {f"{n} ({d})" for n, d in theirs.items()})
        self._expect("variables", "; ".join(sorted(extra - lacking)), "; ".join(sorted(lacking - extra)))
        for spec in header.variables:
            if spec.name in theirs:
                self._expect(f"type of {spec.name}", str(self._file[spec.name].dtype), str(np.dtype(spec.stored_dtype)))
        return {
            name: spec
            for name, spec in ours.items()
            if theirs.get(name) == dims[name] and (same_image or not {"x", "y"} & set(spec.dims))
        }

    def _add_geometry(
        self, names: Sequence[str], frame: int | None, time_s: float, inside: tuple[slice, slice] | None
    ) -> None:
        """Compare per-pixel coordinates, of one frame or of all, part by part."""
        present = tuple(name for name in names if name in self._specs)
        for window, values in self._geometry.parts(present, time_s=time_s, inside=inside):
            index: Any = window if frame is None else (frame, *window)
            for name, ours in values.items():
                self._add(name, index, ours, ("y", "x"), frame, (window[0].start, window[1].start))

    def _add(
        self,
        name: str,
        index: Any,
        ours: NDArray[Any],
        dims: Sequence[str],
        frame: int | None = None,
        corner: tuple[int, int] = (0, 0),
    ) -> None:
        """Compare part of a variable, of a ``frame`` if it has frames, starting at row and column ``corner``."""
        with Reading(self._path, CubeError):
            cube = np.asarray(self._file[name][index])
        for axis, dim in enumerate(dims):
            if dim in self._common:
                theirs, our_indices = self._common[dim]
                cube, ours = cube.take(theirs, axis), ours.take(our_indices, axis)
        offsets = {"y": corner[0], "x": corner[1]}

        def value_at(flat: int) -> ValueAt:
            indices = np.unravel_index(flat, ours.shape)
            position: dict[str, int | str] = {} if frame is None else {"frame": frame}
            for dim, number in zip(dims, map(int, indices), strict=True):
                called = {"time": "frame", "y": "row", "x": "column"}.get(dim, dim)
                position[called] = self._labels[dim][number] if dim in self._labels else number + offsets.get(dim, 0)
            return ValueAt(position, float(cube[indices]), float(ours[indices]))

        spec = self._specs[name]
        relative_to = "exact" if np.dtype(spec.dtype).kind != "f" else "value" if spec.needs_radiance else "largest"
        known = self.checks.get(name) or VariableCheck(name, relative_to)
        self.checks[name] = known.extended(cube, ours, value_at)
