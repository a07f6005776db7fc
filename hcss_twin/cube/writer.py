"""Writing of a cube, frame by frame, so that the final name only ever holds a finished one."""

from __future__ import annotations

import contextlib
import math
import os
import secrets
import shutil
from collections.abc import Iterator, Mapping
from pathlib import Path
from threading import RLock
from types import TracebackType
from typing import Any, Self

import netCDF4
import numpy as np
from numpy.typing import NDArray

from hcss_twin.cube.bit_rounding import INFO, largest_error
from hcss_twin.cube.coordinates import (
    BOUND,
    COORDINATES,
    GRID_MAPPING,
    VERTEX,
    auxiliary_names,
    coordinate_values,
    grid_mapping_attributes,
    is_bounds,
    time_units,
)
from hcss_twin.cube.frames import check_frame, frame_shape
from hcss_twin.cube.geometry import PixelGeometry
from hcss_twin.cube.header import FORMAT_ATTRIBUTE, FORMAT_VERSION, Attribute, CubeHeader, check_attributes
from hcss_twin.cube.metadata import global_attributes
from hcss_twin.cube.variables import VariableSpec
from hcss_twin.errors import CubeError
from hcss_twin.version import __version__

_LARGEST_CHUNK_BYTES = 2**26
_METADATA_BYTES = 2**17


