"""Variables of a cube with the geometry of each pixel: its place, and the direction to the sensor."""

from __future__ import annotations

from dataclasses import replace

from hcss_twin.cube.variables import FRAME, Feature, VariableSpec

_MOVES = "Also along time if the platform moves."
_OF_START = "The same in every frame."


def _pixel_variable(
    name: str,
    units: str,
    long_name: str,
    description: str,
    standard_name: str | None = None,
    dtype: str = "float32",
    needs: Feature | None = None,
) -> VariableSpec:
    return VariableSpec(name, units, long_name, "geometry", description, ("y", "x"), dtype, standard_name, needs=needs)


LOCATION: tuple[VariableSpec, ...] = (
    _pixel_variable("pixel_latitude", "degrees_north", "latitude of the pixel",
        f"Geodetic latitude (WGS 84) of the pixel's centre on the ellipsoid. {_MOVES}", standard_name="latitude",
        dtype="float64"),
    _pixel_variable("pixel_longitude", "degrees_east", "longitude of the pixel",
        f"Geodetic longitude (WGS 84) of the pixel's centre, beyond 180 degrees where the image crosses that "
        f"meridian. {_MOVES}",
        standard_name="longitude", dtype="float64"),
)  # fmt: skip
"""Coordinates that do not depend on the sensor altitude."""

DIRECTION: tuple[VariableSpec, ...] = (
    _pixel_variable("pixel_view_zenith", "degree", "zenith angle of the sensor at the pixel",
        f"Angle at the pixel's centre between the ellipsoid's normal and the sensor. {_OF_START}",
        standard_name="sensor_zenith_angle", needs="altitude"),
    _pixel_variable("pixel_view_azimuth", "degree", "azimuth angle of the sensor at the pixel",
        f"Bearing from the pixel's centre toward the sensor, 0 to 360. {_OF_START}",
        standard_name="sensor_azimuth_angle", needs="altitude"),
    _pixel_variable("pixel_slant_range", "m", "distance from the pixel to the sensor",
        f"Distance from the pixel's centre to the sensor. {_OF_START}", dtype="float64", needs="altitude"),
    _pixel_variable("pixel_footprint_across", "m", "width of a detector's footprint across the line of sight",
        f"Slant range times the angle of a detector: image.pixel_size over the slant range of the image centre. "
        f"{_OF_START}",
        needs="altitude"),
    _pixel_variable("pixel_footprint_along", "m", "length of a detector's footprint along the line of sight",
        f"Width over the cosine of the view zenith; pixels are squares of image.pixel_size all the same. {_OF_START}",
        needs="altitude"),
)  # fmt: skip
"""Coordinates that require the sensor altitude."""

GEOMETRY = (*LOCATION, *DIRECTION)

STANDS_FOR = {
    "pixel_latitude": "latitude",
    "pixel_longitude": "longitude",
    "pixel_view_zenith": "sensor_zenith_angle",
    "pixel_view_azimuth": "sensor_azimuth_angle",
}
"""Image-centre coordinates that the per-pixel ones replace: readers expect one latitude."""

MOVING_LOCATION = tuple(replace(spec, dims=FRAME) for spec in LOCATION)
"""Pixel locations for a moving platform."""
