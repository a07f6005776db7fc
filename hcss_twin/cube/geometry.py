"""Geographic extent of a cube, and the viewing geometry of each pixel."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import CubeError
from hcss_twin.cube.header import CubeHeader
from hcss_twin.cube.variables import LOCATION
from hcss_twin.physics.geodesy import distance_from_equator_m, to_geographic
from hcss_twin.physics.viewing import LinesOfSight

POINTS_PER_SIDE = 16


@dataclass(frozen=True)
class Footprint:
    """Extent of the area covered by all frames, degrees.

    Longitudes continue beyond 180, so that west <= east always holds. ``outline`` contains points (latitude,
    longitude), anticlockwise from the south-west corner, not closed.
    """

    south: float
    north: float
    west: float
    east: float
    outline: tuple[tuple[float, float], ...]


def footprint(header: CubeHeader) -> Footprint:
    """Return the extent of the outer edges of all frames."""
    if (layout := header.layout) is not None:
        corners = (
            (layout.south, layout.west),
            (layout.south, layout.east),
            (layout.north, layout.east),
            (layout.north, layout.west),
        )
        return Footprint(layout.south, layout.north, layout.west, layout.east, corners)
    shifts = [header.platform_speed_m_s * time for time in (*header.frame_times_s, 0.0)]
    window, size = header.image_window, header.pixel_size_m
    west_m = (window.first_column - 0.5 * window.image_columns) * size
    east_m = (window.first_column + header.columns - 0.5 * window.image_columns) * size
    y0 = (window.first_row - 0.5 * window.image_rows) * size
    y1 = (window.first_row + header.rows - 0.5 * window.image_rows) * size
    x0, x1 = min(shifts) + west_m, max(shifts) + east_m
    along = np.arange(POINTS_PER_SIDE) / POINTS_PER_SIDE
    corner_x = np.array([x0, x1, x1, x0, x0])
    corner_y = np.array([y0, y0, y1, y1, y0])
    x = np.concatenate([corner_x[i] + along * (corner_x[i + 1] - corner_x[i]) for i in range(4)])
    y = np.concatenate([corner_y[i] + along * (corner_y[i + 1] - corner_y[i]) for i in range(4)])
    latitudes, longitudes = to_geographic(x, y, header.latitude, header.longitude)
    south, north = float(latitudes.min()), float(latitudes.max())
    west, east = float(longitudes.min()), float(longitudes.max())
    for pole in (90.0, -90.0):
        # The central meridian of the plane passes through both poles.
        pole_m = distance_from_equator_m(pole) - distance_from_equator_m(header.latitude)
        if y0 <= pole_m <= y1 and x0 <= 0.0 <= x1:
            south, north = min(south, pole), max(north, pole)
            west, east = -180.0, 180.0
    outline = tuple(zip(latitudes.tolist(), longitudes.tolist(), strict=True))
    return Footprint(south, north, west, east, outline)


PIXELS_AT_ONCE = 2**18
"""Number of pixels computed at once."""

Window = tuple[slice, slice]
"""Rows and columns of a part of the cube."""


@dataclass(frozen=True)
class PixelGeometry:
    """The viewing geometry that a header requests."""

    header: CubeHeader

    def __post_init__(self) -> None:
        known = {spec.name for spec in LOCATION}
        if self.header.sensor_altitude_m is None:
            for spec in self.header.geometry:
                if spec.name not in known:
                    raise CubeError(f"{spec.name}: needs sensor_altitude_m, which is unknown")

    @property
    def of_frames(self) -> tuple[str, ...]:
        """Names of the coordinates that differ between frames."""
        return tuple(spec.name for spec in self.header.geometry if "time" in spec.dims)

    @property
    def of_image(self) -> tuple[str, ...]:
        """Names of the coordinates that are the same in all frames."""
        return tuple(spec.name for spec in self.header.geometry if "time" not in spec.dims)

    def parts(
        self,
        names: tuple[str, ...],
        tile: tuple[int, int] | None = None,
        time_s: float = 0.0,
        inside: Window | None = None,
    ) -> Iterator[tuple[Window, dict[str, NDArray[Any]]]]:
        """Yield parts of the cube, row by row from its first pixel, with the values (y, x) of the named coordinates.

        Parameters
        ----------
        tile : (int, int), optional
            Rows and columns of a part; by default strips of few pixels.
        time_s : float
            Time after the start, for coordinates that differ between frames.
        inside : (slice, slice), optional
            Rows and columns of the cube, by default all.
        """
        if not names:
            return
        all_rows, all_columns = self._all if inside is None else inside
        height, width = tile or (max(1, PIXELS_AT_ONCE // (all_columns.stop - all_columns.start)), None)
        for rows in _cut(all_rows, height):
            for columns in _cut(all_columns, width):
                yield (rows, columns), self.values(names, (rows, columns), time_s)

    def values(self, names: tuple[str, ...], region: Window, time_s: float = 0.0) -> dict[str, NDArray[Any]]:
        """Return the values (y, x) of the named coordinates for rows and columns of the cube.

        The result for a pixel is bit-identical in every part and window of the image.
        """
        rows, columns = region
        types = {spec.name: spec.dtype for spec in self.header.geometry}
        shape = rows.stop - rows.start, columns.stop - columns.start
        result = {name: np.empty(shape, dtype=types[name]) for name in names}
        if not names:
            return result
        # Intermediate arrays take much more memory than the result.
        for strip in _cut(rows, max(1, PIXELS_AT_ONCE // shape[1])):
            part = slice(strip.start - rows.start, strip.stop - rows.start)
            for name, values in self._strip(names, strip, columns, time_s).items():
                result[name][part] = values
        return result

    @property
    def _all(self) -> Window:
        return slice(0, self.header.rows), slice(0, self.header.columns)

    def _strip(self, names: tuple[str, ...], rows: slice, columns: slice, time_s: float) -> dict[str, Array]:
        header, whole = self.header, self.header.image_window
        x, y = np.meshgrid(
            pixel_centres_m(
                whole.first_column + columns.start,
                columns.stop - columns.start,
                whole.image_columns,
                header.pixel_size_m,
            ),
            pixel_centres_m(
                whole.first_row + rows.start, rows.stop - rows.start, whole.image_rows, header.pixel_size_m
            ),
        )
        known: dict[str, Array] = {}
        located = {spec.name for spec in LOCATION} & set(names)
        if located:
            # time_s is omitted only if the platform does not move
            along = x + header.platform_speed_m_s * time_s
            known["pixel_latitude"], known["pixel_longitude"] = to_geographic(
                along, y, header.latitude, header.longitude
            )
        if set(names) - located:
            known |= self._directions(x, y)
        return {name: known[name] for name in names}

    def _directions(self, x_m: Array, y_m: Array) -> dict[str, Array]:
        sight = self._lines.from_points(x_m, y_m)
        width = self.header.pixel_size_m / self._centre_range_m * sight.range_m
        return {
            "pixel_view_zenith": sight.zenith_deg,
            "pixel_view_azimuth": sight.azimuth_deg,
            "pixel_slant_range": sight.range_m,
            "pixel_footprint_across": width,
            "pixel_footprint_along": width / np.cos(np.radians(sight.zenith_deg)),
        }

    @cached_property
    def _lines(self) -> LinesOfSight:
        header = self.header
        assert header.sensor_altitude_m is not None
        return LinesOfSight(
            header.latitude, header.longitude, header.view_zenith_deg, header.view_azimuth_deg, header.sensor_altitude_m
        )

    @cached_property
    def _centre_range_m(self) -> float:
        return self._lines.centre_range_m


def pixel_centres_m(first: int, count: int, whole: int, size_m: float) -> Array:
    """Return the distances (count,) of pixel centres from the centre of an image of ``whole`` pixels along one axis."""
    return (np.arange(first, first + count, dtype=np.float64) - 0.5 * (whole - 1)) * np.float64(size_m)


def _cut(whole: slice, size: int | None) -> Iterator[slice]:
    """Split a range into ranges of at most ``size`` pixels; None: one range."""
    for start in range(whole.start, whole.stop, size or max(1, whole.stop - whole.start)):
        yield slice(start, whole.stop if size is None else min(start + size, whole.stop))