class CubeWriter:
    """Context manager that streams frames into a NetCDF-4 file.

    The file grows under a hidden name ending in ``.partial`` in the same folder. Leaving the block
    with all frames written makes it durable and renames it to ``path``, replacing an older file in
    one step; leaving it through any exception removes it. Memory does not depend on the number of
    frames. Calls from several threads take turns; other netCDF calls at the same time are not allowed,
    because the library is not thread safe.

    Parameters
    ----------
    path : path-like
        Final name of the file; its folder must exist.
    header : CubeHeader
        Everything but the frames.
    compression : int, optional
        zlib level 1 to 9; None stores plain numbers, which is more than ten times faster.

    Raises
    ------
    CubeError
        On a folder that is missing or cannot be written, a full disk, or frames that do not match
        the header.
    """

    def __init__(
        self, path: str | os.PathLike[str], header: CubeHeader, *, compression: int | None = None
    ) -> None:
        if compression is not None and not 1 <= compression <= 9:
            raise CubeError(f"compression: {compression}; a zlib level from 1 to 9, or none, is allowed")
        self.path = Path(path)
        self.header = header
        self.compression = compression
        self._partial = self.path.with_name(f".{self.path.name}.{secrets.token_hex(4)}.partial")
        self._geometry = PixelGeometry(header)
        self._dataset: Any = None
        self._written: set[int] = set()
        self._turn = RLock()

    def __enter__(self) -> Self:
        self._claim()
        try:
            with self._explained():
                self._dataset = netCDF4.Dataset(self._partial, "w", format="NETCDF4")
                self._define()
                self._dataset.sync()
        except BaseException:
            self._discard()
            raise
        return self

    def write_frame(self, index: int, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Write one frame; frames may come in any order, each once.

        Parameters
        ----------
        index : int
            Number of the frame, from 0.
        arrays : mapping of str to ndarray
            One array per variable of the header, without the time dimension, of the type in its spec.

        Raises
        ------
        CubeError
            If arrays do not match the header, a value is not allowed, or the disk refuses.
        """
        with self._turn:
            if self._dataset is None:
                raise CubeError(
                    f"{self.path}: not open for writing; frames are written inside a 'with' block"
                )
            if not 0 <= index < self.header.frames:
                raise CubeError(f"frame {index}: 0 to {self.header.frames - 1} is allowed")
            if index in self._written:
                raise CubeError(f"frame {index}: already written")
            check_frame(self.header, index, arrays)
            with self._explained():
                for name, array in arrays.items():
                    self._dataset.variables[name][index] = array
                names, time_s = self._geometry.of_frames, self.header.frame_times_s[index]
                for rows, values in self._geometry.parts(names, time_s):
                    for name, array in values.items():
                        self._dataset.variables[name][index, rows] = array
            self._written.add(index)

    def set_attributes(self, attributes: Mapping[str, Attribute]) -> None:
        """Add global attributes that are known only once frames are written.

        Parameters
        ----------
        attributes : mapping
            Names that the cube does not have yet.

        Raises
        ------
        CubeError
            If a name is taken, a value cannot be stored, or the disk refuses.
        """
        if self._dataset is None:
            raise CubeError(f"{self.path}: not open for writing; attributes are set inside a 'with' block")
        check_attributes(attributes)
        for name in attributes:
            if name == FORMAT_ATTRIBUTE or name in self._dataset.ncattrs():
                raise CubeError(f"attribute {name}: the cube has it already; it cannot be given again")
        with self._explained():
            for name, value in attributes.items():
                self._dataset.setncattr(name, value)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        with self._turn:
            try:
                if kind is None:
                    self._finish()
            finally:
                # after _finish the partial name is gone and this does nothing
                self._discard()

    def _claim(self) -> None:
        """Create the partial file, which says more about what is wrong with a path than netCDF does."""
        if not self.path.parent.is_dir():
            raise CubeError(f"cannot write {self.path}: there is no folder {self.path.parent}")
        if self.path.is_dir():
            raise CubeError(f"cannot write {self.path}: it is a folder")
        try:
            free = shutil.disk_usage(self.path.parent).free
            os.close(os.open(self._partial, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
        except OSError as error:
            raise CubeError(f"cannot write {self.path}: {error.strerror}") from error
        needed = self._plain_bytes()
        if self.compression is None and needed > free:
            self._discard()
            raise CubeError(
                f"cannot write {self.path}: it needs {needed / 1e6:.1f} MB, "
                f"the disk has {free / 1e6:.1f} MB free"
            )

    def _finish(self) -> None:
        missing = sorted(set(range(self.header.frames)) - self._written)
        if missing:
            listed = ", ".join(map(str, missing[:10])) + (", ..." if len(missing) > 10 else "")
            raise CubeError(
                f"{self.path}: {len(missing)} of {self.header.frames} frames were not written: {listed}"
            )
        with self._explained():
            self._dataset.setncattr(FORMAT_ATTRIBUTE, np.int32(FORMAT_VERSION))
            self._dataset.close()
            _flush(self._partial)
            os.replace(self._partial, self.path)
            _flush(self.path.parent)

    def _discard(self) -> None:
        dataset, self._dataset = self._dataset, None
        if dataset is not None and dataset.isopen():
            with contextlib.suppress(RuntimeError, OSError):
                dataset.close()
        with contextlib.suppress(FileNotFoundError):
            # after a failed write the library may keep the file open, and a removed file that is open
            # still fills the disk
            os.truncate(self._partial, 0)
            self._partial.unlink()

    @contextlib.contextmanager
    def _explained(self) -> Iterator[None]:
        """Turn errors of the library, which never tell the cause, into one with path and free space."""
        try:
            yield
        except (RuntimeError, OSError) as error:
            cause = getattr(error, "strerror", None) or str(error)
            try:
                free = float(shutil.disk_usage(self.path.parent).free)
            except OSError:
                free = math.nan
            full = "the disk is full: " if free < _METADATA_BYTES else ""
            raise CubeError(
                f"cannot write {self.path}: {full}{cause} (free on this disk: {free / 1e6:.1f} MB; "
                f"the cube needs up to {self._plain_bytes() / 1e6:.1f} MB)"
            ) from error

    def _plain_bytes(self) -> int:
        """Return the size of the file without compression."""
        planes = sum(
            math.prod(frame_shape(self.header, spec)) * np.dtype(spec.dtype).itemsize
            for spec in (*self.header.variables, *self.header.geometry)
        )
        return self.header.frames * planes + _METADATA_BYTES

    def _define(self) -> None:
        dataset, header = self._dataset, self.header
        dataset.set_fill_off()
        for name, value in global_attributes(header).items():
            dataset.setncattr(name, value)
        values = coordinate_values(header)
        for name, size in {**header.sizes, BOUND: 2, VERTEX: len(values["footprint_latitude"])}.items():
            dataset.createDimension(name, size)
        plane = dataset.createVariable(GRID_MAPPING, "i4", fill_value=False)
        plane.setncatts(grid_mapping_attributes(header))
        plane.assignValue(0)
        for spec in COORDINATES:
            if spec.name in values:
                self._define_coordinate(spec, values[spec.name])
        if any(spec.significant_bits is not None for spec in header.variables):
            info = dataset.createVariable(INFO, "S1", fill_value=False)
            info.setncatts({"algorithm": "bitround", "implementation": f"hcss_twin version {__version__}"})
        for spec in header.variables:
            self._define_data(spec)
        for spec in header.geometry:
            self._define_data(spec)
        for rows, arrays in self._geometry.parts(self._geometry.of_image, header.frame_times_s[0]):
            for name, array in arrays.items():
                dataset.variables[name][rows] = array

    def _define_coordinate(self, spec: VariableSpec, values: NDArray[Any]) -> None:
        variable = self._dataset.createVariable(
            spec.name,
            str if spec.dtype == "str" else spec.dtype,
            spec.dims,
            fill_value=False if spec.units else None,
        )
        if not is_bounds(spec):
            variable.setncatts(_attributes(spec))
        if spec.name == "time":
            variable.units = time_units(self.header)
        if spec.dims:
            variable[:] = values
        else:
            variable.assignValue(values)

    def _define_data(self, spec: VariableSpec) -> None:
        if self.compression is None:
            # measured for 16 x 3 x 800 x 800: 0.06 s, against 0.10 s in chunks of one plane
            layout: dict[str, Any] = {"contiguous": True}
        else:
            layout = {
                "compression": "zlib",
                "complevel": self.compression,
                "shuffle": True,
                "chunksizes": self._chunk(spec),
            }
        variable = self._dataset.createVariable(
            spec.name,
            spec.dtype,
            spec.dims,
            fill_value=np.dtype(spec.dtype).type(np.nan) if spec.may_be_missing else False,
            **layout,
        )
        if self.compression is not None:
            # each frame fills whole chunks, so that a cache would only copy them
            variable.set_var_chunk_cache(size=0)
        variable.setncatts(_attributes(spec))
        if spec.kind != "geometry":  # which is a coordinate itself
            variable.coordinates = " ".join(auxiliary_names(self.header, spec.dims))
            variable.grid_mapping = GRID_MAPPING

    def _chunk(self, spec: VariableSpec) -> tuple[int, ...]:
        """Return chunks of one plane of one frame, split by rows where the plane is very large."""
        row_bytes = self.header.columns * np.dtype(spec.dtype).itemsize
        rows = min(self.header.rows, max(1, _LARGEST_CHUNK_BYTES // row_bytes))
        sizes = {"y": rows, "x": self.header.columns}
        return tuple(sizes.get(dim, 1) for dim in spec.dims)


def _attributes(spec: VariableSpec) -> dict[str, Any]:
    found: dict[str, Any] = {"long_name": spec.long_name, "comment": spec.description}
    if spec.standard_name is not None:
        found["standard_name"] = spec.standard_name
    if spec.units is not None:
        found["units"] = spec.units
    content = "coordinate" if spec.kind in ("coordinate", "geometry") else "modelResult"
    if spec.significant_bits is not None:
        found["quantization"] = INFO
        found["quantization_nsb"] = np.int32(spec.significant_bits)
        found["quantization_maximum_relative_error"] = np.float32(largest_error(spec.significant_bits))
    return {**found, "coverage_content_type": content, **spec.attributes}


def _flush(path: Path) -> None:
    """Ask the system to put a file, or a folder's entries, on the disk."""
    if path.is_dir():
        # some systems cannot open folders; the rename is then as durable as they make it
        with contextlib.suppress(OSError):
            _flush_handle(os.open(path, os.O_RDONLY))
        return
    _flush_handle(os.open(path, os.O_RDWR))


def _flush_handle(handle: int) -> None:
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
