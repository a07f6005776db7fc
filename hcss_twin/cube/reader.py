"""Opening of finished cubes, NetCDF or Zarr."""

from __future__ import annotations

import os
from collections.abc import Hashable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arguments import checked
from hcss_twin.core.errors import CubeError
from hcss_twin.core.netcdf import NETCDF, NetcdfFile
from hcss_twin.core.reading import Reading
from hcss_twin.cube.coordinates import BOUND, COORDINATES, GRID_MAPPING, OF_ANY_IMAGE
from hcss_twin.cube.header import FORMAT_ATTRIBUTE, FORMAT_VERSION, SCENARIO_ATTRIBUTE
from hcss_twin.cube.variables import GEOMETRY, LAYER, VARIABLES
from hcss_twin.cube.writer import INFO
from hcss_twin.cube.zarr_writer import DIMENSIONS, is_zarr, require_zarr

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True)
class _Dimension:
    size: int


class _Variable:
    """A variable of a Zarr store with the interface of a ``netCDF4.Variable``."""

    def __init__(self, array: Any) -> None:
        self._array = array
        self.dtype: np.dtype[Any] = array.dtype
        self.dimensions: tuple[str, ...] = tuple(array.attrs[DIMENSIONS])
        self.shape: tuple[int, ...] = array.shape

    def __getitem__(self, index: Any) -> NDArray[Any]:
        values: NDArray[Any] = np.asarray(self._array[index])
        if "scale_factor" in self._array.attrs:
            scale, offset = (np.float32(self._array.attrs[name]) for name in ("scale_factor", "add_offset"))
            values = values * scale + offset
        return values


