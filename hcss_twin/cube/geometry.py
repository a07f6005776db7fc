"""Values of the viewing geometry of every pixel, by parts of the image."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.cube.geometry_variables import LOCATION
from hcss_twin.cube.header import CubeHeader
from hcss_twin.errors import CubeError
from hcss_twin.physics.local_plane import to_geographic
from hcss_twin.viewing.lines_of_sight import LinesOfSight

Array = NDArray[np.float64]

PIXELS_AT_ONCE = 2**18
"""Memory does not grow with the image."""


@dataclass(frozen=True)
class PixelGeometry:
    """The viewing geometry that a header asks for."""

    header: CubeHeader

    def __post_init__(self) -> None:
        known = {spec.name for spec in LOCATION}
        if self.header.sensor_altitude_m is None:
            for spec in self.header.geometry:
                if spec.name not in known:
                    raise CubeError(f"{spec.name}: sensor_altitude_m is needed, and not known")

    @property
    def of_frames(self) -> tuple[str, ...]:
        """What every frame has for itself."""
        return tuple(spec.name for spec in self.header.geometry if "time" in spec.dims)

    @property
    def of_image(self) -> tuple[str, ...]:
        """What holds for all frames."""
        return tuple(spec.name for spec in self.header.geometry if "time" not in spec.dims)

    def parts(self, names: tuple[str, ...], time_s: float) -> Iterator[tuple[slice, dict[str, NDArray[Any]]]]:
        """Yield rows of the image, from the first to the last, with the values (rows, x) of what is named.

        Parameters
        ----------
        time_s : float
            Time after the start, for what every frame has for itself.
        """
        header = self.header
        if not names:
            return
        step = max(1, PIXELS_AT_ONCE // header.columns)
        for row in range(0, header.rows, step):
            rows = slice(row, min(row + step, header.rows))
            yield rows, self.values(names, rows, slice(0, header.columns), time_s)

    def values(
        self, names: tuple[str, ...], rows: slice, columns: slice, time_s: float
    ) -> dict[str, NDArray[Any]]:
        """Return the values (rows, columns) of what is named, for one part of the image."""
        header = self.header
        x, y = np.meshgrid(
            pixel_centres_m(header.columns, header.pixel_size_m)[columns],
            pixel_centres_m(header.rows, header.pixel_size_m)[rows],
        )
        known: dict[str, Array] = {}
        located = {spec.name for spec in LOCATION} & set(names)
        if located:
            # Where one place holds for all frames the platform stands still.
            along = x + header.platform_speed_m_s * time_s
            known["pixel_latitude"], known["pixel_longitude"] = to_geographic(
                along, y, header.latitude, header.longitude
            )
        if set(names) - located:
            known |= self._directions(x, y)
        types = {spec.name: spec.dtype for spec in header.geometry}
        return {name: known[name].astype(types[name], copy=False) for name in names}

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
            header.latitude,
            header.longitude,
            header.view_zenith_deg,
            header.view_azimuth_deg,
            header.sensor_altitude_m,
        )

    @cached_property
    def _centre_range_m(self) -> float:
        return self._lines.centre_range_m


def pixel_centres_m(count: int, size_m: float) -> Array:
    """Return the distances (count,) of pixel centres from that of the image, along one axis."""
    return (np.arange(count, dtype=np.float64) - 0.5 * (count - 1)) * np.float64(size_m)
