"""What pictures of a cube show: each variable with frames, and brightness temperature also where it is not stored."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.errors import CubeError, HcssError, choose_from
from hcss_twin.cube.variables import TERM_PREFIX, VARIABLES
from hcss_twin.engine.cube_temperature import ToKelvin, kelvin_by_band
from hcss_twin.reports.colour_scale import band_limits_um, colours_of, sight_rank

if TYPE_CHECKING:
    import xarray as xr

KELVIN = "brightness_temperature"

DRAWN = (KELVIN, "radiance", "cloud_thickness", "cloud_mask")
"""Default variable: the first of these in the cube; brightness temperature is computed from radiance."""

PLANE = ("time", "y", "x")

RANKED_PIXELS = 400
"""Longest side of the frame by which bands are ordered; larger frames are thinned."""


@dataclass(frozen=True)
class ShownVariable:
    """A variable with frames, or brightness temperature computed from the radiance when a plane is read.

    Attributes
    ----------
    name : str
    data : DataArray
        The stored variable: radiance for a computed brightness temperature.
    limits_um : list of (float, float)
        Limits of the bands; empty without bands.
    to_kelvin : tuple of callable
        By band; empty if the values are those stored.
    """

    name: str
    data: xr.DataArray
    limits_um: list[tuple[float, float]]
    to_kelvin: tuple[ToKelvin, ...] = ()

    @property
    def dim(self) -> str | None:
        """The dimension besides time, y and x: band or layer."""
        return next((str(dim) for dim in self.data.dims if dim not in PLANE), None)

    @property
    def parts(self) -> tuple[str, ...]:
        """Names along this dimension; one empty name without it."""
        return ("",) if self.dim is None else tuple(str(part) for part in self.data[self.dim].to_numpy())

    @property
    def units(self) -> str:
        """Unit of the values, as in the cube."""
        return "K" if self.name == KELVIN else str(self.data.attrs.get("units", ""))

    @property
    def flags(self) -> tuple[str, ...]:
        """Meanings of 0, 1, ... of a variable of flags."""
        return tuple(word.replace("_", " ") for word in str(self.data.attrs.get("flag_meanings", "")).split())

    def colours(self, part: int) -> str:
        """Return the colour map of a part."""
        return colours_of(self.name, self.limits_um[part][0] if self.limits_um else 0.0)

    def read(self, part: int, **where: Any) -> NDArray[Any]:
        """Return values at indices of time, y and x, the last two axes y and x."""
        chosen = where if self.dim is None else {**where, self.dim: part}
        data = self.data.isel(chosen)
        values: NDArray[Any] = data.transpose(..., *(dim for dim in PLANE if dim in data.dims)).to_numpy()
        return self.to_kelvin[part](values) if self.to_kelvin else values

    def order(self) -> list[int]:
        """Return the numbers of the parts, of brightness temperature those of the bands with most to see first."""
        numbers = list(range(len(self.parts)))
        if self.name != KELVIN or not self.limits_um or not self.data.size:
            return numbers
        every = slice(None, None, max(1, -(-max(self.data.sizes["y"], self.data.sizes["x"]) // RANKED_PIXELS)))
        ranks = {
            part: sight_rank(self.limits_um[part][0], self.read(part, time=0, y=every, x=every)) for part in numbers
        }
        return sorted(numbers, key=ranks.__getitem__)


def with_kelvin(dataset: xr.Dataset, required: bool = False) -> dict[str, ShownVariable]:
    """Return the variables with frames of a cube by name, brightness temperature among them if there is radiance.

    Parameters
    ----------
    dataset : Dataset
        A cube with axes y and x.
    required : bool
        Raise what keeps the brightness temperature from being computed, such as a missing response file.
    """
    shown = {
        str(name): ShownVariable(str(name), data, band_limits_um(dataset, data))
        for name, data in dataset.data_vars.items()
        if set(PLANE) <= set(data.dims) and len(data.dims) <= len(PLANE) + 1
    }
    if KELVIN not in shown and "radiance" in shown:
        radiance = shown["radiance"]
        try:
            shown[KELVIN] = ShownVariable(KELVIN, radiance.data, radiance.limits_um, kelvin_by_band(dataset))
        except HcssError:  # of a cube without its scenario, or without the files of its bands
            if required:
                raise
    return shown


def require_variable(images: Mapping[str, object], requested: str | None) -> str:
    """Return the variable to draw: that requested, or the first of ``DRAWN``; raises CubeError."""
    known = list(images)
    if requested in known:
        return str(requested)
    if requested is not None:
        exists = requested.startswith(TERM_PREFIX) or requested in {spec.name for spec in VARIABLES}
        run = f"; run the scenario with --set 'output.variables=[\"{requested}\"]'" if exists else ""
        raise CubeError(f"the cube holds no '{requested}'; {choose_from(requested, known)}{run}")
    for name in DRAWN:
        if name in known:
            return name
    raise CubeError(f"the cube holds none of {', '.join(DRAWN)}; name a variable; {choose_from('', known)}")


@dataclass(frozen=True)
class ShownImage:
    """One band or layer of a variable, to draw.

    Attributes
    ----------
    variable : ShownVariable
    number : int
        Of the part.
    """

    variable: ShownVariable
    number: int

    @staticmethod
    def ordered(variable: ShownVariable) -> list[ShownImage]:
        """Return all parts of a variable, that with most to see first."""
        return [ShownImage(variable, number) for number in variable.order()]

    @property
    def name(self) -> str:
        """Name of the variable."""
        return self.variable.name

    @property
    def label(self) -> str:
        """Name of the variable in words."""
        return self.name.replace("_", " ")

    @property
    def units(self) -> str:
        """Unit for a label of matplotlib."""
        units = self.variable.units
        return {"W m-2 sr-1": "W m$^{-2}$ sr$^{-1}$", "1": ""}.get(units, units)

    @property
    def part(self) -> str:
        """Name of the band or layer, or empty."""
        return self.variable.parts[self.number]

    @property
    def limits_um(self) -> tuple[float, float] | None:
        """Limits of the band."""
        return self.variable.limits_um[self.number] if self.variable.limits_um else None

    @property
    def colours(self) -> str:
        """Colour map: grey, so that every print and page shows it alike."""
        return "gray_r" if self.variable.colours(self.number) == "gray_r" else "gray"

    @property
    def flags(self) -> tuple[str, ...]:
        """Meanings of 0, 1, ... of a variable of flags."""
        return self.variable.flags

    @property
    def frames(self) -> int:
        """Number of frames."""
        return int(self.variable.data.sizes["time"])

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return int(self.variable.data.sizes["y"]), int(self.variable.data.sizes["x"])

    @property
    def times(self) -> NDArray[np.datetime64]:
        """Times of the frames."""
        return np.asarray(self.variable.data["time"].to_numpy())

    def values(self, frames: Sequence[int] | NDArray[Any], step: int = 1) -> NDArray[Any]:
        """Return frames (time, y, x), every ``step``-th row and column."""
        every = slice(None, None, step)
        return self.variable.read(self.number, time=list(frames), y=every, x=every)
