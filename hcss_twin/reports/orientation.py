"""How an image lies on the ground: its scale, and where north, the sun and the sensor are in it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from hcss_twin.core.arrays import Array

if TYPE_CHECKING:
    import xarray as xr

EARTH_RADIUS_M = 6.371e6

OVERHEAD_DEG = 0.5
"""Zenith angle below which the sensor has no bearing that a picture could show."""


@dataclass(frozen=True)
class Orientation:
    """An image, or the middle of one that a camera took, as it lies on the ground.

    Attributes
    ----------
    ground : ndarray (2, 2)
        Metres east and north (rows) of one column to the right and one row upward (columns).
    view, sun : (zenith, bearing) or None
        Degrees, of the sensor and the sun in the first frame, seen from the ground.
    is_map : bool
        Whether north is up and all pixels have this size.
    """

    ground: Array
    view: tuple[float, float] | None
    sun: tuple[float, float] | None
    is_map: bool

    @classmethod
    def of(cls, dataset: xr.Dataset) -> Orientation | None:
        """Return the orientation of a cube with axes y (upward) and x; None if its middle is not on the ground."""
        x, y = dataset["x"], dataset["y"]
        is_map = x.attrs.get("units") == "m"
        view = middle_angles(dataset, "sensor_zenith_angle", "sensor_azimuth_angle")
        if is_map:
            steps = [abs(float(axis[1] - axis[0])) if axis.size > 1 else math.nan for axis in (x, y)]
            known = [step for step in steps if not math.isnan(step)]
            if not known:
                return None
            ground = np.diag([known[0] if math.isnan(step) else step for step in steps])
        else:
            ground = _camera_ground(dataset)
            view = middle_angles(dataset, "pixel_view_zenith", "pixel_view_azimuth") or view
        if not np.all(np.isfinite(ground)) or abs(np.linalg.det(ground)) < 1e-9:
            return None
        return cls(ground, view, middle_angles(dataset, "solar_zenith_angle", "solar_azimuth_angle"), is_map)

    @property
    def column_m(self) -> float:
        """Ground distance of neighbouring columns, m."""
        return float(np.hypot(*self.ground[:, 0]))

    def direction(self, bearing_deg: float) -> tuple[float, float]:
        """Return the unit vector, right and up in the image, of a bearing on the ground."""
        bearing = math.radians(bearing_deg)
        right, up = np.linalg.solve(self.ground, [math.sin(bearing), math.cos(bearing)])
        length = math.hypot(right, up)
        return right / length, up / length

    def arrows(self) -> Iterator[tuple[str, tuple[float, float]]]:
        """Yield name and direction of north, and of the sun and the sensor where they are above the horizon."""
        yield "N", self.direction(0.0)
        for name, angles in (("sun", self.sun), ("sensor", self.view)):
            if angles is not None and (name == "sun" or angles[0] > OVERHEAD_DEG) and angles[0] < 90.0:
                yield name, self.direction(angles[1])

    def words(self) -> dict[str, str]:
        """Return where sun and sensor are."""
        words = {}
        if self.sun is not None:
            below = self.sun[0] >= 90.0
            words["sun"] = "sun below horizon" if below else f"sun {self.sun[0]:.0f}° from zenith"
        if self.view is not None:
            overhead = self.view[0] <= OVERHEAD_DEG
            words["sensor"] = "sensor overhead" if overhead else f"sensor {self.view[0]:.0f}° from zenith"
        return words

    def bar_m(self, columns: int) -> float:
        """Return the length of a scale bar: 1, 2 or 5 times a power of ten, at most a quarter of the width."""
        most = self.column_m * columns / 4.0
        decade = 10.0 ** math.floor(math.log10(most))
        return float(max(factor * decade for factor in (1, 2, 5) if factor * decade <= most * (1 + 1e-9)))


def length_text(length_m: float) -> str:
    """Format a length in km, or in m below one."""
    return f"{length_m / 1e3:g} km" if length_m >= 1e3 else f"{length_m:g} m"


def middle_angles(dataset: xr.Dataset, zenith: str, azimuth: str) -> tuple[float, float] | None:
    """Return the angles of the first frame, in the middle of the image."""
    if zenith not in dataset.variables or azimuth not in dataset.variables:
        return None
    values = []
    for name in (zenith, azimuth):
        data = dataset[name]
        values.append(float(data.isel({dim: data.sizes[dim] // 2 if dim in ("y", "x") else 0 for dim in data.dims})))
    return None if any(map(math.isnan, values)) else (values[0], values[1])


def _camera_ground(dataset: xr.Dataset) -> Array:
    """Return metres east and north by column and row in the middle of the first frame; NaN if unknown."""
    unknown = np.full((2, 2), np.nan)
    names = ("pixel_longitude", "pixel_latitude")
    if any(name not in dataset.variables for name in names) or min(dataset.sizes["x"], dataset.sizes["y"]) < 2:
        return unknown
    row, column = dataset.sizes["y"] // 2, dataset.sizes["x"] // 2
    near = {"y": slice(row - 1, row + 1), "x": slice(column - 1, column + 1)}
    longitude, latitude = (
        np.radians(data.isel({"time": 0, **near} if "time" in data.dims else near).to_numpy())
        for data in (dataset[name] for name in names)
    )
    east = np.sin(longitude - longitude[0, 0]) * np.cos(latitude[0, 0])  # across the date line, too
    return EARTH_RADIUS_M * np.array(
        [[part[0, 1] - part[0, 0], part[1, 0] - part[0, 0]] for part in (east, latitude)], dtype=np.float64
    )
