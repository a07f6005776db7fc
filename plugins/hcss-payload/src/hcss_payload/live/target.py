"""A plume in live frames: its light through air and clouds, and its place in the image."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcss_payload.camera import Camera
from hcss_payload.checks import PayloadError, require_within
from hcss_payload.live.octaves import shape_of
from hcss_payload.pose import Pose
from hcss_payload.rays import meet
from hcss_twin.engine.stages.element_paths import ElementPaths
from hcss_twin.models.clouds.fractal.generator import FractalClouds
from hcss_twin.physics.geodesy import Ellipsoid
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import Array, View

FieldAt = Callable[[Array], float]

_VALUES, _REACH = 256, 7.0
"""Values of the field above the edge of clouds for which transmission is tabulated, and their range."""

_INSIDE, _ALTITUDES, _LOWEST_M, TOP_M = 9, 16, 250.0, 100e3
"""Altitudes within the cloud and in all at which the light of targets is prepared, and the limits of these, m."""

_TOUCH_M = 100.0
"""Distance by which the surface must be in front of a target to hide it; a ship is on it."""


@dataclass(frozen=True)
class PointTarget:
    """A plume smaller than a pixel, which hides nothing.

    Parameters
    ----------
    latitude_deg, longitude_deg, altitude_m : float
        Where it is at the start.
    intensity : tuple of float (B,)
        Radiant intensity in each band, W sr-1.
    velocity_m_s : (float, float, float)
        Toward east, north and up at the start; it moves straight on in the Earth-fixed frame.
    temperature_K : float, optional
        Colour of its light in a band, that of a black body; by default none.
    """

    latitude_deg: float
    longitude_deg: float
    altitude_m: float
    intensity: tuple[float, ...]
    velocity_m_s: tuple[float, float, float] = (0.0, 0.0, 0.0)
    temperature_K: float | None = None

    def __post_init__(self) -> None:
        require_within("target.latitude_deg", self.latitude_deg, -90.0, 90.0, "deg")
        require_within("target.longitude_deg", self.longitude_deg, -360.0, 360.0, "deg")
        require_within("target.altitude_m", self.altitude_m, 0.0, 100e3, "m")
        for value in self.intensity:
            require_within("target.intensity", value, 0.0, 1e12, "W sr-1")

    def values(self, bands: int) -> list[float]:
        """Return what a letter holds of the target: place, velocity and intensities.

        Raises
        ------
        PayloadError
            If it has a temperature, which letters do not hold, or another number of bands.
        """
        if self.temperature_K is not None:
            raise PayloadError(f"target.temperature_K: {self.temperature_K:g} K; allowed: none for a server's targets")
        self.require_bands(bands)
        return [self.latitude_deg, self.longitude_deg, self.altitude_m, *self.velocity_m_s, *self.intensity]

    def require_bands(self, bands: int) -> None:
        """Raise a :class:`PayloadError` if it has another number of bands."""
        if len(self.intensity) != bands:
            raise PayloadError(f"target.intensity: {len(self.intensity)} values; allowed: {bands}, one a band")

    @classmethod
    def of_values(cls, values: Sequence[float]) -> PointTarget:
        """Return the target of a letter."""
        latitude, longitude, altitude, east, north, up, *intensity = values
        return cls(latitude, longitude, altitude, tuple(intensity), (east, north, up))

    def position_m(self, time_s: float) -> Array:
        """Return the Earth-fixed position at a time."""
        latitude, longitude = np.float64(self.latitude_deg), np.float64(self.longitude_deg)
        start = Ellipsoid.to_earth_centred(latitude, longitude, self.altitude_m)  # type: ignore[arg-type]
        toward = np.stack(Ellipsoid.east_north_up(latitude, longitude))  # type: ignore[arg-type]
        position: Array = start + time_s * (np.array(self.velocity_m_s) @ toward)
        return position


@dataclass(frozen=True)
class SeenTarget:
    """A target in an image.

    Attributes
    ----------
    row, column : float
        Its place; centres of pixels are whole numbers.
    light : ndarray (B,)
        Radiance of a pixel that gets all of its light.
    """

    row: float
    column: float
    light: Array

    def add(self, radiance: NDArray[np.float32]) -> None:
        """Add it to the pixels (B, rows, columns) around it, like a source as wide as a pixel."""
        rows, columns = radiance.shape[1:]
        y, x = math.floor(self.row), math.floor(self.column)
        for i, down in ((y, y + 1 - self.row), (y + 1, self.row - y)):
            for j, along in ((x, x + 1 - self.column), (x + 1, self.column - x)):
                if 0 <= i < rows and 0 <= j < columns:
                    radiance[:, i, j] += (down * along * self.light).astype(np.float32)


class TargetLight:
    """The light of targets that arrives along a pass.

    Parameters
    ----------
    views : sequence of (float, View)
        Times of the pass and the views of its optical axis.
    edge : float
        Value of the field at the edges of clouds.
    """

    def __init__(self, plan: Plan, camera: Camera, views: Sequence[tuple[float, View]], edge: float) -> None:
        self._plan, self._paths, self._camera, self._edge = plan, ElementPaths(plan), camera, edge
        self._has_gaps = plan.layers[0].coverage < 1.0
        self._field = edge + np.linspace(0.0 if self._has_gaps else -_REACH, _REACH, _VALUES)
        self._times = np.array([time for time, _ in views])
        self._zeniths_deg = [view.zenith_deg for _, view in views]
        self._own: dict[tuple[float, float | None], Array] = {}
        self._nodes_m, self._tables = np.zeros(0), np.zeros(0)

    def prepare(self, target: PointTarget) -> None:
        """Compute the light of targets like one, at its altitude and of its colour."""
        target.require_bands(len(self._plan.bands))
        key = target.altitude_m, target.temperature_K
        if key not in self._own:
            self._own[key] = self._along(*key)

    def prepare_up_to(self, highest_m: float) -> None:
        """Compute the light of targets without colour at any altitude up to one, between which it is linear."""
        layer = self._plan.layers[0]
        inside = np.linspace(layer.base_m, layer.top_m, _INSIDE)
        nodes = np.concatenate(([0.0, highest_m], inside, np.geomspace(_LOWEST_M, TOP_M, _ALTITUDES)))
        self._nodes_m = np.unique(nodes[nodes <= highest_m])
        self._tables = np.stack([self._along(float(altitude), None) for altitude in self._nodes_m])

    def _along(self, altitude_m: float, temperature_K: float | None) -> Array:
        """Return the shares (T, 1 + N, B) along the pass."""
        return np.stack([self._shares(zenith, altitude_m, temperature_K) for zenith in self._zeniths_deg])

    def _arriving(self, target: PointTarget) -> Array:
        """Return the shares (T, 1 + N, B) of a target."""
        target.require_bands(len(self._plan.bands))
        arriving = self._own.get((target.altitude_m, target.temperature_K))
        if arriving is not None:
            return arriving
        highest = float(self._nodes_m[-1]) if self._nodes_m.size else 0.0
        if target.temperature_K is not None or not (self._nodes_m.size and target.altitude_m <= highest):
            raise PayloadError(
                f"targets: altitude {target.altitude_m:g} m, temperature {target.temperature_K} are not prepared; "
                f"allowed: altitudes up to {highest:g} m (highest_target_m) without temperature, or those of targets "
                "that are"
            )
        after = max(1, int(np.searchsorted(self._nodes_m, target.altitude_m)))
        low, high = self._nodes_m[after - 1], self._nodes_m[after]
        later = (target.altitude_m - low) / (high - low)
        between: Array = (1.0 - later) * self._tables[after - 1] + later * self._tables[after]
        return between

    def seen(self, target: PointTarget, time_s: float, pose: Pose, field_at: FieldAt) -> SeenTarget | None:
        """Return a target in the image of a pose; None if it is not within a pixel of it.

        Parameters
        ----------
        field_at : callable
            The field that a direction (3,) of the body meets.
        """
        ray = target.position_m(time_s) - pose.position_m
        distance = float(np.linalg.norm(ray))
        toward = pose.to_body(ray / distance)
        row, column = self.pixel_of(target, time_s, pose)
        if not (-1.0 < row < self._camera.rows and -1.0 < column < self._camera.columns):
            return None
        if self._is_hidden(pose, ray, distance):
            return None
        share = self._share(self._arriving(target), time_s, field_at(toward))
        # The solid angle of a pixel falls with the third power of the cosine of its distance from the axis.
        across = self._camera.directions(*(np.array(coordinate) for coordinate in (row, column)))
        axis = self._camera.directions(*(np.array(coordinate) for coordinate in self._camera.centre))
        solid_angle = self._camera.pixel_rad**2 * float(across @ axis) ** 3
        return SeenTarget(row, column, share * np.array(target.intensity) / (distance**2 * solid_angle))

    def pixel_of(self, target: PointTarget, time_s: float, pose: Pose) -> tuple[float, float]:
        """Return the row and column of a target from a pose, centres of pixels being whole numbers."""
        row, column = self._camera.pixels(pose.to_body(target.position_m(time_s) - pose.position_m))
        return float(row), float(column)

    def _share(self, along: Array, time_s: float, field: float) -> Array:
        """Return the share (B,) of the light that arrives through the cloud of a value of the field."""
        position = float(np.interp(time_s, self._times, np.arange(self._times.size)))
        before = min(int(position), max(0, self._times.size - 2))
        after = min(before + 1, self._times.size - 1)
        table = along[before] + (position - before) * (along[after] - along[before])
        if self._has_gaps and field < self._edge:
            clear: Array = table[0]
            return clear
        share: Array = np.array([np.interp(field, self._field, curve) for curve in table[1:].T])
        return share

    def _shares(self, zenith_deg: float, altitude: float, temperature_K: float | None) -> Array:
        """Return the shares (1 + N, B) in the clear, and at the values of the field."""
        paths, layer = self._paths, self._plan.layers[0]
        exponent = shape_of(self._plan).brightness_exponent
        thickness = FractalClouds.field_thickness(self._field[None].astype(np.float32), layer, exponent, in_place=True)[
            0
        ]
        thickness[0] = max(thickness[0], np.float32(layer.thickness_min_m))
        air = paths.air(altitude, zenith_deg)
        heights = paths.heights_above([thickness], altitude)
        clouds = [paths.through_cloud(heights[:, n : n + 1], zenith_deg) for n in range(thickness.size)]
        arriving = [air, *(air * cloud for cloud in clouds)]
        return np.stack([paths.band_mean(radiance, temperature_K) for radiance in arriving])

    def _is_hidden(self, pose: Pose, ray: Array, distance: float) -> bool:
        """Return whether the Earth is in front of the target."""
        met = meet(pose.position_m, ray / distance)
        return bool(np.linalg.norm(met - pose.position_m) < distance - _TOUCH_M)
