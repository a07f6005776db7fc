"""The accessor ``.hcss`` of datasets: brightness temperature, a picture, one place, and camera images on the ground.

Importing this module registers it; the functions of ``hcss_twin`` that return datasets do so.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import xarray as xr

from hcss_twin.core.arguments import checked
from hcss_twin.core.errors import CubeError, OptionError, choose_from
from hcss_twin.core.reading import MAX_VALUES
from hcss_twin.cube.frame_selection import FrameSelection
from hcss_twin.engine.cube_temperature import brightness_temperature
from hcss_twin.physics.geodesy import Ellipsoid

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from hcss_twin.core.arrays import Array


Pixels: TypeAlias = "tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.bool_]]"


@xr.register_dataset_accessor("hcss")  # type: ignore[no-untyped-call]
class CubeAccessor:
    """Methods of a cube as ``cube.hcss``."""

    def __init__(self, cube: xr.Dataset) -> None:
        self._cube = cube

    def brightness_temperature(self) -> xr.DataArray:
        """Return the brightness temperature (time, band, y, x), K: that stored, or :func:`brightness_temperature`."""
        if "brightness_temperature" in self._cube:
            return self._cube["brightness_temperature"]
        return brightness_temperature(self._cube)

    @checked
    def plot(
        self,
        variable: str | None = None,
        band: str | None = None,
        frame: int = 0,
        axes: Any = None,
        linear: bool = False,
    ) -> Any:
        """Draw a frame with its scale, as ``hcss preview`` does.

        Parameters
        ----------
        variable : str, optional
            Default: brightness temperature, or the first of what a preview would draw.
        band : str, optional
            Band or layer; default: that with most to see.
        frame : int
            Number of the frame.
        axes : matplotlib.axes.Axes, optional
            Where to draw; default: a new figure of pyplot.
        linear : bool
            Linear scale; without it, frequent values have more contrast.

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        CubeError
            If the cube has no such variable, band or frame.
        """
        from hcss_twin.reports.preview import axes_of_frame
        from hcss_twin.reports.shown_image import ShownImage, require_variable, with_kelvin

        dataset = FrameSelection.as_seen(self._cube)
        images = with_kelvin(dataset, required=variable == "brightness_temperature")
        shown = images[require_variable(images, variable)]
        ordered = {image.part: image for image in ShownImage.ordered(shown)}
        if band is not None and band not in ordered:
            raise CubeError(f"band '{band}'; {choose_from(band, list(ordered))}")
        image = next(iter(ordered.values())) if band is None else ordered[band]
        if not 0 <= frame < image.frames:
            raise CubeError(f"frame {frame}; allowed: 0 to {image.frames - 1}")
        if axes is None:
            from matplotlib import pyplot

            axes = pyplot.subplots(layout="constrained")[1]
        return axes_of_frame(dataset, image, frame, linear, axes)

    @checked
    def at(self, latitude: float, longitude: float) -> xr.Dataset:
        """Return the series of the pixel nearest to a place, with missing values in frames that do not see it.

        Parameters
        ----------
        latitude, longitude : float
            Degrees north and east.

        Returns
        -------
        Dataset (time, ...)
            With the methods of ``.hcss``, such as ``.hcss.brightness_temperature()``. ``y`` and ``x``, or ``row`` and
            ``column``, are those of the pixel in each frame; ``latitude`` and ``longitude`` of cubes on the ground,
            which are those of the image centre, become those of the place.

        Raises
        ------
        OptionError
            For a latitude beyond the poles.
        CubeError
            If no frame sees the place.
        """
        if not -90.0 <= latitude <= 90.0:
            raise OptionError(f"at: latitude: {latitude:g} (the first argument); allowed: -90 to 90")
        rows, columns, seen = self._pixels_at(latitude, longitude)
        if not np.any(seen):
            raise CubeError(f"latitude {latitude:g}, longitude {longitude:g}: no frame of the cube sees that place")
        y, x = self._axes
        frames = {
            name: xr.DataArray(np.where(seen, index, 0), dims="time") for name, index in ((y, rows), (x, columns))
        }
        # frames are taken one by one, because a platform that moves has the place in another pixel
        frames["time"] = xr.DataArray(np.arange(seen.size), dims="time")
        picked = self._cube.isel(frames)
        for name, degrees in (("latitude", latitude), ("longitude", longitude)):
            if name in picked.coords and picked[name].ndim == 0:
                picked = picked.assign_coords({name: ((), float(degrees), picked[name].attrs)})
        if np.all(seen):
            return picked
        when = xr.DataArray(seen, dims="time")
        per_frame = [name for name, data in picked.data_vars.items() if "time" in data.dims]
        missing = {name: picked[name].where(when) for name in (*per_frame, y, x)}
        return picked.assign_coords({name: missing.pop(name) for name in (y, x)}).assign(missing)

    @checked
    def to_ground(self, pixel_size_m: float | None = None) -> xr.Dataset:
        """Return the images of a camera on a plane on the ground, north up; cubes that are on it already as they are.

        Every pixel of the plane, the azimuthal equidistant one around the middle of all frames, has the values of the
        nearest pixel of the image, and none where no pixel of the frame is near.

        Parameters
        ----------
        pixel_size_m : float, optional
            Default: the median distance of neighbouring columns.

        Returns
        -------
        Dataset (time, ..., y, x)

        Raises
        ------
        CubeError
            If the cube has no places of its pixels, the size is not positive, or the result is too large.
        """
        if "row" not in self._cube.dims:
            if pixel_size_m is not None:
                raise CubeError("pixel_size_m: the cube is on the ground already; allowed: no size")
            return self._cube
        return _on_plane(self._cube, pixel_size_m)

    @property
    def _axes(self) -> tuple[str, str]:
        return ("row", "column") if "row" in self._cube.dims else ("y", "x")

    def _pixels_at(self, latitude: float, longitude: float) -> Pixels:
        """Return row, column and whether it is in the image, by frame."""
        cube = self._cube
        if "row" in cube.dims:
            return _nearest_of_camera(cube, latitude, longitude)
        centre = float(cube["latitude"].to_numpy().ravel()[0]), float(cube["longitude"].to_numpy().ravel()[0])
        try:
            plane = Ellipsoid.to_plane(np.array(latitude), np.array(longitude), *centre)
        except ValueError:  # on the other side of the Earth
            plane = np.array(np.inf), np.array(np.inf)
        east, north = (float(part) for part in plane)
        moved = np.zeros(cube.sizes["time"])
        if "centre_displacement" in cube.variables:
            moved = np.broadcast_to(cube["centre_displacement"].to_numpy(), moved.shape)
        rows, row_inside = _nearest_of_axis(cube["y"].to_numpy(), np.full(moved.shape, north))
        columns, column_inside = _nearest_of_axis(cube["x"].to_numpy(), east - moved)
        return rows, columns, row_inside & column_inside


def _nearest_of_axis(axis: Array, wanted: Array) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    if axis.size < 2:
        raise CubeError("an image of one row or column has no pixels of known size; allowed: at least two")
    place = (wanted - float(axis[0])) / (float(axis[-1]) - float(axis[0])) * (axis.size - 1)
    inside = (place > -0.5) & (place < axis.size - 0.5)
    return np.rint(np.where(inside, place, 0.0)).astype(np.int64), inside


def _places(cube: xr.Dataset) -> tuple[Array, Array]:
    """Return latitude and longitude (time, row, column) of the pixels of a camera."""
    names = ("pixel_latitude", "pixel_longitude")
    if any(name not in cube.variables for name in names):
        raise CubeError("the cube has no pixel_latitude and pixel_longitude; request output.variables 'geometry'")
    shape = tuple(cube.sizes[dim] for dim in ("time", "row", "column"))
    latitude, longitude = (
        np.broadcast_to(cube[name].transpose(..., "row", "column").to_numpy(), shape) for name in names
    )
    return latitude.astype(np.float64), longitude.astype(np.float64)


def _nearest_of_camera(cube: xr.Dataset, latitude: float, longitude: float) -> Pixels:
    rows, columns, seen = [], [], []
    for lat, lon in zip(*_places(cube), strict=True):
        north = np.radians(lat - latitude)
        # chords: they are also long on the other side of the Earth
        east = 2.0 * np.sin(np.radians((lon - longitude + 180.0) % 360.0 - 180.0) / 2.0)
        east *= math.cos(math.radians(latitude))
        away = np.hypot(north, east)
        if np.all(np.isnan(away)):
            best, near = (0, 0), False
        else:
            place = np.unravel_index(int(np.nanargmin(away)), away.shape)
            best = int(place[0]), int(place[1])
            # within the pixel: nearer than one step to a neighbour
            steps = [np.hypot(np.diff(north, axis=axis), np.diff(east, axis=axis)) for axis in (0, 1)]
            largest = np.nanmax([np.nanmedian(step) for step in steps if step.size] or [np.nan])
            near = bool(away[best] <= largest)
        rows.append(best[0])
        columns.append(best[1])
        seen.append(near)
    return np.array(rows, np.int64), np.array(columns, np.int64), np.array(seen, bool)


def _on_plane(cube: xr.Dataset, size_m: float | None) -> xr.Dataset:
    from scipy.spatial import KDTree

    latitude, longitude = _places(cube)
    if np.all(np.isnan(latitude)):
        raise CubeError("no pixel of the cube is on the ground")
    centre = float(np.nanmean(latitude)), _mean_longitude(longitude)
    flat = np.isfinite(latitude)
    east, north = np.full(latitude.shape, np.nan), np.full(latitude.shape, np.nan)
    east[flat], north[flat] = Ellipsoid.to_plane(latitude[flat], longitude[flat], *centre)
    step = float(np.nanmedian(np.hypot(np.diff(east, axis=2), np.diff(north, axis=2))))
    size = step if size_m is None else size_m
    if not size > 0.0:
        raise CubeError(f"pixel_size_m: {size:g}; allowed: above 0")
    columns, rows = (float(np.nanmax(along) - np.nanmin(along)) // size + 2.0 for along in (east, north))
    if rows * columns * cube.sizes["time"] > MAX_VALUES // 8:
        raise CubeError(
            f"pixel_size_m: {size:g}; {rows:.3g} x {columns:.3g} pixels a frame are too many; allowed: a larger one"
        )
    x, y = (np.nanmin(along) + size * np.arange(count) for along, count in ((east, columns), (north, rows)))
    grid = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    across = (
        float(np.nanmedian(np.hypot(np.diff(east, axis=1), np.diff(north, axis=1)))) if latitude.shape[1] > 1 else step
    )
    frames = []
    for number in range(cube.sizes["time"]):
        known = flat[number]
        places = np.stack([east[number][known], north[number][known]], axis=-1)
        away, index = (
            KDTree(places).query(grid) if len(places) else (np.full(len(grid), np.inf), np.zeros(len(grid), int))
        )
        seen = (away <= 0.75 * max(step, across, size)).reshape(y.size, x.size)
        frames.append(_frame_on_plane(cube.isel(time=number), known, index, seen))
    result = xr.concat(frames, dim="time", data_vars="all", coords="minimal", compat="override", join="override")
    unit = {"units": "m", "standard_name": ""}
    for name, axis, toward in (("x", x, "east"), ("y", y, "north")):
        attributes = {**unit, "standard_name": f"projection_{name}_coordinate"}
        result = result.assign_coords(
            {name: (name, axis, {**attributes, "long_name": f"distance {toward} of the centre"})}
        )
    result = result.assign_coords(time=cube["time"], latitude=centre[0], longitude=centre[1])
    result.attrs = dict(cube.attrs)
    return result


def _frame_on_plane(frame: xr.Dataset, known: NDArray[np.bool_], index: Any, seen: NDArray[np.bool_]) -> xr.Dataset:
    """Return the image variables of one frame at the nearest pixels."""
    variables = {}
    for name, data in frame.data_vars.items():
        if not {"row", "column"} <= set(data.dims):
            continue
        planes = data.transpose(..., "row", "column")
        values = planes.to_numpy()[..., known]
        if values.shape[-1]:
            values = values[..., index].reshape(*values.shape[:-1], *seen.shape)
        else:
            values = np.full((*values.shape[:-1], *seen.shape), np.nan)
        variables[name] = ((*planes.dims[:-2], "y", "x"), np.where(seen, values, np.nan), data.attrs)
    kept = {
        name: coordinate for name, coordinate in frame.coords.items() if not {"row", "column"} & set(coordinate.dims)
    }
    kept = {name: coordinate for name, coordinate in kept.items() if name != "time"}
    return xr.Dataset(variables, kept)


def _mean_longitude(longitude: Array) -> float:
    turned = np.radians(longitude[np.isfinite(longitude)])
    return float(np.degrees(np.arctan2(np.mean(np.sin(turned)), np.mean(np.cos(turned)))))
