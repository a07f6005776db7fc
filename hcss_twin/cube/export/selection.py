"""Selection of cube data for export: one variable, some of its frames and bands, and their description."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.errors import CubeError, choose_from
from hcss_twin.core.json_numbers import json_value
from hcss_twin.core.reading import reading
from hcss_twin.cube.coordinates import GRID_MAPPING, frame_times_s
from hcss_twin.cube.export.place import PixelGrid, axis, local_plane
from hcss_twin.cube.variables import LAYER
from hcss_twin.version import __version__

if TYPE_CHECKING:
    import xarray as xr


DEFAULT_VARIABLE = "radiance"

_PLANES = ("band", LAYER)
_RESOLUTION = re.compile(r"\s*([0-9.eE+-]+) m\s*\Z")


@dataclass(frozen=True)
class ExportFrame:
    """One frame: number in the cube, time (UTC) and displacement of the platform.

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


@dataclass(frozen=True)
class Selection:
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
    frames : tuple of ExportFrame
    rows, columns : int
    grid : PixelGrid
    attributes : mapping
        Global attributes of the cube.
    data : DataArray
        The variable.
    chosen : tuple of int
        Indices of the planes along their dimension.
    """

    variable: str
    units: str
    long_name: str
    standard_name: str
    comment: str
    dtype: np.dtype[Any]
    plane_kind: str
    planes: tuple[Plane, ...]
    frames: tuple[ExportFrame, ...]
    rows: int
    columns: int
    grid: PixelGrid
    attributes: dict[str, Any]
    data: xr.DataArray
    chosen: tuple[int, ...]

    def values(self, frame: ExportFrame) -> NDArray[Any]:
        """Return the planes of a frame (P, Y, X), southernmost row first.

        Raises
        ------
        CubeError
            If the cube's file cannot be read.
        """
        data = self.data if frame.number is None else self.data.isel(time=frame.number)
        if self.plane_kind:
            data = data.isel({self.plane_kind: list(self.chosen)})
        with reading(f"{self.variable} of frame {frame.number}", CubeError):
            values = data.to_numpy()
        return np.ascontiguousarray(values if self.plane_kind else values[None])


def count_missing(values: NDArray[Any]) -> int:
    """Return the number of NaN values; integers have none."""
    return int(np.count_nonzero(np.isnan(values))) if values.dtype.kind == "f" else 0


def select(
    dataset: xr.Dataset, variable: str | None, bands: Sequence[str] = (), frames: Sequence[int] = ()
) -> Selection:
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
    name = _variable(dataset, variable)
    data = dataset[name]
    kind = next((dim for dim in _PLANES if dim in data.dims), "")
    chosen = _planes(dataset, name, kind, bands)
    attributes = data.attrs
    return Selection(
        variable=name,
        **{key: str(attributes.get(key, "")) for key in ("units", "long_name", "standard_name", "comment")},
        dtype=data.dtype,
        plane_kind=kind,
        planes=tuple(_plane(dataset, kind, index) for index in chosen),
        frames=_frames(dataset, name, frames),
        rows=data.sizes["y"],
        columns=data.sizes["x"],
        grid=_grid(dataset, data),
        attributes={key: _plain(value) for key, value in dataset.attrs.items()},
        data=data,
        chosen=chosen,
    )


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
    known = [str(each) for each in dataset["band"].to_numpy()]
    for band in bands:
        if band not in known:
            raise CubeError(f"band '{band}': the cube has no such band; {choose_from(band, known)}")
        if list(bands).count(band) > 1:
            raise CubeError(f"band '{band}': requested more than once")
    return tuple(known.index(band) for band in bands or known)


def _plane(dataset: xr.Dataset, kind: str, index: int) -> Plane:
    if kind != "band":
        return Plane(str(dataset[kind].to_numpy()[index]) if kind else "")
    lower, upper = dataset["wavelength_bounds"].to_numpy()[index]
    return Plane(
        str(dataset["band"].to_numpy()[index]),
        float(lower),
        float(dataset["wavelength"].to_numpy()[index]),
        float(upper),
    )


def _frames(dataset: xr.Dataset, name: str, wanted: Sequence[int]) -> tuple[ExportFrame, ...]:
    seconds = frame_times_s(dataset)
    times = np.datetime_as_string(dataset["time"].to_numpy().astype("datetime64[us]"))
    displacements = dataset["centre_displacement"].to_numpy()
    if "time" not in dataset[name].dims:
        if wanted:
            raise CubeError(f"frame {wanted[0]}: {name} is the same for all frames; allowed: none")
        return (ExportFrame(None, f"{times[0]}Z", float(seconds[0]), float(displacements[0])),)
    last = seconds.size - 1
    for number in wanted:
        if not 0 <= number <= last:
            nearest = min(max(number, 0), last)
            raise CubeError(f"frame {number}: the cube has 0 to {last}; closest is {nearest}")
        if list(wanted).count(number) > 1:
            raise CubeError(f"frame {number}: requested more than once")
    return tuple(
        ExportFrame(number, f"{times[number]}Z", float(seconds[number]), float(displacements[number]))
        for number in wanted or range(seconds.size)
    )


def _grid(dataset: xr.Dataset, data: xr.DataArray) -> PixelGrid:
    # coordinates, such as the latitude of each pixel, have no attribute grid_mapping
    mapping = data.encoding.get("grid_mapping", data.attrs.get("grid_mapping", GRID_MAPPING))
    if mapping not in dataset.variables:
        raise CubeError(f"{data.name}: the cube has no grid mapping '{mapping}'")
    given = _RESOLUTION.match(str(dataset.attrs.get("geospatial_lat_resolution", "")))
    size = float(given.group(1)) if given else None
    west, step_x = axis("x", dataset["x"].to_numpy().astype(np.float64), size)
    south, step_y = axis("y", dataset["y"].to_numpy().astype(np.float64), size)
    return PixelGrid(west, south, step_x, step_y, local_plane(dataset[mapping].attrs))


def _plain(value: Any) -> Any:
    """Return an attribute as a number, text or list for JSON."""
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else value


def description(selection: Selection, source: str) -> dict[str, Any]:
    """Return the description of an export, without its values, for JSON.

    Parameters
    ----------
    source : str
        Name of the cube's file.
    """
    grid = selection.grid
    return {
        "exported_by": f"hcss_twin {__version__}",
        "cube": source,
        "variable": selection.variable,
        "units": selection.units,
        "long_name": selection.long_name,
        "standard_name": selection.standard_name,
        "comment": selection.comment,
        "rows": selection.rows,
        "columns": selection.columns,
        "plane_kind": selection.plane_kind,
        "planes": [asdict(plane) for plane in selection.planes],
        "frames": [asdict(frame) for frame in selection.frames],
        "grid": {
            "projection": "azimuthal equidistant",
            **asdict(grid.plane),
            "west_pixel_centre_m": grid.west_m,
            "south_pixel_centre_m": grid.south_m,
            "pixel_size_x_m": grid.step_x_m,
            "pixel_size_y_m": grid.step_y_m,
            "wkt": grid.plane.esri_wkt,
        },
        "attributes": selection.attributes,
    }


def json_text(document: dict[str, Any]) -> str:
    """Serialise a document as ASCII JSON; non-finite numbers become null."""
    return json.dumps(json_value(document), indent=1, allow_nan=False) + "\n"


def headline(selection: Selection) -> str:
    """Return a one-line title, for formats that display one."""
    units = f", {selection.units}" if selection.units not in ("", "1") else ""
    return f"{selection.long_name or selection.variable}{units}"


def image_name(frame: ExportFrame, plane: Plane) -> str:
    """Return the name of one exported image."""
    named = plane.name or "image"
    return named if frame.number is None else f"{named} frame {frame.number} ({frame.time})"


def ascii_text(text: str) -> str:
    """Escape non-ASCII characters and replace line breaks by spaces: many formats allow printable ASCII only."""
    flat = " ".join(text.split())
    return flat.encode("ascii", "backslashreplace").decode()
