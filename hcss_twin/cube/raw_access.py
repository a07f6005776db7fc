"""Arrays of a cube as they are stored, of either format, by the names that netCDF4 has for them."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import netCDF4
import numpy as np
from numpy.typing import NDArray

from hcss_twin.cube.formats import is_zarr
from hcss_twin.cube.zarr_writer import DIMENSIONS, require_zarr


@dataclass(frozen=True)
class _Dimension:
    size: int


class _Variable:
    """A variable of a Zarr store with the attributes of one of netCDF4."""

    def __init__(self, array: Any) -> None:
        self._array = array
        self.dtype: np.dtype[Any] = array.dtype
        self.dimensions: tuple[str, ...] = tuple(array.attrs[DIMENSIONS])
        self.shape: tuple[int, ...] = array.shape

    def __getitem__(self, index: Any) -> NDArray[Any]:
        values: NDArray[Any] = np.asarray(self._array[index])
        return values


class ZarrCube:
    """A Zarr store with the attributes of a ``netCDF4.Dataset``.

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
    """Open a cube as a ``netCDF4.Dataset`` or, of a store, what looks like one."""
    if is_zarr(path):
        yield ZarrCube(path)
        return
    with netCDF4.Dataset(path) as file:
        file.set_auto_mask(False)
        yield file
