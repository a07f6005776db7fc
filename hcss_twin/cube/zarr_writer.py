"""Writing of a cube as a Zarr store, and the choice of format by file name.

Stores have Zarr format 2 with consolidated metadata, which every reader supports; xarray reads dimension
names from ``_ARRAY_DIMENSIONS``. Needs the package ``zarr`` (``pip install hcss-twin[zarr]``).
"""

from __future__ import annotations

import contextlib
import json
import os
import re
import shutil
from collections.abc import Collection, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.errors import CubeError
from hcss_twin.core.files import REMEDY, Writing
from hcss_twin.cube.coordinates import GRID_MAPPING, coordinate_specs, coordinate_values, grid_mapping_attributes
from hcss_twin.cube.header import FORMAT_ATTRIBUTE, FORMAT_VERSION, Attribute
from hcss_twin.cube.metadata import global_attributes
from hcss_twin.cube.streamed_writer import StreamedWriter
from hcss_twin.cube.variables import VariableSpec
from hcss_twin.cube.writer import (
    INFO,
    QUANTIZATION_ATTRIBUTES,
    CubeWriter,
    coordinate_attributes,
    fill_value,
    links,
    variable_attributes,
)

ZARR_SUFFIX = ".zarr"


def is_zarr(path: str | os.PathLike[str]) -> bool:
    """Whether a path names a Zarr store."""
    return Path(path).suffix.lower() == ZARR_SUFFIX


def cube_writer(path: str | os.PathLike[str]) -> type[StreamedWriter]:
    """Return the writer class for a cube of this name.

    Raises
    ------
    CubeError
        If the package ``zarr`` is needed and not installed.
    """
    if not is_zarr(path):
        return CubeWriter
    # imported here because it needs an optional package
    from hcss_twin.cube.zarr_writer import ZarrWriter, require_zarr

    require_zarr(path)
    return ZarrWriter


def cube_bytes(path: Path) -> int:
    """Size of a cube on disk: of the file, or of all files of a store."""
    if path.is_file():
        return path.stat().st_size
    return sum(file.stat().st_size for file in path.rglob("*") if file.is_file())


DIMENSIONS = "_ARRAY_DIMENSIONS"
"""Attribute from which readers take the dimension names of a variable."""


