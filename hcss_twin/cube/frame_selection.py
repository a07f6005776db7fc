"""Frames of an open cube by variable, band and number: what programs need that read cubes image by image."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.errors import CubeError, choose_from
from hcss_twin.core.reading import Reading
from hcss_twin.cube.coordinates import COORDINATES, GRID_MAPPING, frame_times_s, with_plane_axes
from hcss_twin.cube.pixel_grid import PixelGrid, first_and_step
from hcss_twin.cube.variables import LAYER

if TYPE_CHECKING:
    import xarray as xr


__all__ = ["FrameSelection"]

DEFAULT_VARIABLE = "radiance"

_PLANES = ("band", LAYER)
_RESOLUTION = re.compile(r"\s*([0-9.eE+-]+) m\s*\Z")


@dataclass(frozen=True)
class FrameSelection:
    """One variable of an open cube; values are read frame by frame.

    Attributes
    ----------
    variable, units, long_name, standard_name, comment : str
        Attributes of the variable; empty if missing.
    dtype : dtype
        Data type of the values.
    plane_kind : str
        ``band``, ``layer``, or empty if a frame is one image.
    planes : tuple of Plane
    frames : tuple of Frame
    rows, columns : int
    grid : PixelGrid or None
        None: the image is no grid on the ground.
    attributes : mapping
        Global attributes of the cube.
    data : DataArray
        The variable.
    chosen : tuple of int
        Indices of the planes along their dimension.
    GRID_MAPPING : str
        Name of the variable with the CF grid mapping.
    """

    @dataclass(frozen=True)
    class Frame:
        """One frame: number in the cube, time (UTC) and displacement of the platform.

        Images that are no grid on the ground have no displacement (NaN).
        A variable without a time dimension has one frame with number None and the time of the first frame.
        """

        number: int | None
        time: str
        seconds: float
        displacement_m: float

    @dataclass(frozen=True)
    class Plane:
        """One image of a frame: a band with its limits, a cloud layer, or the only image (no name)."""

        name: str
        lower_um: float | None = None
        central_um: float | None = None
        upper_um: float | None = None

    variable: str
    units: str
    long_name: str
    standard_name: str
    comment: str
    dtype: np.dtype[Any]
    plane_kind: str
    planes: tuple[Plane, ...]
    frames: tuple[Frame, ...]
    rows: int
    columns: int
    grid: PixelGrid | None
    attributes: dict[str, Any]
    data: xr.DataArray
    chosen: tuple[int, ...]

    GRID_MAPPING: ClassVar = GRID_MAPPING

    @staticmethod
    def coordinates(dataset: xr.Dataset) -> list[str]:
        """Return the names of the variables that are coordinates, though not all of a dimension."""
        return [spec.name for spec in COORDINATES if spec.name in dataset]

    @staticmethod
    def as_seen(dataset: xr.Dataset) -> xr.Dataset:
        """Return a cube to draw: axes y and x, and y upward, also of images whose rows count downward."""
        plane = with_plane_axes(dataset)
        return plane.isel(y=slice(None, None, -1)) if "row" in dataset.dims else plane

    @classmethod
    def of(
        cls, dataset: xr.Dataset, variable: str | None, bands: Sequence[str] = (), frames: Sequence[int] = ()
    ) -> FrameSelection:
        """Select a variable, bands and frames of an open cube.

        Parameters
        ----------
        variable : str or None
            None: radiance, or the only image variable.
        bands : sequence of str
            Names in output order; none: all.
        frames : sequence of int
            Numbers from 0 in output order; none: all.

        Raises
        ------
        CubeError
            If the cube has no such variable, band or frame; lists the available ones and the closest.
        """
        on_ground, dataset = "row" not in dataset.dims, FrameSelection.as_seen(dataset)
        name = _variable(dataset, variable)
        data = dataset[name]
        kind = next((dim for dim in _PLANES if dim in data.dims), "")
        chosen = _planes(dataset, name, kind, bands)
        attributes = data.attrs
        return cls(
            variable=name,
            **{key: str(attributes.get(key, "")) for key in ("units", "long_name", "standard_name", "comment")},
            dtype=data.dtype,
            plane_kind=kind,
            planes=tuple(_plane(dataset, kind, index) for index in chosen),
            frames=_frames(dataset, name, frames),
            rows=data.sizes["y"],
            columns=data.sizes["x"],
            grid=_grid(dataset) if on_ground else None,
            attributes={key: _plain(value) for key, value in dataset.attrs.items()},
            data=data,
            chosen=chosen,
        )

    def values(self, frame: Frame) -> NDArray[Any]:
        """Return the planes of a frame (P, Y, X), the southernmost, or the lowest, row first.

        Raises
        ------
        CubeError
            If the cube's file cannot be read.
        """
        data = self.data if frame.number is None else self.data.isel(time=frame.number)
        if self.plane_kind:
            data = data.isel({self.plane_kind: list(self.chosen)})
        with Reading(f"{self.variable} of frame {frame.number}", CubeError):
            values = data.to_numpy()
        return np.ascontiguousarray(values if self.plane_kind else values[None])


def _variable(dataset: xr.Dataset, wanted: str | None) -> str:
    images = [
        str(name)
        for name, data in dataset.variables.items()
        if data.dims[-2:] == ("y", "x") and set(data.dims[:-2]) <= {"time", *_PLANES} and data.dtype.kind in "fiu"
    ]
    if wanted is None:
        wanted = images[0] if len(images) == 1 else DEFAULT_VARIABLE
    if wanted not in images:
        raise CubeError(f"variable '{wanted}': the cube holds no such image; {choose_from(wanted, images)}")
    return wanted


def _planes(dataset: xr.Dataset, name: str, kind: str, bands: Sequence[str]) -> tuple[int, ...]:
    if kind != "band":
        if bands:
            raise CubeError(f"band '{bands[0]}': {name} is the same for all bands; allowed: none")
        return tuple(range(dataset.sizes[kind])) if kind else (0,)
    known = [str(band) for band in dataset["band"].to_numpy()]
    for band in bands:
        if band not in known:
            raise CubeError(f"band '{band}': the cube has no such band; {choose_from(band, known)}")
        if list(bands).count(band) > 1:
            raise CubeError(f"band '{band}': requested more than once")
    return tuple(known.index(band) for band in bands or known)


def _plane(dataset: xr.Dataset, kind: str, index: int) -> FrameSelection.Plane:
    if kind != "band":
        return FrameSelection.Plane(str(dataset[kind].to_numpy()[index]) if kind else "")
    lower, upper = dataset["wavelength_bounds"].to_numpy()[index]
    return FrameSelection.Plane(
        str(dataset["band"].to_numpy()[index]),
        float(lower),
        float(dataset["wavelength"].to_numpy()[index]),
        float(upper),
    )


def _frames(dataset: xr.Dataset, name: str, wanted: Sequence[int]) -> tuple[FrameSelection.Frame, ...]:
    seconds = frame_times_s(dataset)
    times = np.datetime_as_string(dataset["time"].to_numpy().astype("datetime64[us]"))
    displacements = np.full(seconds.size, np.nan)  # of images that are no grid on the ground
    if "centre_displacement" in dataset:
        displacements = dataset["centre_displacement"].to_numpy()
    if "time" not in dataset[name].dims:
        if wanted:
            raise CubeError(f"frame {wanted[0]}: {name} is the same for all frames; allowed: none")
        return (FrameSelection.Frame(None, f"{times[0]}Z", float(seconds[0]), float(displacements[0])),)
    last = seconds.size - 1
    for number in wanted:
        if not 0 <= number <= last:
            nearest = min(max(number, 0), last)
            raise CubeError(f"frame {number}: the cube has 0 to {last}; closest is {nearest}")
        if list(wanted).count(number) > 1:
            raise CubeError(f"frame {number}: requested more than once")
    return tuple(
        FrameSelection.Frame(number, f"{times[number]}Z", float(seconds[number]), float(displacements[number]))
        for number in wanted or range(seconds.size)
    )


def _grid(dataset: xr.Dataset) -> PixelGrid:
    given = _RESOLUTION.match(str(dataset.attrs.get("geospatial_lat_resolution", "")))
    size = float(given.group(1)) if given else None
    west, step_x = first_and_step("x", dataset["x"].to_numpy().astype(np.float64), size)
    south, step_y = first_and_step("y", dataset["y"].to_numpy().astype(np.float64), size)
    return PixelGrid(west, south, step_x, step_y)


def _plain(value: Any) -> Any:
    """Return an attribute as a number, text or list for JSON."""
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else value
