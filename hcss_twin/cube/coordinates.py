"""The table of coordinate variables, and their values."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.errors import CubeError
from hcss_twin.cube.geometry import footprint, pixel_centres_m
from hcss_twin.cube.header import IMAGE_AXES, CubeHeader
from hcss_twin.cube.variables import LAYER, STANDS_FOR, VariableSpec
from hcss_twin.physics.geodesy import INVERSE_FLATTENING, SEMI_MAJOR_AXIS_M

if TYPE_CHECKING:
    import xarray as xr


_UNITS = "seconds since "


def start_of(dataset: xr.Dataset) -> np.datetime64:
    """Return the scenario's start (UTC) of an open cube, the reference of its time coordinate.

    Raises
    ------
    CubeError
        If the file has other time units.
    """
    units = str(dataset["time"].encoding.get("units", ""))
    try:
        if units.startswith(_UNITS):
            return np.datetime64(units.removeprefix(_UNITS).strip(), "ns")
    except ValueError:
        pass
    raise CubeError(f"time is in '{units}'; a cube has '{_UNITS}' and a date")


def frame_times_s(dataset: xr.Dataset) -> NDArray[np.float64]:
    """Return the time of each frame in seconds since the scenario's start, to the nanosecond.

    Raises
    ------
    CubeError
        If the file has other time units.
    """
    since = dataset["time"].to_numpy().astype("datetime64[ns]") - start_of(dataset)
    seconds: NDArray[np.float64] = since / np.timedelta64(1, "s")
    return seconds


BOUND = "bound"
VERTEX = "vertex"
GRID_MAPPING = "local_plane"

_AZIMUTH = "Bearing from the surface point toward the {body}, clockwise from north."
_ZENITH = "Angle at the surface point between the zenith and the {body}."


def _coordinate(
    name: str,
    dims: tuple[str, ...],
    units: str | None,
    long_name: str,
    description: str,
    standard_name: str | None = None,
    dtype: str = "float64",
    **attributes: str,
) -> VariableSpec:
    return VariableSpec(name, units, long_name, "coordinate", description, dims, dtype, standard_name, attributes)


COORDINATES: tuple[VariableSpec, ...] = (
    _coordinate("time", ("time",), "seconds since the start", "time of the frame", "Time of the frame.", "time",
        axis="T", calendar="standard", units_metadata="leap_seconds: none"),
    _coordinate("y", ("y",), "m", "distance north of the image centre",
        "Pixel centre in the local plane, from the centre of its frame (of the whole image, if the cube is a "
        "window); grows with the row.",
        "projection_y_coordinate", axis="Y"),
    _coordinate("x", ("x",), "m", "distance east of the image centre",
        "As y; grows with the column. The platform moves along +x.", "projection_x_coordinate", axis="X"),
    _coordinate("band_name", ("band",), None, "name of the band", "Name given in the scenario.",
        "sensor_band_identifier", "str"),
    _coordinate("wavelength", ("band",), "um", "central wavelength of the band", "Central wavelength in vacuum.",
        "sensor_band_central_radiation_wavelength", bounds="wavelength_bounds"),
    _coordinate("wavelength_bounds", ("band", BOUND), "um", "limits of the band",
        "Limits of the integral over wavelength; a CF boundary variable without attributes."),
    _coordinate("layer_name", (LAYER,), None, "name of the cloud layer", "Cloud type given in the scenario.",
        dtype="str"),
    _coordinate("layer_base", (LAYER,), "m", "altitude of the layer's base",
        "Lowest altitude of the layer's clouds above the sea.", positive="up"),
    _coordinate("layer_top", (LAYER,), "m", "altitude of the layer's highest top",
        "Highest altitude of the layer's clouds above the sea.", positive="up"),
    _coordinate("latitude", (), "degrees_north", "latitude of the image centre at the start",
        "Image centre at the start.", "latitude"),
    _coordinate("longitude", (), "degrees_east", "longitude of the image centre at the start",
        "Image centre at the start.", "longitude"),
    _coordinate("footprint_latitude", (VERTEX,), "degrees_north", "latitude of the footprint's outline",
        "Outline of all frames together, anticlockwise from the south-west corner.", "latitude"),
    _coordinate("footprint_longitude", (VERTEX,), "degrees_east", "longitude of the footprint's outline",
        "Outline of all frames together; beyond 180 degrees where it crosses that meridian.", "longitude"),
    _coordinate("altitude", (), "m", "altitude of the image plane",
        "0: x, y, footprint and angles refer to the sea surface.", "altitude", axis="Z", positive="up"),
    _coordinate("centre_displacement", ("time",), "m", "distance travelled by the image centre",
        "Add it to x for the distance east of the image centre at the start."),
    _coordinate("sensor_zenith_angle", (), "degree", "zenith angle of the sensor", _ZENITH.format(body="sensor"),
        "sensor_zenith_angle"),
    _coordinate("sensor_azimuth_angle", (), "degree", "azimuth angle of the sensor", _AZIMUTH.format(body="sensor"),
        "sensor_azimuth_angle"),
    _coordinate("sensor_altitude", (), "m", "altitude of the sensor",
        "Altitude above the ellipsoid, if the scenario has it.", "height_above_reference_ellipsoid", positive="up"),
    _coordinate("solar_zenith_angle", ("time",), "degree", "zenith angle of the sun",
        _ZENITH.format(body="sun") + " As refracted by the air. Above 90 degrees the sun is below the horizon.",
        "solar_zenith_angle"),
    _coordinate("solar_azimuth_angle", ("time",), "degree", "azimuth angle of the sun", _AZIMUTH.format(body="sun"),
        "solar_azimuth_angle"),
)  # fmt: skip


OF_ANY_IMAGE = (
    *("time", "band_name", "wavelength", "wavelength_bounds", "layer_name", "layer_base", "layer_top", "altitude"),
    *("solar_zenith_angle", "solar_azimuth_angle"),
)
"""Coordinates of images that are no grid on the ground; angles of the sun are those of the scene's place."""


