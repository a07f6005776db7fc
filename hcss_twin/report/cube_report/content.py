"""What a cube holds that can be looked at as images, in the order in which it is shown.

Reading of a cube for its page: some frames, and of large ones some pixels; never a large frame as a whole.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.cube.variables import TERM_PREFIX

if TYPE_CHECKING:
    import xarray as xr


PLANE = ("time", "y", "x")

_FIRST = ("radiance", "brightness_temperature")
_UNITS = {"W m-2 sr-1": "W m⁻² sr⁻¹", "s-1": "s⁻¹", "1": ""}


@dataclass(frozen=True)
class Quantity:
    """A variable with frames.

    Attributes
    ----------
    name : str
        Of the variable.
    label, units : str
        As they are shown; units are empty for plain numbers.
    dim : str or None
        The dimension beside time, y and x: ``band``, ``layer``.
    parts : tuple of str
        Names along it; one empty name where there is none.
    flags : tuple of str
        Meanings of 0, 1, ... where the numbers are flags.
    """

    name: str
    label: str
    units: str
    dim: str | None
    parts: tuple[str, ...]
    flags: tuple[str, ...] = ()

    @property
    def is_radiation(self) -> bool:
        """Whether it is what a sensor sees: radiance, a term of it or brightness temperature."""
        return self.name in _FIRST or self.name.startswith(TERM_PREFIX)


def pretty_units(units: str) -> str:
    """Return units as they are printed; plain numbers have none."""
    return _UNITS.get(units, units)


def quantities(dataset: xr.Dataset) -> list[Quantity]:
    """Return all variables with frames: radiance and brightness temperature, terms, then what else there is."""
    found = []
    for key, data in dataset.data_vars.items():
        others = [str(dim) for dim in data.dims if dim not in PLANE]
        if not set(PLANE) <= set(data.dims) or len(others) > 1:
            continue
        name, dim = str(key), others[0] if others else None
        parts = tuple(str(each) for each in dataset[dim].to_numpy()) if dim is not None else ("",)
        flags = tuple(word.replace("_", " ") for word in str(data.attrs.get("flag_meanings", "")).split())
        label = (f"{name.removeprefix(TERM_PREFIX)} (term)" if name.startswith(TERM_PREFIX) else name).replace("_", " ")
        units = pretty_units(str(data.attrs.get("units", "")))
        found.append(Quantity(name, label, units, dim, parts, flags))
    order = {name: place for place, name in enumerate(_FIRST)}
    return sorted(found, key=lambda each: order.get(each.name, 2 if each.is_radiation else 3))


READ_PIXELS = 1_000_000
"""Of a plane; of larger ones every n-th row and column is read."""

READ_BYTES = 6_000_000_000
"""Of the whole cube, as far as the disk has to move; fewer frames, at least one, are shown where all would be more."""

WINDOW_PIXELS = 1024
"""Side of the part in the middle of a frame whose spectrum is taken."""


@dataclass(frozen=True)
class Reader:
    """Planes of a cube.

    Attributes
    ----------
    dataset : Dataset
        An open cube.
    step : int
        Every so many rows and columns are read; 1 for all but large frames.
    """

    dataset: xr.Dataset
    step: int

    @classmethod
    def of(cls, dataset: xr.Dataset) -> Reader:
        """Return the reader of a cube."""
        pixels = dataset.sizes["y"] * dataset.sizes["x"]
        return cls(dataset, max(1, math.ceil(math.sqrt(pixels / READ_PIXELS))))

    def plane(self, quantity: Quantity, part: int, frame: int) -> NDArray[Any]:
        """Return one plane (y, x), every ``step``-th row and column of it."""
        every = slice(None, None, self.step)
        return self._read(quantity, part, frame, every, every)

    def window(self, quantity: Quantity, part: int, frame: int) -> NDArray[Any]:
        """Return the middle of one plane with all its pixels, at most ``WINDOW_PIXELS`` squared."""
        rows, columns = (_middle(self.dataset.sizes[dim]) for dim in ("y", "x"))
        return self._read(quantity, part, frame, rows, columns)

    def _read(self, quantity: Quantity, part: int, frame: int, rows: slice, columns: slice) -> NDArray[Any]:
        data = self.dataset[quantity.name]
        which: dict[str, Any] = {"time": frame, "y": rows, "x": columns}
        if quantity.dim is not None:
            which[quantity.dim] = part
        found: NDArray[Any] = data.isel(which).transpose("y", "x").to_numpy()
        return found

    def bytes_moved(self, quantity: Quantity) -> int:
        """Bytes that the disk moves for one frame of all parts: of tiles the whole, else the rows that are read."""
        data = self.dataset[quantity.name]
        whole = data.dtype.itemsize * data.size // max(1, data.sizes["time"])
        tiled = bool(data.encoding.get("chunks") or data.encoding.get("chunksizes"))
        return whole if tiled or self.step == 1 else whole // self.step


def _middle(size: int) -> slice:
    first = max(0, (size - WINDOW_PIXELS) // 2)
    return slice(first, min(size, first + WINDOW_PIXELS))


def spread(count: int, wanted: int) -> list[int]:
    """Return at most ``wanted`` of the numbers 0 to ``count - 1``, evenly spread, the ends among them."""
    chosen = np.unique(np.linspace(0, count - 1, min(count, max(1, wanted))).round().astype(int))
    return [int(each) for each in chosen]
