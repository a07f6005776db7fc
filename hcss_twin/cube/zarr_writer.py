"""Writing of a cube as a Zarr store: the same variables and attributes as the NetCDF file has.

Format 2 of Zarr, with consolidated metadata: what every reader knows, xarray by the dimension names that it looks for
in ``_ARRAY_DIMENSIONS``. Needs the package ``zarr`` (``pip install hcss-twin[zarr]``).
"""

from __future__ import annotations

import contextlib
import os
import secrets
import shutil
from collections.abc import Iterator, Mapping
from pathlib import Path
from threading import RLock
from types import TracebackType
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from hcss_twin.cube.bit_rounding import INFO
from hcss_twin.cube.coordinates import COORDINATES, GRID_MAPPING, coordinate_values, grid_mapping_attributes
from hcss_twin.cube.durable import flush
from hcss_twin.cube.frames import WrittenFrames, check_frame, plain_bytes
from hcss_twin.cube.geometry import PixelGeometry
from hcss_twin.cube.header import FORMAT_ATTRIBUTE, FORMAT_VERSION, Attribute, CubeHeader, check_attributes
from hcss_twin.cube.layout import QUANTIZATION_ATTRIBUTES, coordinate_attributes, links, variable_attributes
from hcss_twin.cube.metadata import global_attributes
from hcss_twin.cube.variables import VariableSpec
from hcss_twin.errors import CubeError

DIMENSIONS = "_ARRAY_DIMENSIONS"
"""Attribute of a variable in which readers look for the names of its dimensions."""


