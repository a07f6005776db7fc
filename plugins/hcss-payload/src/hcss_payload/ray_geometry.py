"""Geometry of a frame: where each pixel sees the Earth, and the direction from there to the camera."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcss_payload.camera import Camera
from hcss_payload.earth import ECCENTRICITY_SQUARED
from hcss_payload.mesh import Mesh, MeshValues
from hcss_payload.pose import Pose
from hcss_payload.rays import meet
from hcss_payload.scene_plane import surface_place, toward_camera
from hcss_payload.shutter import LinePoses
from hcss_twin.core.kernels import kernel
from hcss_twin.providers import Array

LARGEST_ZENITH_DEG, LARGEST_WITH_LIMB_DEG = 75.0, 85.0
"""Beyond, refraction matters and ground pixels are many times longer than wide; the second where the limb is shown."""

ATMOSPHERE_M = 100e3
"""Altitude above which rays see space."""

GROUND, SLANT, LIMB, SPACE = range(4)
"""Kinds of pixels: of the ground up to the largest zenith, beyond it, of the atmosphere at the limb, and of space."""


@dataclass(frozen=True, eq=False)
class PixelRays:
    """Lines of sight of a window of pixels (y, x); NaN where they miss the ground.

    Attributes
    ----------
    position_m : ndarray (y, x, 3)
        Where the pixels see the ellipsoid, Earth-fixed.
    toward : ndarray (y, x, 3)
        Direction to the camera along the axes of the scene's plane.
    kind : ndarray of uint8 (y, x)
    """

    position_m: Array
    toward: Array
    kind: NDArray[np.uint8]


class FrameGeometry:
    """Lines of sight of a camera at a pose.

    Parameters
    ----------
    centre : (float, float)
        Latitude and longitude of the centre of the scene's plane.
    lines : LinePoses, optional
        Poses of the lines, if they differ; directions to the camera are those to its place at the time of the frame.
    largest_deg : float
        View zenith up to which pixels are of the ground.
    """

    def __init__(
        self,
        camera: Camera,
        pose: Pose,
        centre: tuple[float, float],
        lines: LinePoses | None = None,
        largest_deg: float = LARGEST_ZENITH_DEG,
    ) -> None:
        self._steepest = np.tan(np.radians(largest_deg))
        self.camera, self.pose, self._centre = camera, pose, centre
        self.mesh = Mesh(camera, pose, lines=lines)
        self._values = MeshValues(self.mesh, self._of)
        self._last: tuple[tuple[int, ...], PixelRays] | None = None

    def window(self, rows: slice, columns: slice) -> PixelRays:
        """Return the lines of sight of a window of pixels; the last one is kept."""
        key = rows.start, rows.stop, columns.start, columns.stop
        if self._last is None or self._last[0] != key:
            values = self._values.window(rows, columns)
            row, column = (np.arange(span.start, span.stop, dtype=np.float64) for span in (rows, columns))
            self._last = key, self._rays(values, row[:, None], column[None, :])
        return self._last[1]

    def exact(self, row: Array, column: Array) -> PixelRays:
        """Return the exact lines of sight of points (...) of the image."""
        position = self.mesh.exact_m(row, column)
        values = np.full((*position.shape[:-1], 6), np.nan)
        met = ~np.isnan(position[..., 0])
        values[met] = self._of(position[met])
        return self._rays(values, row, column)

    def nodes(self) -> tuple[Array, Array]:
        """Return the directions to the camera, and positions, (N, 3) of the nodes of the mesh that see the ground."""
        values = self._values.at_nodes.reshape(-1, 6)
        values = values[~np.isnan(values[:, 3])]
        return values[:, 3:], values[:, :3]

    @property
    def sees_limb(self) -> bool:
        """Whether rays of the mesh miss the ground; those of the corners are among them."""
        return bool(np.isnan(self._values.at_nodes[..., 3]).any())

    def angles_deg(self, rays: PixelRays) -> tuple[Array, Array]:
        """Return zenith and azimuth (clockwise from north) of the camera."""
        shape = rays.position_m.shape[:-1]
        zenith, azimuth = np.empty(shape), np.empty(shape)
        _angles(rays.position_m.reshape(-1, 3), self.pose.position_m, zenith.reshape(-1), azimuth.reshape(-1))
        return zenith, azimuth

    def _of(self, position_m: Array) -> Array:
        return np.concatenate((position_m, toward_camera(position_m, self.pose.position_m, self._centre)), axis=-1)

    def _rays(self, values: Array, row: Array, column: Array) -> PixelRays:
        position, toward = values[..., :3], values[..., 3:]
        with np.errstate(invalid="ignore"):
            steep = np.hypot(toward[..., 0], toward[..., 1]) > self._steepest * toward[..., 2]
        missed = np.isnan(position[..., 0])
        # Places too far from the scene for its plane have no direction.
        kind = np.where(steep | np.isnan(toward[..., 0]), SLANT, GROUND).astype(np.uint8)
        if missed.any():
            at_row, at_column = (np.broadcast_to(numbers, missed.shape)[missed] for numbers in (row, column))
            above = np.isnan(meet(*self.mesh.rays(at_row, at_column), ATMOSPHERE_M)[..., 0])
            kind[missed] = np.where(above, SPACE, LIMB)
        return PixelRays(position, toward, kind)

    def latitude_longitude(self, rays: PixelRays) -> tuple[Array, Array]:
        """Return latitude and longitude (deg), within 180 of the scene's centre."""
        latitude, longitude = surface_place(rays.position_m)
        middle = self._centre[1]
        return latitude, middle + (longitude - middle + 180.0) % 360.0 - 180.0


@kernel()
def _angles(position_m, camera_m, zenith, azimuth):  # type: ignore[no-untyped-def]
    """Write zenith and azimuth (N,), in degrees, of a camera (3,) at positions (N, 3) on the ellipsoid."""
    for n in range(zenith.size):
        x, y, z = position_m[n, 0], position_m[n, 1], position_m[n, 2]
        ray_x, ray_y, ray_z = camera_m[0] - x, camera_m[1] - y, camera_m[2] - z
        up_z = z / (1.0 - ECCENTRICITY_SQUARED)
        size = np.sqrt(x * x + y * y + up_z * up_z)
        up_x, up_y, up_z = x / size, y / size, up_z / size
        across = max(np.hypot(x, y), 1e-9)  # at a pole, the meridian of Greenwich is north
        east = (ray_y * x - ray_x * y) / across
        height = ray_x * up_x + ray_y * up_y + ray_z * up_z
        flat_x, flat_y, flat_z = ray_x - height * up_x, ray_y - height * up_y, ray_z - height * up_z
        north = (flat_z * across - (flat_x * x + flat_y * y) / across * z) / np.hypot(across, z)
        # The axis toward north lies in the meridian: its component here is that of the horizontal part.
        flat = flat_x * flat_x + flat_y * flat_y + flat_z * flat_z
        ahead = np.copysign(np.sqrt(max(flat - east * east, 0.0)), north)
        zenith[n] = np.degrees(np.arctan2(np.hypot(east, ahead), height))
        azimuth[n] = np.degrees(np.arctan2(east, ahead)) % 360.0
