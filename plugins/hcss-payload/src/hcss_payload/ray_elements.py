"""Elements of the scene as a camera sees them: projected through its pose, with the area of each pixel."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from hcss_payload.ray_geometry import FrameGeometry
from hcss_twin.core.arrays import Array
from hcss_twin.engine.elements import Clouds, ElementStage, InstantElements
from hcss_twin.physics.geodesy import east_north_up, to_earth_centred, to_geographic
from hcss_twin.plan.plan import Plan

_NOWHERE = -1e9
"""Row and column of what the camera does not see."""

_LINE_STEPS = 4
"""Steps to the line that sees an element; each reduces the error by the ratio of image motion to the speed of lines."""

GeometryAt = Callable[[float], FrameGeometry]


class RayElementStage(ElementStage):
    """Elements of a scene with a camera."""

    def __init__(self, plan: Plan, geometry_at: GeometryAt) -> None:
        super().__init__(plan)
        self._geometry_at = geometry_at

    def at(self, index: int, time_s: float, clouds: Clouds, look_up: Any) -> InstantElements:
        """Return the elements of a part of a frame."""
        elements = RayElements(self._plan, self._paths, None, index, time_s, clouds, look_up)
        elements.geometry = self._geometry_at(time_s)
        return elements


class RayElements(InstantElements):
    """Elements of a part of one frame of a camera.

    Attributes
    ----------
    geometry : FrameGeometry
        Of the frame.
    """

    geometry: FrameGeometry

    def project(self, x_m: Array, y_m: Array, altitude_m: Array) -> tuple[Array, Array]:
        """Return the row and column of points; pixel n extends from n to n + 1."""
        place, pose = self._plan.scenario.place, self.geometry.pose
        latitude, longitude = to_geographic(x_m, y_m, place.latitude, place.longitude)
        up = east_north_up(latitude, longitude)[2]
        position = to_earth_centred(latitude, longitude) + np.asarray(altitude_m)[..., None] * up
        away = position - pose.position_m
        row, column = self.geometry.camera.pixels(pose.to_body(away))
        lines = self.geometry.mesh.lines
        for _ in range(_LINE_STEPS):  # the row decides over the pose, and this over the row
            if lines is None:
                break
            turn, origin = lines.at(row)
            away = position - origin
            row, column = self.geometry.camera.pixels(np.einsum("...ji,...j->...i", turn, away))
        hidden = np.sum(away * up, axis=-1) >= 0.0  # below the horizon
        nowhere = hidden | np.isnan(row)
        return np.where(nowhere, _NOWHERE, row + 0.5), np.where(nowhere, _NOWHERE, column + 0.5)

    def _area_m2(self, row: int, column: int) -> float:
        camera = self.geometry.camera
        at = np.float64(row), np.float64(column)
        rays = self.geometry.exact(*at)  # type: ignore[arg-type]
        ray = camera.directions(*at)  # type: ignore[arg-type]
        axis = camera.directions(*(np.float64(each) for each in camera.centre))  # type: ignore[arg-type]
        distance = float(np.linalg.norm(self.geometry.pose.position_m - rays.position_m))
        # A detector sees the solid angle pitch^2 cos^3 / focal length^2.
        return distance**2 * camera.pixel_rad**2 * float(ray @ axis) ** 3

    def _zenith_deg(self, row: int, column: int) -> float:
        toward = self.geometry.exact(np.float64(row), np.float64(column)).toward  # type: ignore[arg-type]
        return float(np.degrees(np.arctan2(np.hypot(toward[0], toward[1]), toward[2])))