class ZarrWriter:
    """Context manager that streams frames, or tiles of them, into a Zarr store.

    The store grows under a hidden name ending in ``.partial`` in the same folder. Leaving the block with all frames
    written renames it to ``path``, in place of an older store; leaving it through any exception removes it.

    Parameters
    ----------
    path : path-like
        Final name of the store, a folder; the folder around it must exist.
    header : CubeHeader
        Everything but the frames.
    compression : int, optional
        zlib level 1 to 9; None stores plain numbers.
    tile : (int, int), optional
        Rows and columns of chunks; by default those of the frame.

    Raises
    ------
    CubeError
        As :class:`hcss_twin.cube.writer.CubeWriter`, or without the package ``zarr``.
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        header: CubeHeader,
        *,
        compression: int | None = None,
        tile: tuple[int, int] | None = None,
    ) -> None:
        if compression is not None and not 1 <= compression <= 9:
            raise CubeError(f"compression: {compression}; a zlib level from 1 to 9, or none, is allowed")
        self.path = Path(path)
        self.header = header
        self.compression = compression
        self.tile = tile or (header.rows, header.columns)
        self._partial = self.path.with_name(f".{self.path.name}.{secrets.token_hex(4)}.partial")
        self._geometry = PixelGeometry(header)
        self._group: Any = None
        self._arrays: dict[str, Any] = {}
        self._written = WrittenFrames(header)
        self._turn = RLock()

    def __enter__(self) -> Self:
        zarr = require_zarr(self.path)
        self._claim()
        try:
            with self._explained():
                self._group = zarr.open_group(str(self._partial), mode="w", zarr_format=2)
                self._define()
        except BaseException:
            self._discard()
            raise
        return self

    def write_frame(self, index: int, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Write one frame, as :meth:`CubeWriter.write_frame` does."""
        self.write_tile(index, None, arrays)

    def write_tile(
        self, index: int, place: tuple[slice, slice] | None, arrays: Mapping[str, NDArray[Any]]
    ) -> None:
        """Write a part of one frame, as :meth:`CubeWriter.write_tile` does."""
        with self._turn:
            if self._group is None:
                raise CubeError(
                    f"{self.path}: not open for writing; frames are written inside a 'with' block"
                )
            window = self._written.room_for(index, place)
            check_frame(self.header, index, arrays, place)
            with self._explained():
                for name, array in arrays.items():
                    self._arrays[name][(index, ..., *window)] = array
                names, time_s = self._geometry.of_frames, self.header.frame_times_s[index]
                for name, array in self._geometry.values(names, window, time_s).items():
                    self._arrays[name][(index, *window)] = array
            self._written.add(index, window)

    def set_attributes(self, attributes: Mapping[str, Attribute]) -> None:
        """Add global attributes that are known only once frames are written, as :meth:`CubeWriter.set_attributes`."""
        if self._group is None:
            raise CubeError(f"{self.path}: not open for writing; attributes are set inside a 'with' block")
        check_attributes(attributes)
        for name in attributes:
            if name == FORMAT_ATTRIBUTE or name in self._group.attrs:
                raise CubeError(f"attribute {name}: the cube has it already; it cannot be given again")
        with self._explained():
            self._group.attrs.update(_plain(attributes))

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
        if not self.path.parent.is_dir():
            raise CubeError(f"cannot write {self.path}: there is no folder {self.path.parent}")
        if self.path.is_file():
            raise CubeError(f"cannot write {self.path}: it is a file, and a Zarr store is a folder")
        if self.path.is_dir() and any(self.path.iterdir()) and not (self.path / ".zgroup").is_file():
            raise CubeError(f"cannot write {self.path}: it is a folder of other things than a Zarr store")
        try:
            free = shutil.disk_usage(self.path.parent).free
            self._partial.mkdir()
        except OSError as error:
            raise CubeError(f"cannot write {self.path}: {error.strerror}") from error
        needed = plain_bytes(self.header)
        if self.compression is None and needed > free:
            self._discard()
            raise CubeError(
                f"cannot write {self.path}: it needs {needed / 1e6:.1f} MB, "
                f"the disk has {free / 1e6:.1f} MB free"
            )

    def _define(self) -> None:
        header = self.header
        self._group.attrs.update(_plain(global_attributes(header)))
        values = coordinate_values(header)
        self._add_variable(GRID_MAPPING, np.array(0, dtype=np.int32), (), grid_mapping_attributes(header))
        for spec in COORDINATES:
            if spec.name in values:
                attributes = coordinate_attributes(spec, header)
                self._add_variable(spec.name, values[spec.name], spec.dims, attributes)
        if any(spec.significant_bits is not None for spec in header.variables):
            self._add_variable(INFO, np.array(b"", dtype="S1"), (), QUANTIZATION_ATTRIBUTES)
        for spec in (*header.variables, *header.geometry):
            self._arrays[spec.name] = self._data_array(spec)
        for place, arrays in self._geometry.parts(self._geometry.of_image, self.tile):
            for name, array in arrays.items():
                self._arrays[name][place] = array

    def _add_variable(
        self, name: str, values: NDArray[Any], dims: tuple[str, ...], attributes: Mapping[str, Any]
    ) -> None:
        array = self._group.create_array(
            name,
            shape=values.shape,
            chunks=tuple(max(1, size) for size in values.shape),
            dtype=str if values.dtype == object else values.dtype,
            compressors=None,
            fill_value="" if values.dtype == object else None,
            attributes={DIMENSIONS: list(dims), **_plain(attributes)},
        )
        array[...] = values

    def _data_array(self, spec: VariableSpec) -> Any:
        from numcodecs import Blosc

        sizes = {**self.header.sizes, "time": 1, "band": 1, "layer": 1, "y": self.tile[0], "x": self.tile[1]}
        codec = None
        if self.compression is not None:
            codec = Blosc(cname="zlib", clevel=self.compression, shuffle=Blosc.SHUFFLE)
        return self._group.create_array(
            spec.name,
            shape=tuple(self.header.sizes[dim] for dim in spec.dims),
            chunks=tuple(sizes[dim] for dim in spec.dims),
            dtype=spec.dtype,
            compressors=codec,
            # Any other number would be taken for missing values by readers.
            fill_value=np.nan if spec.may_be_missing else None,
            attributes={
                DIMENSIONS: list(spec.dims),
                **_plain({**variable_attributes(spec), **links(spec, self.header)}),
            },
        )

    def _finish(self) -> None:
        import zarr

        self._written.require_all(self.path)
        with self._explained():
            self._group.attrs[FORMAT_ATTRIBUTE] = FORMAT_VERSION
            zarr.consolidate_metadata(str(self._partial), zarr_format=2)
            self._replace()
            flush(self.path.parent)

    def _replace(self) -> None:
        """Give the store its name; an older one is moved aside first, and back if that fails."""
        old = self._partial.with_suffix(".old")
        if self.path.exists():
            os.replace(self.path, old)
        try:
            os.replace(self._partial, self.path)
        except BaseException:
            if old.exists():
                os.replace(old, self.path)
            raise
        shutil.rmtree(old, ignore_errors=True)

    def _discard(self) -> None:
        self._group, self._arrays = None, {}
        shutil.rmtree(self._partial, ignore_errors=True)

    @contextlib.contextmanager
    def _explained(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            free = shutil.disk_usage(self.path.parent).free
            raise CubeError(
                f"cannot write {self.path}: {error.strerror or error} (free on this disk: {free / 1e6:.1f} MB; the "
                f"cube needs up to {plain_bytes(self.header) / 1e6:.1f} MB)"
            ) from error


def require_zarr(path: str | os.PathLike[str]) -> Any:
    """Return the package ``zarr``.

    Raises
    ------
    CubeError
        If it is not installed, with what to install.
    """
    try:
        import zarr
    except ImportError as error:
        raise CubeError(
            f"{os.fspath(path)}: Zarr stores need the package 'zarr' from version 3 on, which is not installed; "
            "pip install 'hcss-twin[zarr]', or choose a name that ends in .nc"
        ) from error
    return zarr


def _plain(attributes: Mapping[str, Any]) -> dict[str, Any]:
    """Turn values of attributes into what JSON holds."""
    return {
        name: value.tolist() if isinstance(value, np.ndarray | np.generic) else value
        for name, value in attributes.items()
    }
