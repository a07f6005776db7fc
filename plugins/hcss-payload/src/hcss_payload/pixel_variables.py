"""Variables that a cube of a camera has for each pixel and each frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_payload.pose import Pose
from hcss_payload.ray_geometry import LARGEST_WITH_LIMB_DEG, LARGEST_ZENITH_DEG
from hcss_twin.cube.variables import VariableSpec


def _pixel(name: str, units: str, long_name: str, text: str, standard: str | None, dtype: str) -> VariableSpec:
    return VariableSpec(
        name, units, long_name, "geometry", text, ("time", "y", "x"), dtype, standard, may_be_missing=dtype != "uint8"
    )


PIXEL_VARIABLES = (
    _pixel("pixel_latitude", "degrees_north", "latitude of the pixel",
        "Geodetic latitude (WGS 84) where the line of sight of the pixel's centre meets the ellipsoid.", "latitude",
        "float64"),
    _pixel("pixel_longitude", "degrees_east", "longitude of the pixel",
        "Longitude of that place, within 180 degrees of the scene's.", "longitude", "float64"),
    _pixel("pixel_view_zenith", "degree", "zenith angle of the sensor at the pixel",
        "Angle at that place between the ellipsoid's normal and the camera.", "sensor_zenith_angle", "float32"),
    _pixel("pixel_view_azimuth", "degree", "azimuth angle of the sensor at the pixel",
        "Bearing from that place toward the camera, clockwise from north.", "sensor_azimuth_angle", "float32"),
    _pixel("pixel_slant_range", "m", "distance from the pixel to the sensor", "Distance from that place to the camera.",
        None, "float32"),
    replace(
        _pixel("pixel_kind", "1", "what the pixel sees",
            f"Ground; ground beyond view zenith {LARGEST_ZENITH_DEG:g} degrees ({LARGEST_WITH_LIMB_DEG:g} with "
            "camera.beyond = 'limb'), and limb, whose radiance is missing without that and of clear air with it; or "
            "space above 100 km, whose radiance is 0.", None, "uint8"),
        attributes={"flag_values": np.arange(4, dtype=np.uint8), "flag_meanings": "ground slant_ground limb space"},
    ),
)  # fmt: skip
"""Coordinates of the pixels of each frame."""

_LEAST = "Least altitude above the ellipsoid along the line of sight of a pixel of limb or space."
TANGENT_HEIGHT = _pixel("pixel_tangent_height", "m", "tangent height", _LEAST, None, "float32")
"""Coordinate of pixels that miss the ground, with camera.beyond = "limb"."""


def coordinates(rows: int, columns: int, poses: Sequence[Pose]) -> tuple[tuple[VariableSpec, NDArray[Any]], ...]:
    """Return the coordinates of a cube: rows, columns, and the pose of each frame."""

    def spec(name: str, dims: tuple[str, ...], units: str, long_name: str, text: str, dtype: str) -> VariableSpec:
        return VariableSpec(name, units, long_name, "coordinate", text, dims, dtype)

    return (
        (spec("row", ("row",), "1", "row of the detector", "From 0; the first row is the upper one.", "int32"),
         np.arange(rows, dtype=np.int32)),
        (spec("column", ("column",), "1", "column of the detector", "From 0, left to right.", "int32"),
         np.arange(columns, dtype=np.int32)),
        (spec("platform_position", ("time", "earth_axis"), "m", "position of the camera",
              "Earth-fixed (ITRF, WGS 84): toward 0 N 0 E, 0 N 90 E and the north pole.", "float64"),
         np.array([pose.position_m for pose in poses])),
        (spec("platform_quaternion", ("time", "quaternion_component"), "1", "orientation of the camera's body",
              "x, y, z, w; turns vectors of the body (z ahead, x along columns, y along rows) into Earth-fixed ones.",
              "float64"),
         np.array([pose.quaternion for pose in poses])),
    )  # fmt: skip
