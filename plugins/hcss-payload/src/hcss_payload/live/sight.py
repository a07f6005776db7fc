"""Lines of sight of live frames: nodes of the mesh in the plane of the scene, footprints, and the view of the axis."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from hcss_payload.camera import Camera
from hcss_payload.checks import PayloadError, require_within
from hcss_payload.live.kernels import node_places
from hcss_payload.live.plane import PlaneFit
from hcss_payload.mesh import Mesh
from hcss_payload.pose import Pose
from hcss_payload.rays import geographic, meet
from hcss_twin.physics.geodesy import Ellipsoid
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import Array, Sun, View

LARGEST_ZENITH_DEG = 75.0
"""Beyond, refraction matters and ground pixels are many times longer than wide."""

_STRAIGHT_DEG = 1e-6

_STEPS = (8, 4, 2)


@dataclass(frozen=True, eq=False)
class Sight:
    """Lines of sight of a camera onto the layer of clouds.

    Parameters
    ----------
    step : int
        Pixels between the nodes.
    """

    camera: Camera
    fit: PlaneFit
    step: int

    @cached_property
    def directions(self) -> Array:
        """Unit vectors (N, M, 3) of the nodes in the body; the last ones are beyond the detector."""
        rows, columns = (self.step * np.arange(-(-size // self.step) + 1, dtype=np.float64) for size in self.shape)
        return np.ascontiguousarray(self.camera.directions(rows[:, None], columns[None, :]))

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the detector."""
        return self.camera.rows, self.camera.columns

    def places(self, pose: Pose, out: Array | None = None, directions: Array | None = None) -> Array:
        """Return where nodes meet the layer, x and y (N, M, 2) in m in the plane of the scene.

        Raises
        ------
        PayloadError
            If some look beyond the limb or the region of the prepared pass.
        """
        directions = self.directions if directions is None else directions
        out = np.empty((*directions.shape[:2], 2)) if out is None else out
        fit = self.fit
        turn = Rotation.from_quat(pose.quaternion).as_matrix()
        missed = node_places(directions, turn, pose.position_m, fit.axes, fit.frame, fit.powers, fit.coefficients, out)
        if missed:
            raise PayloadError(
                f"pose: at time {pose.time_s:g} s {missed} of {directions[..., 0].size} lines of sight are beyond the "
                "limb or far from what the prepared pass sees; allowed: poses near those of the pass"
            )
        return out

    def footprint_m(self, pose: Pose) -> Array:
        """Return the footprint (2, 2) of the pixel on the axis, x and y of its sides along columns and rows."""
        row, column = self.camera.centre
        around = self.camera.directions(
            np.array([row - 0.5, row + 0.5])[:, None], np.array([column - 0.5, column + 0.5])
        )
        corners = self.places(pose, directions=np.ascontiguousarray(around))
        along = 0.5 * (corners[0, 1] - corners[0, 0] + corners[1, 1] - corners[1, 0])
        down = 0.5 * (corners[1, 0] - corners[0, 0] + corners[1, 1] - corners[0, 1])
        return np.stack((along, down))


def mesh_step(camera: Camera, poses: list[Pose], altitude_m: float) -> int:
    """Return the largest distance of nodes for which no pixel of some poses needs a ray of its own."""
    for step in _STEPS:
        if all(Mesh(camera, pose, altitude_m, step=step).exact_share == 0.0 for pose in poses):
            return step
    raise PayloadError(
        f"camera: lines of sight {_STEPS[-1]} pixels apart are too curved between each other; allowed: less "
        "distortion, and views farther from the limb"
    )


def seen_m(camera: Camera, pose: Pose, altitude_m: float) -> NDArray[np.float64]:
    """Return Earth-fixed positions (N, 3) along the border of the image, on the surface at an altitude."""
    rows, columns = (np.linspace(-0.5, size + 7.5, 9) for size in (camera.rows, camera.columns))
    directions = pose.to_earth(camera.directions(rows[:, None], columns[None, :]))
    met = meet(pose.position_m, directions, altitude_m).reshape(-1, 3)
    if np.isnan(met).any():
        raise PayloadError(
            f"camera: looks beyond the limb at time {pose.time_s:g} s; allowed: the Earth in every pixel"
        )
    return met


def view_of_axis(plan: Plan, camera: Camera, pose: Pose) -> View:
    """Return the direction toward the camera from the sea on its optical axis, in the plane of the scene."""
    row, column = camera.centre
    view, _ = view_and_sun(plan, camera, pose, row, column)
    return view


def view_and_sun(plan: Plan, camera: Camera, pose: Pose, row: float, column: float) -> tuple[View, Sun]:
    """Return the direction toward the camera from the sea in a place of the image, and the sun there, in the plane."""
    met = meet(pose.position_m, pose.to_earth(camera.directions(np.array(row), np.array(column))))
    if np.isnan(met).any():
        raise PayloadError(f"attitude: the optical axis misses the Earth at time {pose.time_s:g} s; allowed: the sea")
    latitude, longitude, _ = geographic(met)
    place = plan.scenario.place
    x, y = (
        coordinate[0]
        for coordinate in Ellipsoid.to_plane(latitude[None], longitude[None], place.latitude, place.longitude)
    )
    _, _, turn = Ellipsoid.to_geographic_with_turn(x, y, place.latitude, place.longitude)
    track = replace(plan.sun_track, latitude_deg=float(latitude), longitude_deg=float(longitude))
    there = track.at(pose.time_s)
    sun = replace(there, azimuth_deg=float((there.azimuth_deg - turn) % 360.0))
    ray = pose.position_m - met
    east, north, up = (float(axis @ ray) for axis in Ellipsoid.east_north_up(latitude, longitude))
    zenith = float(np.degrees(np.arctan2(np.hypot(east, north), up)))
    require_within(f"attitude: view zenith at time {pose.time_s:g} s", zenith, 0.0, LARGEST_ZENITH_DEG, "deg")
    if zenith < _STRAIGHT_DEG:  # where rounding decides over the azimuth
        return View(0.0, 0.0), sun
    return View(zenith, float((np.degrees(np.arctan2(east, north)) - turn) % 360.0)), sun
