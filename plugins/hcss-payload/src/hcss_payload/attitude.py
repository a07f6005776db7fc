"""Attitudes: where the body points at any time.

The nominal body looks along +z; +x points right and +y down in its image.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from hcss_payload.checks import PayloadError, ascending, require_inside, require_within, unit_quaternion
from hcss_payload.rays import geographic
from hcss_payload.trajectory import Trajectory, velocity_m_s
from hcss_twin.physics.geodesy import Ellipsoid
from hcss_twin.providers import Array

_AXIS = np.array([0.0, 0.0, 1.0])
_PARALLEL = 1e-9
"""Sine of the angle below which a direction says nothing about the turn around another."""


class Attitude(Protocol):
    """Orientation of the body."""

    def at(self, time_s: float) -> Array:
        """Return the quaternion (4,), x, y, z, w, that turns vectors of the body into Earth-fixed ones."""
        ...


def looking(direction: Array, up: Array) -> Array:
    """Return the quaternion (4,) of a body that looks along a direction (3,), with ``up`` (3,) up in its image.

    If both are parallel, as above a pole with north up, the meridian of Greenwich is up.
    """
    ahead = direction / np.linalg.norm(direction)
    right = np.cross(ahead, up / np.linalg.norm(up))
    if np.linalg.norm(right) < _PARALLEL:
        right = np.cross(ahead, np.array([1.0, 0.0, 0.0]))
    right /= np.linalg.norm(right)
    matrix = np.stack((right, np.cross(ahead, right), ahead), axis=1)
    quaternion: Array = Rotation.from_matrix(matrix).as_quat()
    return quaternion


@dataclass(frozen=True)
class Nadir:
    """Toward the point below, along the normal of the ellipsoid, with north up.

    Parameters
    ----------
    trajectory : Trajectory
        Of the body.
    """

    trajectory: Trajectory

    def at(self, time_s: float) -> Array:
        """Return the quaternion."""
        return looking(-_normal(self.trajectory.at(time_s)), _AXIS)


@dataclass(frozen=True)
class Track:
    """Toward a fixed place on or above the Earth, with its north up: its meridian is vertical in the image.

    The Earth's axis, of which oblique views show the part toward the zenith, too, would turn the image by up to 180
    degrees during a pass.

    Parameters
    ----------
    trajectory : Trajectory
        Of the body.
    latitude_deg, longitude_deg, altitude_m : float
        The place.
    """

    trajectory: Trajectory
    latitude_deg: float
    longitude_deg: float
    altitude_m: float = 0.0

    def __post_init__(self) -> None:
        require_within("attitude.latitude_deg", self.latitude_deg, -90.0, 90.0, "deg")
        require_within("attitude.longitude_deg", self.longitude_deg, -180.0, 360.0, "deg")
        require_within("attitude.altitude_m", self.altitude_m, -500.0, 1e5, "m")

    @property
    def target_m(self) -> Array:
        """Position (3,) of the place."""
        position_deg = np.float64(self.latitude_deg), np.float64(self.longitude_deg)
        return Ellipsoid.to_earth_centred(*position_deg, self.altitude_m)  # type: ignore[arg-type]

    def at(self, time_s: float) -> Array:
        """Return the quaternion; a place below the horizon is an error."""
        away = self.target_m - self.trajectory.at(time_s)
        if away @ _normal(self.target_m) > 0.0:
            raise PayloadError(
                f"attitude: the place {self.latitude_deg:g} N {self.longitude_deg:g} E is below the horizon at time "
                f"{time_s:g} s; allowed: times when the camera is above it"
            )
        north = Ellipsoid.east_north_up(np.float64(self.latitude_deg), np.float64(self.longitude_deg))[1]  # type: ignore[arg-type]
        return looking(away, north)


@dataclass(frozen=True)
class PushBroom:
    """Toward the ground, with the motion over the rotating Earth up: lines lie across the track (yaw steering).

    Parameters
    ----------
    trajectory : Trajectory
        Of the body.
    roll_deg : float
        Turn around the direction of motion; positive looks to the right.
    pitch_deg : float
        Turn toward the direction of motion.
    """

    trajectory: Trajectory
    roll_deg: float = 0.0
    pitch_deg: float = 0.0

    def __post_init__(self) -> None:
        require_within("attitude.roll_deg", self.roll_deg, -180.0, 180.0, "deg")
        require_within("attitude.pitch_deg", self.pitch_deg, -180.0, 180.0, "deg")

    def at(self, time_s: float) -> Array:
        """Return the quaternion; a body that does not move over the ground is an error."""
        position = self.trajectory.at(time_s)
        motion = velocity_m_s(self.trajectory, time_s)
        if np.linalg.norm(motion) < 1.0:
            raise PayloadError("attitude: push-broom without motion over the ground; allowed: Nadir or Track")
        level = Rotation.from_quat(looking(-_normal(position), motion))
        # In the body x is right and -y ahead: a turn around +y by the roll moves z toward x, one around x toward -y.
        turn = Rotation.from_euler("YX", [self.roll_deg, self.pitch_deg], degrees=True)
        quaternion: Array = (level * turn).as_quat()
        return quaternion


@dataclass(frozen=True, eq=False)
class AttitudeTable:
    """Quaternions at given times, with the shorter turn at constant rate between them.

    Parameters
    ----------
    times_s : array_like (N,)
        Seconds after the start, ascending.
    quaternions : array_like (N, 4)
        From the body to the Earth-fixed frame, x, y, z, w; either sign.
    """

    times_s: Array
    quaternions: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "times_s", ascending("attitude.times_s", self.times_s))
        turns = unit_quaternion("attitude.quaternions", self.quaternions, len(self.times_s))
        object.__setattr__(self, "quaternions", turns)

    def at(self, time_s: float) -> Array:
        """Return the quaternion; a time outside the table is an error."""
        require_inside("attitude", time_s, self.times_s)
        first = int(np.clip(np.searchsorted(self.times_s, time_s) - 1, 0, self.times_s.size - 2))
        pair = slice(first, first + 2)
        quaternion: Array = Slerp(self.times_s[pair], Rotation.from_quat(self.quaternions[pair]))(time_s).as_quat()
        return quaternion


def _normal(position_m: Array) -> Array:
    """Return the unit vector (3,) up at a position, along the normal of the ellipsoid."""
    latitude, longitude, _ = geographic(position_m)
    return Ellipsoid.east_north_up(latitude, longitude)[2]
