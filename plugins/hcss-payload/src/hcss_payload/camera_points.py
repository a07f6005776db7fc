"""Where the rays of a frame meet a height above the sea, in the plane of the scene."""

from __future__ import annotations

import numpy as np

from hcss_payload.camera import Camera
from hcss_payload.mesh import STEP, Mesh, MeshValues
from hcss_payload.scene_plane import surface_place, to_scene
from hcss_payload.shutter import Exposure
from hcss_twin.providers import Array

Window = tuple[slice, slice]
"""Ranges of rows and columns, in pixels."""


class CameraPoints:
    """Where the points of a frame meet a height.

    Parameters
    ----------
    exposure : Exposure
        The instants of the frame.
    centre : (float, float)
        Latitude and longitude of the centre of the scene.
    per_pixel : int
        Points of the frame along each side of a pixel.
    """

    def __init__(
        self, camera: Camera, exposure: Exposure, centre: tuple[float, float], altitude_m: float, per_pixel: int
    ) -> None:
        def in_plane(position_m: Array) -> Array:
            # Below a point at some altitude lies the place with its geodetic latitude.
            x, y, _ = to_scene(*surface_place(position_m, altitude_m), centre)
            return np.stack((x, y), axis=-1)

        self._instants = [
            MeshValues(Mesh(camera, pose, altitude_m, per_pixel, STEP * per_pixel, lines=lines), in_plane)
            for pose, lines in exposure.instants
        ]
        self._which = exposure.shutter.which(per_pixel) if len(self._instants) > 1 else None
        self._per_pixel = per_pixel
        self._last: tuple[Window, tuple[Array, Array]] | None = None

    def window(self, window: Window) -> tuple[Array, Array]:
        """Return x and y (y, x) of the points of a window of pixels; the last one is kept."""
        if self._last is None or self._last[0] != window:
            self._last = None  # one window at a time in memory
            self._last = window, self._window(window)
        return self._last[1]

    def _window(self, window: Window) -> tuple[Array, Array]:
        per = self._per_pixel
        points = [slice(pixels.start * per, pixels.stop * per) for pixels in window]
        places = self._instants[0].window(*points)
        if self._which is not None:
            for number, instant in enumerate(self._instants[1:], start=1):
                of_instant = instant.window(*points)
                for y, x in np.argwhere(self._which == number):
                    places[y::per, x::per] = of_instant[y::per, x::per]
        return np.ascontiguousarray(places[..., 0]), np.ascontiguousarray(places[..., 1])

    def at_nodes(self) -> tuple[Array, Array]:
        """Return x and y (N,) that the nodes of the meshes see."""
        places = np.concatenate([instant.at_nodes.reshape(-1, 2) for instant in self._instants])
        return places[:, 0], places[:, 1]