class ZarrCube:
    """A Zarr store with the interface of a ``netCDF4.Dataset``.

    Attributes
    ----------
    variables : mapping
        By name; each has ``dtype``, ``dimensions`` and values by index.
    dimensions : mapping
        By name; each has a ``size``.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        group = require_zarr(path).open_group(os.fspath(path), mode="r")
        self.variables = {name: _Variable(array) for name, array in group.arrays()}
        self.dimensions = {
            name: _Dimension(size)
            for variable in self.variables.values()
            for name, size in zip(variable.dimensions, variable.shape, strict=True)
        }

    def __getitem__(self, name: str) -> _Variable:
        return self.variables[name]


@contextmanager
def stored_arrays(path: str | os.PathLike[str]) -> Iterator[Any]:
    """Open a cube as a ``NetcdfFile``, or a Zarr store as an object with the same interface."""
    with Reading(path, CubeError):
        if is_zarr(path):
            yield ZarrCube(path)
            return
        with NetcdfFile(path) as file:
            file.set_auto_mask(False)
            yield file


_MOST_COMPRESSED = 1100
"""Highest compression factor of zlib, rounded up (1032)."""


@checked
@Reading.argument(CubeError)
def open_cube(path: str | os.PathLike[str]) -> xr.Dataset:
    """Open a finished cube; values are read from the file on access.

    Bands and cloud layers can be selected by name: ``open_cube(path).radiance.sel(band="mwir")``. Close the dataset
    after use, or use it in a ``with`` block.

    Raises
    ------
    CubeError
        If the file is missing, is neither NetCDF nor a Zarr store, is not a cube, or was not finished.
    """
    is_store = is_zarr(path) and os.path.isdir(path)
    if is_store:
        require_zarr(path)
    elif not os.path.isfile(path):
        folder = os.path.isdir(path)
        why = "it is a folder; a cube is a file, or a folder NAME.zarr" if folder else "there is no such file"
        raise CubeError(f"cannot read {os.fspath(path)}: {why}")
    try:
        # with its cache, xarray would reuse the open file after a new one has replaced it
        opened = partial(_open_store, path) if is_store else partial(NetcdfFile.open_with_xarray, path)
        dataset = opened(decode_coords="all", cache=False)
    except Exception as error:  # libraries trust what a damaged file declares
        raise CubeError(f"cannot read {os.fspath(path)}: {_why_not(path, error)}") from error
    version = dataset.attrs.get(FORMAT_ATTRIBUTE)
    if version != FORMAT_VERSION:
        dataset.close()
        problem = "it is not a finished cube" if version is None else f"it has the cube format {version}"
        raise CubeError(
            f"cannot read {os.fspath(path)}: {problem}; "
            f"the global attribute {FORMAT_ATTRIBUTE} = {FORMAT_VERSION} is needed"
        )
    if not is_store and dataset.nbytes > _MOST_COMPRESSED * os.path.getsize(path):
        dataset.close()
        raise CubeError(
            f"cannot read {os.fspath(path)}: it declares {dataset.nbytes / 1e6:.0f} MB of values, which cannot be in a "
            f"file of {os.path.getsize(path) / 1e6:.1f} MB"
        )
    try:
        _require_layout(dataset)
    except CubeError as error:
        dataset.close()
        raise CubeError(f"cannot read {os.fspath(path)}: {error}") from None
    described = [*(spec.name for spec in (*COORDINATES, *GEOMETRY)), GRID_MAPPING, INFO]
    named = dataset.set_coords([name for name in described if name in dataset])
    names = {dim: f"{dim}_name" for dim in ("band", LAYER) if f"{dim}_name" in dataset}
    named = named.assign_coords({dim: (dim, dataset[name].to_numpy().astype(str)) for dim, name in names.items()})
    # closing a derived dataset does not close its file
    named.set_close(dataset.close)
    return named


_MAY_BE_SELECTED = ("time", "band", "y", "x")
"""Dimensions that a part of a cube may lack."""


def _require_layout(dataset: xr.Dataset) -> None:
    """Raise CubeError if a variable of a cube has another type or other dimensions than cubes have."""
    for name, size in dataset.sizes.items():
        if size == 0 or (name == BOUND and size != 2):
            raise CubeError(f"dimension {name} has the size {size}; allowed: {2 if name == BOUND else '1 or more'}")
    of_grid = GRID_MAPPING in dataset.variables
    for spec in (*COORDINATES, *VARIABLES):
        found = dataset.variables.get(spec.name)
        if found is None:
            continue
        if found.dtype.kind not in ("OUS" if spec.dtype == "str" else "fiuM" if spec.name == "time" else "fiub"):
            raise CubeError(f"{spec.name} has the type {found.dtype}; allowed: {spec.dtype}")
        needed = tuple(name for name in spec.dims if name in dataset.sizes or name not in _MAY_BE_SELECTED)
        if spec.kind == "coordinate" and (of_grid or spec.name in OF_ANY_IMAGE) and found.dims != needed:
            raise CubeError(f"{spec.name} has the dimensions {_listed(found.dims)}; allowed: {_listed(needed)}")


def _listed(names: Iterable[Hashable]) -> str:
    return f"({', '.join(map(str, names))})"


def _open_store(path: str | os.PathLike[str], **options: Any) -> xr.Dataset:
    # imported here so that commands that read no cube start quickly
    import xarray as xr

    return xr.open_dataset(path, engine="zarr", chunks=None, **options)


def _why_not(path: str | os.PathLike[str], error: Exception) -> str:
    """Explain why a file could not be opened: most are not NetCDF at all."""
    start = Reading(path, CubeError).first_bytes()
    if start.startswith(NETCDF):
        return f"it is NetCDF, but damaged, truncated or unsupported ({error})"
    if not start:
        return "it is empty; a cube is needed, as `hcss run` writes it"
    if os.path.splitext(path)[1].lower() in (".toml", ".json"):
        return f"it is not a NetCDF file; if it is a scenario, `hcss run {os.fspath(path)}` makes a cube from it"
    return "it is not a NetCDF file; a cube is needed, as `hcss run` writes it"


@Reading.argument(CubeError)
def scenario_text(path: str | os.PathLike[str]) -> str:
    """Return the scenario of a cube as text.

    Raises
    ------
    CubeError
        If the file is not a finished cube or has no scenario.
    """
    with open_cube(path) as dataset:
        text = dataset.attrs.get(SCENARIO_ATTRIBUTE)
    if not isinstance(text, str):
        raise CubeError(f"{os.fspath(path)} contains no scenario (global attribute {SCENARIO_ATTRIBUTE})")
    return text
