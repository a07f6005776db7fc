"""The table of a cube's viewing geometry: coordinates of every pixel, written on request."""

from __future__ import annotations

from dataclasses import replace

from hcss_twin.cube.spec import FRAME, VariableSpec

PLANE = ("y", "x")

_MOVES = "With a platform that moves it has the dimension time in front."
_OF_START = "Sensor and image move together: that of the start stands for every frame."

LOCATION: tuple[VariableSpec, ...] = (
    VariableSpec(
        name="pixel_latitude",
        dims=PLANE,
        dtype="float64",
        units="degrees_north",
        long_name="latitude of the pixel",
        kind="geometry",
        description=f"Geodetic latitude (WGS 84) of the pixel's centre on the ellipsoid. {_MOVES}",
        standard_name="latitude",
    ),
    VariableSpec(
        name="pixel_longitude",
        dims=PLANE,
        dtype="float64",
        units="degrees_east",
        long_name="longitude of the pixel",
        kind="geometry",
        description="Geodetic longitude (WGS 84) of the pixel's centre, within half a turn of the image centre's at "
        f"the start: it runs on beyond 180 degrees where the image crosses that meridian. {_MOVES}",
        standard_name="longitude",
    ),
)
"""What is known without the sensor's altitude."""

DIRECTION: tuple[VariableSpec, ...] = (
    VariableSpec(
        name="pixel_view_zenith",
        dims=PLANE,
        dtype="float32",
        units="degree",
        long_name="zenith angle of the sensor at the pixel",
        kind="geometry",
        description=f"Angle at the pixel's centre between the normal of the ellipsoid and the sensor. {_OF_START}",
        standard_name="sensor_zenith_angle",
    ),
    VariableSpec(
        name="pixel_view_azimuth",
        dims=PLANE,
        dtype="float32",
        units="degree",
        long_name="azimuth angle of the sensor at the pixel",
        kind="geometry",
        description="Bearing from the pixel's centre toward the sensor, clockwise from north there, 0 to 360. "
        f"{_OF_START}",
        standard_name="sensor_azimuth_angle",
    ),
    VariableSpec(
        name="pixel_slant_range",
        dims=PLANE,
        dtype="float64",
        units="m",
        long_name="distance from the pixel to the sensor",
        kind="geometry",
        description=f"Straight line from the pixel's centre to the sensor. {_OF_START}",
    ),
    VariableSpec(
        name="pixel_footprint_across",
        dims=PLANE,
        dtype="float32",
        units="m",
        long_name="width of a detector's footprint across the line of sight",
        kind="geometry",
        description="Slant range times the angle of one detector, which is image.pixel_size over the slant range of "
        f"the image centre. {_OF_START}",
    ),
    VariableSpec(
        name="pixel_footprint_along",
        dims=PLANE,
        dtype="float32",
        units="m",
        long_name="length of a detector's footprint along the line of sight",
        kind="geometry",
        description="Its width divided by the cosine of the view zenith. The image is sampled in squares of "
        f"image.pixel_size all the same. {_OF_START}",
    ),
)
"""What needs the sensor's altitude."""

GEOMETRY = (*LOCATION, *DIRECTION)

STANDS_FOR = {
    "pixel_latitude": "latitude",
    "pixel_longitude": "longitude",
    "pixel_view_zenith": "sensor_zenith_angle",
    "pixel_view_azimuth": "sensor_azimuth_angle",
}
"""Coordinates of the image centre that those of the pixels take the place of: readers expect one latitude."""

MOVING_LOCATION = tuple(replace(spec, dims=FRAME) for spec in LOCATION)
"""Where the platform moves."""