def coordinate_specs(header: CubeHeader) -> tuple[VariableSpec, ...]:
    """Return the coordinate variables that a cube may have."""
    if header.layout is None:
        return COORDINATES
    of_layout = (spec for spec, _ in header.layout.coordinates)
    return (*(spec for spec in COORDINATES if spec.name in OF_ANY_IMAGE), *of_layout)


def coordinate_values(header: CubeHeader) -> dict[str, NDArray[Any]]:
    """Return the value of each coordinate variable, keyed and shaped as in the table.

    ``time`` is in seconds since the start. Coordinates of unused dimensions, and an unknown sensor altitude,
    are omitted.
    """
    extent, window = footprint(header), header.image_window
    times = np.array(header.frame_times_s, dtype=np.float64)
    values: dict[str, Any] = {
        "time": times,
        "y": pixel_centres_m(window.first_row, header.rows, window.image_rows, header.pixel_size_m),
        "x": pixel_centres_m(window.first_column, header.columns, window.image_columns, header.pixel_size_m),
        "band_name": np.array([band.name for band in header.bands], dtype=object),
        "wavelength": [band.central_um for band in header.bands],
        "wavelength_bounds": [(band.lower_um, band.upper_um) for band in header.bands],
        "layer_name": np.array([layer.name for layer in header.layers], dtype=object),
        "layer_base": [layer.base_m for layer in header.layers],
        "layer_top": [layer.top_m for layer in header.layers],
        "latitude": header.latitude,
        "longitude": header.longitude,
        "footprint_latitude": [latitude for latitude, _ in extent.outline],
        "footprint_longitude": [longitude for _, longitude in extent.outline],
        "altitude": 0.0,
        "centre_displacement": header.platform_speed_m_s * times,
        "sensor_zenith_angle": header.view_zenith_deg,
        "sensor_azimuth_angle": header.view_azimuth_deg,
        "sensor_altitude": header.sensor_altitude_m,
        "solar_zenith_angle": list(header.solar_zenith_deg),
        "solar_azimuth_angle": list(header.solar_azimuth_deg),
    }
    if header.layout is not None:
        values |= {spec.name: value for spec, value in header.layout.coordinates}
    return {
        spec.name: np.asarray(values[spec.name], dtype=object if spec.dtype == "str" else spec.dtype)
        for spec in coordinate_specs(header)
        if (LAYER not in spec.dims or LAYER in header.sizes) and values[spec.name] is not None
    }


def time_units(header: CubeHeader) -> str:
    """Return the CF units of time."""
    start = header.start_utc
    fraction = f".{start.microsecond:06d}" if start.microsecond else ""
    return f"seconds since {start:%Y-%m-%d %H:%M:%S}{fraction}"


def auxiliary_names(header: CubeHeader, dims: tuple[str, ...]) -> list[str]:
    """Return the coordinate variables that belong to a data variable with these dimensions.

    If pixels have their own coordinates, those of the image centre are excluded.
    """
    of_pixels = [spec.name for spec in header.geometry if set(spec.dims) <= set(dims)]
    of_pixels += [spec.name for spec in header.variables if spec.kind == "geometry" and set(spec.dims) <= set(dims)]
    instead = {STANDS_FOR.get(name) for name in of_pixels} | {"altitude"}
    if header.sensor_altitude_m is None:
        instead.add("sensor_altitude")
    centre = [
        spec.name
        for spec in coordinate_specs(header)
        if spec.name not in header.in_file(dims)
        and not is_bounds(spec)
        and spec.name not in instead
        and set(spec.dims) <= set(header.in_file(dims))
    ]
    return [*of_pixels, *centre]  # CDO reads the first five: places of pixels go before what it cannot use


def with_plane_axes(dataset: xr.Dataset) -> xr.Dataset:
    """Return a cube with the axes y and x in place of ``row`` and ``column``, if it has those."""
    return dataset.rename({image_axis: plane for plane, image_axis in IMAGE_AXES.items() if image_axis in dataset.dims})


def is_bounds(spec: VariableSpec) -> bool:
    """Return whether a coordinate is a CF boundary variable, which has no attributes."""
    return BOUND in spec.dims


def grid_mapping_attributes(header: CubeHeader) -> dict[str, str | float]:
    """Return the attributes of the CF grid mapping for x and y."""
    return {
        "grid_mapping_name": "azimuthal_equidistant",
        "longitude_of_projection_origin": header.longitude,
        "latitude_of_projection_origin": header.latitude,
        "false_easting": 0.0,
        "false_northing": 0.0,
        "semi_major_axis": SEMI_MAJOR_AXIS_M,
        "inverse_flattening": INVERSE_FLATTENING,
        "long_name": "local tangent plane",
        "comment": "Holds for frames whose centre_displacement is 0; the plane moves with the image centre.",
    }
