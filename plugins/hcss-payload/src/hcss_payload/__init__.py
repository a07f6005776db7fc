"""Focal plane, orbit, attitude and jitter: images of an hcss_twin scene from a pose in space.

Positions are Earth-centred, Earth-fixed (ITRF / WGS 84, metres), times are seconds after a start in UTC, and a
quaternion (x, y, z, w) turns vectors of the body into Earth-fixed ones. A body in its nominal attitude looks along +z,
with columns along +x and rows along +y, so that the first row of an image with north up is the northern one.
"""

from hcss_payload.attitude import Attitude, AttitudeTable, Nadir, PushBroom, Track
from hcss_payload.camera import Camera
from hcss_payload.ccsds import read_aem, read_oem, write_aem, write_oem
from hcss_payload.checks import PayloadError
from hcss_payload.earth_rotation import EarthOrientation
from hcss_payload.jitter import Jitter, JitterLine
from hcss_payload.pose import Pose, pose_at
from hcss_payload.trajectory import Circular, Geostationary, PositionTable, Trajectory, TwoLineElements

__all__ = [
    "Attitude",
    "AttitudeTable",
    "Camera",
    "Circular",
    "EarthOrientation",
    "Geostationary",
    "Jitter",
    "JitterLine",
    "Nadir",
    "PayloadError",
    "Pose",
    "PositionTable",
    "PushBroom",
    "Track",
    "Trajectory",
    "TwoLineElements",
    "pose_at",
    "read_aem",
    "read_oem",
    "write_aem",
    "write_oem",
]