class ZarrWriter(StreamedWriter):
    """Streams frames into a Zarr store; chunks are tiles, by default whole planes of frames.

    Parameters and errors as in :class:`StreamedWriter`; also an error if the package ``zarr`` is missing.
    """

    _group: Any = None
    _arrays: Mapping[str, Any] = MappingProxyType({})

    @property
    def _is_open(self) -> bool:
        return self._group is not None

    @property
    def _chunk(self) -> tuple[int, int]:
        return self.tile or (self.header.rows, self.header.columns)

    def _require_replaceable(self) -> None:
        require_zarr(self.path)
        if self.path.exists() and not self.path.is_dir():
            raise CubeError(f"cannot write {self.path}: it is a file, but a Zarr store is a folder")
        if self.path.is_dir() and not _is_store(self.path):  # an empty one, too: somebody has made it
            raise CubeError(f"cannot write {self.path}: it is a folder that is not a Zarr store with a cube")

    def _create(self) -> None:
        self._partial.mkdir()

    def _open(self) -> None:
        self._group = require_zarr(self.path).open_group(str(self._partial), mode="w", zarr_format=2)
        self._define()

    def _array(self, name: str) -> Any:
        return self._arrays[name]

    def _attribute_names(self) -> Collection[str]:
        return set(self._group.attrs)

    def _add_attributes(self, attributes: Mapping[str, Attribute]) -> None:
        self._group.attrs.update(_plain(attributes))

    def _define(self) -> None:
        header = self.header
        self._group.attrs.update(_plain(global_attributes(header)))
        values = coordinate_values(header)
        if header.layout is None:
            self._add_variable(GRID_MAPPING, np.array(0, dtype=np.int32), (), grid_mapping_attributes(header))
        for spec in coordinate_specs(header):
            if spec.name in values:
                attributes = coordinate_attributes(spec, header)
                self._add_variable(spec.name, values[spec.name], spec.dims, attributes)
        if any(spec.significant_bits is not None for spec in header.variables):
            self._add_variable(INFO, np.array(b"", dtype="S1"), (), QUANTIZATION_ATTRIBUTES)
        specs = (*header.variables, *header.geometry)
        self._arrays = {spec.name: self._data_array(spec) for spec in specs}
        for region, arrays in self._geometry.parts(self._geometry.of_image, self._chunk):
            for name, array in arrays.items():
                self._arrays[name][region] = array

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

        rows, columns = self._chunk
        sizes = {**self.header.sizes, "time": 1, "band": 1, "layer": 1, "y": rows, "x": columns}
        codec = None
        if self.compression is not None:
            codec = Blosc(cname="zlib", clevel=self.compression, shuffle=Blosc.SHUFFLE)
        return self._group.create_array(
            spec.name,
            shape=tuple(self.header.sizes[dim] for dim in spec.dims),
            chunks=tuple(sizes[dim] for dim in spec.dims),
            dtype=spec.stored_dtype,
            compressors=codec,
            # Readers would treat pixels with any other fill value as missing.
            fill_value=fill_value(spec, None),
            attributes={
                DIMENSIONS: list(self.header.in_file(spec.dims)),
                **_plain({**variable_attributes(spec), **links(spec, self.header)}),
            },
        )

    def _finish(self) -> None:
        import zarr

        self._group.attrs[FORMAT_ATTRIBUTE] = FORMAT_VERSION
        zarr.consolidate_metadata(str(self._partial), zarr_format=2)
        self._replace()
        Writing.flush(self.path.parent)

    def _replace(self) -> None:
        """Rename the store; an older one is moved aside first, and moved back if renaming fails.

        Files and empty folders in the older one that its metadata does not list are the user's: they are moved to the
        new one.
        """
        old = self._partial.with_suffix(".old")
        if self.path.exists() and not self.replace:
            raise CubeError(f"cannot write {self.path}: another process has written it; {REMEDY}")
        if self.path.exists():
            os.replace(self.path, old)
        try:
            os.replace(self._partial, self.path)
        except BaseException:
            if old.exists():
                os.replace(old, self.path)
            raise
        if old.is_symlink():
            old.unlink()
        elif old.exists():
            for path in _unlisted(old):
                target = self.path / path.relative_to(old)
                target.parent.mkdir(parents=True, exist_ok=True)
                if not (path.is_dir() and target.is_dir()):  # an array of the new store has the name of an empty folder
                    os.replace(path, target)
            shutil.rmtree(old, ignore_errors=True)

    def _discard(self) -> None:
        self._group, self._arrays = None, MappingProxyType({})
        shutil.rmtree(self._partial, ignore_errors=True)


def _is_store(path: Path) -> bool:
    """Whether a folder is a finished cube of this package."""
    with contextlib.suppress(OSError, ValueError, KeyError, TypeError):
        return FORMAT_ATTRIBUTE in json.loads((path / ".zattrs").read_bytes()) and bool(_arrays_of(path))
    return False


def _arrays_of(store: Path) -> set[str]:
    """Return the names of the arrays that the metadata of a store list."""
    metadata = json.loads((store / ".zmetadata").read_bytes())["metadata"]
    return {name.removesuffix("/.zarray") for name in metadata if name.endswith("/.zarray")}


_CHUNK = re.compile(r"\d+([./]\d+)*")


def _unlisted(store: Path) -> list[Path]:
    """Return the files and empty folders in a store that belong to none of the arrays that its metadata list."""
    arrays, found = _arrays_of(store), []
    for path in store.rglob("*"):
        if path.is_dir() and not path.is_symlink() and any(path.iterdir()):
            continue
        name, _, rest = path.relative_to(store).as_posix().partition("/")
        is_of_zarr = rest in (".zarray", ".zattrs") or _CHUNK.fullmatch(rest) if rest else name in _GROUP
        if not is_of_zarr or (rest and name not in arrays):
            found.append(path)
    return found


_GROUP = (".zgroup", ".zattrs", ".zmetadata")


def require_zarr(path: str | os.PathLike[str]) -> Any:
    """Return the package ``zarr``.

    Raises
    ------
    CubeError
        If it is not installed; the message says how to install it.
    """
    try:
        import zarr
    except ImportError as error:
        raise CubeError(
            f"{os.fspath(path)}: Zarr stores need the package 'zarr', version 3 or later, which is not installed; "
            "pip install 'hcss-twin[zarr]', or choose a name that ends in .nc"
        ) from error
    return zarr


def _plain(attributes: Mapping[str, Any]) -> dict[str, Any]:
    """Convert attribute values to JSON types."""
    return {
        name: value.tolist() if isinstance(value, np.ndarray | np.generic) else value
        for name, value in attributes.items()
    }
