"""Extent of a cube on the globe."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hcss_twin.cube.header import CubeHeader
from hcss_twin.physics.ellipsoid import distance_from_equator_m
from hcss_twin.physics.local_plane import to_geographic

POINTS_PER_SIDE = 16


@dataclass(frozen=True)
class Footprint:
    """Extent of everything the image covers from the first to the last frame, degrees.

    Longitudes run on beyond 180 rather than jump, so that west <= east always holds. ``outline``
    holds points (latitude, longitude), anticlockwise from the south-west corner, not closed.
    """

    south: float
    north: float
    west: float
    east: float
    outline: tuple[tuple[float, float], ...]


def footprint(header: CubeHeader) -> Footprint:
    """Return the extent of the outer edges of all frames."""
    shifts = [header.platform_speed_m_s * time for time in (*header.frame_times_s, 0.0)]
    place, size = header.image_window, header.pixel_size_m
    west_m = (place.first_column - 0.5 * place.image_columns) * size
    east_m = (place.first_column + header.columns - 0.5 * place.image_columns) * size
    y0 = (place.first_row - 0.5 * place.image_rows) * size
    y1 = (place.first_row + header.rows - 0.5 * place.image_rows) * size
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
        # The plane's meridian through its centre leads to both.
        pole_m = distance_from_equator_m(pole) - distance_from_equator_m(header.latitude)
        if y0 <= pole_m <= y1 and x0 <= 0.0 <= x1:
            south, north = min(south, pole), max(north, pole)
            west, east = -180.0, 180.0
    outline = tuple(zip(latitudes.tolist(), longitudes.tolist(), strict=True))
    return Footprint(south, north, west, east, outline)
