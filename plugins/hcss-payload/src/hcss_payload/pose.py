"""Pose: where the body is and how it is turned."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from hcss_payload.attitude import Attitude
from hcss_payload.checks import finite, unit_quaternion
from hcss_payload.jitter import Jitter
from hcss_payload.trajectory import Trajectory
from hcss_twin.core.arguments import checked
from hcss_twin.providers import Array


@dataclass(frozen=True, eq=False)
class Pose:
    """Position and orientation of the body at a time.

    Parameters
    ----------
    time_s : float
        After the start.
    position_m : array_like (3,)
        Earth-fixed.
    quaternion : array_like (4,)
        From the body to the Earth-fixed frame, x, y, z, w.
    """

    time_s: float
    position_m: Array
    quaternion: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "position_m", finite("pose.position_m", self.position_m, 3))
        object.__setattr__(self, "quaternion", unit_quaternion("pose.quaternion", self.quaternion))

    @property
    def rotation(self) -> Rotation:
        """Turns vectors of the body into Earth-fixed ones."""
        return Rotation.from_quat(self.quaternion)

    def to_earth(self, direction: Array) -> Array:
        """Return directions (..., 3) of the body in the Earth-fixed frame."""
        turned: Array = self.rotation.apply(direction.reshape(-1, 3)).reshape(direction.shape)
        return turned

    def to_body(self, direction: Array) -> Array:
        """Return Earth-fixed directions (..., 3) in the body."""
        turned: Array = self.rotation.apply(np.reshape(direction, (-1, 3)), inverse=True).reshape(direction.shape)
        return turned


@checked
def pose_at(time_s: float, trajectory: Trajectory, attitude: Attitude, jitter: Jitter | None = None) -> Pose:
    """Return the pose at a time, with the turns of the jitter around the axes of the body."""
    turn = Rotation.from_quat(attitude.at(time_s))
    if jitter is not None:
        turn = turn * Rotation.from_rotvec(jitter.at(time_s))
    return Pose(time_s, trajectory.at(time_s), turn.as_quat())
