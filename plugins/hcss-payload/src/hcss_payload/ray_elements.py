"""Elements of the scene as a camera sees them: projected through its pose, with the area of each pixel."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from hcss_payload.pose import Pose
from hcss_payload.ray_geometry import FrameGeometry
from hcss_payload.shutter import LinePoses, PoseAt, Shutter
from hcss_twin.core.arrays import Array
from hcss_twin.engine.elements import Clouds, ElementStage, InstantElements
from hcss_twin.physics.geodesy import east_north_up, to_earth_centred, to_geographic
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import ElementPoint

_NOWHERE = -1e9
"""Row and column of what the camera does not see."""

_LINE_STEPS = 4
"""Steps to the line that sees an element; each reduces the error by the ratio of image motion to the speed of lines."""

_STEPS_PER_PIXEL = 8
"""Instants of the integration time for each pixel by which a small element moves."""

_RATE_S = 1e-3
"""Time over which the motion of elements through the image is measured, around the instant."""

GeometryAt = Callable[[float], FrameGeometry]
CloudsAt = Callable[[float], Clouds]


class RayElementStage(ElementStage):
    """Elements of a scene with a camera.

    Parameters
    ----------
    clouds_at : callable
        Clouds of the middle of the integration time of a frame.
    """

    def __init__(
        self, plan: Plan, geometry_at: GeometryAt, clouds_at: CloudsAt, shutter: Shutter, pose_at: PoseAt
    ) -> None:
        super().__init__(plan)
        self._geometry_at, self._clouds_at, self._shutter, self._pose_at = geometry_at, clouds_at, shutter, pose_at

    def at(self, index: int, time_s: float, clouds: Clouds, look_up: Any) -> InstantElements:
        """Return the elements of a part of a frame."""
        if self._shutter.instants > 1:
            clouds = self._clouds_at(time_s)
        elements = RayElements(self._plan, self._paths, None, index, time_s, clouds, look_up)
        elements.geometry, elements.shutter, elements.pose_at = self._geometry_at(time_s), self._shutter, self._pose_at
        return elements


class RayElements(InstantElements):
    """Elements of a part of one frame of a camera.

    Attributes
    ----------
    geometry : FrameGeometry
        Of the frame.
    shutter : Shutter
    pose_at : callable
        Pose at a time.
    """

    geometry: FrameGeometry
    shutter: Shutter
    pose_at: PoseAt

    def project(self, x_m: Array, y_m: Array, altitude_m: Array) -> tuple[Array, Array]:
        """Return the row and column of points; pixel n extends from n to n + 1."""
        return self._pixels(self.geometry.pose, self.geometry.mesh.lines, x_m, y_m, altitude_m)

    def _project_at(self, later_s: float, x_m: Array, y_m: Array, altitude_m: Array) -> tuple[Array, Array]:
        time_s = self._time_s + later_s
        lines = self.shutter.lines(time_s, self.geometry.camera, self.pose_at)
        return self._pixels(self.pose_at(time_s), lines, x_m, y_m, altitude_m)

    def _seen(self, point: ElementPoint) -> tuple[Array, Array, tuple[float, float]] | None:
        camera, (row, column) = self.geometry.camera, self._at(point, 0.0)
        half = 0.5 * (self.shutter.integration_s or _RATE_S)
        if not (-camera.rows < row < 2 * camera.rows and -camera.columns < column < 2 * camera.columns):
            return None
        (row_0, column_0), (row_1, column_1) = (self._at(point, later) for later in (-half, half))
        if self.shutter.integration_s == 0.0:
            rate = (row_1 - row_0) / _RATE_S, (column_1 - column_0) / _RATE_S
            return np.array([row]), np.array([column]), rate
        moved = math.hypot(row_1 - row_0, column_1 - column_0)
        count = max(self.shutter.instants, math.ceil(_STEPS_PER_PIXEL * moved))
        places = [self._at(point, later) for later in replace(self.shutter, instants=count).times_s(0.0)]
        rows, columns = (np.array(each) for each in zip(*places, strict=True))
        return rows, columns, (0.0, 0.0)

    def _pixels(
        self, pose: Pose, lines: LinePoses | None, x_m: Array, y_m: Array, altitude_m: Array
    ) -> tuple[Array, Array]:
        """Return the row and column of points from a pose."""
        camera, (position, up) = self.geometry.camera, self._position_m(x_m, y_m, altitude_m)
        away = position - pose.position_m
        row, column = camera.pixels(pose.to_body(away))
        for _ in range(_LINE_STEPS):  # the row decides over the pose, and this over the row
            if lines is None:
                break
            turn, origin = lines.at(row)
            away = position - origin
            row, column = camera.pixels(np.einsum("...ji,...j->...i", turn, away))
        hidden = np.sum(away * up, axis=-1) >= 0.0  # below the horizon
        nowhere = hidden | np.isnan(row)
        return np.where(nowhere, _NOWHERE, row + 0.5), np.where(nowhere, _NOWHERE, column + 0.5)

    def _position_m(self, x_m: Array, y_m: Array, altitude_m: Array) -> tuple[Array, Array]:
        """Return Earth-fixed positions and vertical directions (..., 3) of points."""
        place = self._plan.scenario.place
        latitude, longitude = to_geographic(x_m, y_m, place.latitude, place.longitude)
        up = east_north_up(latitude, longitude)[2]
        return to_earth_centred(latitude, longitude) + np.asarray(altitude_m)[..., None] * up, up

    def _area_m2(self, row: float, column: float, point: ElementPoint | None = None) -> float:
        camera, at = self.geometry.camera, (np.float64(row - 0.5), np.float64(column - 0.5))
        ray = camera.directions(*at)  # type: ignore[arg-type]
        axis = camera.directions(*(np.float64(each) for each in camera.centre))  # type: ignore[arg-type]
        if point is None:
            seen = self.geometry.exact(*at).position_m  # type: ignore[arg-type]
        else:
            seen = self._position_m(*(np.array(each) for each in (point.x_m, point.y_m, point.altitude_m)))[0]
        distance = float(np.linalg.norm(self.geometry.pose.position_m - seen))
        # A detector sees the solid angle pitch^2 cos^3 / focal length^2.
        return distance**2 * camera.pixel_rad**2 * float(ray @ axis) ** 3

    def _zenith_deg(self, row: int, column: int) -> float:
        toward = self.geometry.exact(np.float64(row), np.float64(column)).toward  # type: ignore[arg-type]
        return float(np.degrees(np.arctan2(np.hypot(toward[0], toward[1]), toward[2])))
