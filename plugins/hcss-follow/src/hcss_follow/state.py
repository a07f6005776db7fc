"""The state of a followed sky: what one or more images say of it, as data, and the file that holds it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.files import Writing
from hcss_twin.core.reading import Reading
from hcss_twin.providers import CatalogError, NetcdfFile

Field = NDArray[np.float32]

FORMAT = 1

MIN_SIDE, MAX_SIDE = 64, 4096
"""Smallest and largest side of an image, pixels."""


@dataclass(frozen=True, eq=False)
class State:
    """A sky at the time of its latest image; rows northward, columns eastward.

    Attributes
    ----------
    kelvin : ndarray of float32 (rows, columns)
        Brightness temperature near 10.8 um, K.
    tendency_K : ndarray of float32 (rows, columns)
        The latest image less the one before, moved along: what changed in ``interval_s``; 0 after one image.
    flow_m_s : ndarray of float32 (2, rows, columns)
        Velocity of what is seen, northward and eastward.
    excess_m : ndarray of float32 (rows, columns)
        Height of cloud tops above that of an opaque cloud with the same brightness temperature; 0 with one channel.
    clear_K : ndarray of float32 (rows, columns)
        Brightness temperature of the clear sky, a smooth map; its differences are those of sea and vapour.
    time : datetime
        Of the latest image, UTC.
    interval_s : float
        Between the last two images; NaN after one image.
    agreement : float
        Correlation of the latest image with the one before, moved along, without what is smooth; NaN after one image.
    pixel_size_m : float
    latitude, longitude : float
        Of the middle, degrees.
    number : int
        Of images so far.
    two_channels : bool
        Whether ``excess_m`` was measured.
    source, rights : str
        Where the images come from, and their terms of use.
    """

    kelvin: Field
    tendency_K: Field
    flow_m_s: Field
    excess_m: Field
    clear_K: Field
    time: datetime
    interval_s: float
    agreement: float
    pixel_size_m: float
    latitude: float
    longitude: float
    number: int
    two_channels: bool
    source: str = ""
    rights: str = ""

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        rows, columns = self.kelvin.shape
        return rows, columns

    def write(self, path: Path) -> None:
        """Write the state as a NetCDF file, which :func:`read_state` reads to the bit."""
        with Writing(path, CatalogError, "NetCDF") as draft, NetcdfFile(draft, "w") as file:
            file.title = "State of a followed sky"
            file.hcss_follow_format = FORMAT
            file.createDimension("component", 2)
            for name, size in zip(("y", "x"), self.shape, strict=True):
                file.createDimension(name, size)
            for entry in fields(self):
                value = getattr(self, entry.name)
                if isinstance(value, np.ndarray):
                    axes = ("y", "x") if value.ndim == 2 else ("component", "y", "x")
                    variable = file.createVariable(entry.name, "f4", axes, zlib=True, complevel=4, fill_value=False)
                    variable[:] = value
                    variable.units = {"flow_m_s": "m s-1", "excess_m": "m"}.get(entry.name, "K")
                else:
                    of_file = value.isoformat() if isinstance(value, datetime) else value
                    file.setncattr(entry.name, int(of_file) if isinstance(of_file, bool) else of_file)


def read_state(path: Path) -> State:
    """Read a state.

    Raises
    ------
    CatalogError
        If the file is damaged, is no state, or has values out of range.
    """
    with Reading(path, CatalogError, "not the state of a followed sky, or damaged").netcdf() as file:
        if getattr(file, "hcss_follow_format", None) != FORMAT:
            raise CatalogError(f"{path}: no state of a followed sky; `hcss follow` makes one from images")
        file.set_auto_mask(False)
        values: dict[str, Any] = {}
        for entry in fields(State):
            if str(entry.type) == "Field":
                values[entry.name] = np.asarray(file[entry.name][:], np.float32)
            else:
                convert: dict[str, Callable[[Any], Any]] = {
                    "int": int, "float": float, "bool": bool, "datetime": datetime.fromisoformat
                }  # fmt: skip
                values[entry.name] = convert.get(str(entry.type), str)(getattr(file, entry.name))
    state = State(**values)
    _check(path, state)
    return state


def _check(path: Path, state: State) -> None:
    """Raise CatalogError unless the parts of a state fit together and are in range."""
    wrong = ""
    arrays = {entry.name: getattr(state, entry.name) for entry in fields(state) if str(entry.type) == "Field"}
    if not all(MIN_SIDE <= side <= MAX_SIDE for side in state.kelvin.shape):
        wrong = f"{' x '.join(map(str, state.kelvin.shape))} pixels; allowed: sides of {MIN_SIDE} to {MAX_SIDE}"
    for name, array in arrays.items():
        expected = (2, *state.shape) if name == "flow_m_s" else state.shape
        if array.shape != expected:
            wrong = f"{name} {array.shape}; allowed: {expected}"
        elif not np.all(np.isfinite(array)):
            wrong = f"{name} has values that are not finite"
    if not 1.0 <= state.pixel_size_m <= 1e5:
        wrong = f"pixel_size_m {state.pixel_size_m:g}; allowed: 1 to 100000"
    elif state.time.tzinfo is None or state.time.utcoffset() != UTC.utcoffset(None):
        wrong = f"time {state.time.isoformat()}; allowed: UTC"
    if wrong:
        raise CatalogError(f"{path}: {wrong}")
