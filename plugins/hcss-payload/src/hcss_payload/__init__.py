"""Focal plane, orbit, attitude and jitter: images of an hcss_twin scene from a pose in space.

Positions are Earth-centred, Earth-fixed (ITRF / WGS 84, metres), times are seconds after a start in UTC, and a
quaternion (x, y, z, w) turns vectors of the body into Earth-fixed ones. A body in its nominal attitude looks along +z,
with columns along +x and rows along +y, so that the first row of an image with north up is the northern one.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hcss_payload.attitude import Attitude, AttitudeTable, Nadir, PushBroom, Track
    from hcss_payload.camera import Camera
    from hcss_payload.ccsds import read_aem, read_oem, write_aem, write_oem
    from hcss_payload.checks import PayloadError
    from hcss_payload.earth_rotation import EarthOrientation
    from hcss_payload.jitter import Jitter, JitterLine
    from hcss_payload.pose import Pose, pose_at
    from hcss_payload.trajectory import Circular, Geostationary, PositionTable, Trajectory
    from hcss_payload.two_lines import TwoLineElements

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

_HOMES = {
    "attitude": ("Attitude", "AttitudeTable", "Nadir", "PushBroom", "Track"),
    "camera": ("Camera",),
    "ccsds": ("read_aem", "read_oem", "write_aem", "write_oem"),
    "checks": ("PayloadError",),
    "earth_rotation": ("EarthOrientation",),
    "jitter": ("Jitter", "JitterLine"),
    "pose": ("Pose", "pose_at"),
    "trajectory": ("Circular", "Geostationary", "PositionTable", "Trajectory"),
    "two_lines": ("TwoLineElements",),
}


def __getattr__(name: str) -> Any:
    """Import a public name on first use: commands of hcss import this package to read its hooks."""
    for module, names in _HOMES.items():
        if name in names:
            return getattr(import_module(f"{__name__}.{module}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
