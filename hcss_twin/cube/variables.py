"""Tables of the variables that a cube can contain, used by writer, reader, documentation and tests.

To add an output variable, add an entry here and compute its values in the engine. Standard names come from
the CF standard name table. Band-integrated radiance has none (the names for radiance at the top of the
atmosphere are per unit wavelength), so it has only a ``long_name``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from hcss_twin.cube.packing import Packing

__all__ = ["VariableSpec"]


Kind = Literal["radiance", "truth", "derived", "coordinate", "geometry", "own"]
Feature = Literal["layers", "shadows", "waves", "altitude", "elements", "surfaces", "texture", "light"]

FRAME = ("time", "y", "x")
BAND_FRAME = ("time", "band", "y", "x")
LAYER = "layer"
LAYER_FRAME = ("time", LAYER, "y", "x")


@dataclass(frozen=True)
class VariableSpec:
    """One variable of the cube.

    Attributes
    ----------
    name : str
        Name in the file.
    units : str or None
        UDUNITS string; None for text.
    long_name : str
        Label for plots.
    kind : {"radiance", "truth", "derived", "coordinate", "geometry", "own"}
        ``radiance``: total and its terms; ``truth``: state of the scene; ``derived``: computed from radiance;
        ``geometry``: coordinates of every pixel, written on request; ``own``: of a variable provider.
    description : str
        Definition in one or two sentences; written as ``comment``.
    dims : tuple of str
        Dimensions, in order.
    dtype : str
        NumPy name of the type of arrays passed to the writer, and in the file unless packed. Text is ``str``.
    standard_name : str or None
        CF standard name.
    attributes : mapping
        Additional attributes in the file.
    lowest, highest : float or None
        Inclusive limits of the values; None: no limit.
    may_be_missing : bool
        Whether NaN is allowed, for pixels where the quantity does not exist.
    significant_bits : int or None
        Explicit mantissa bits to which values are rounded; None: all.
    needs : {"layers", "shadows", "waves", "altitude", "elements", "surfaces", "texture", "light"} or None
        Scene feature that the variable requires.
    packing : Packing or None
        Steps in which values are stored as 16-bit integers; None: values are stored as they are.
    """

    name: str
    units: str | None
    long_name: str
    kind: Kind
    description: str
    dims: tuple[str, ...] = FRAME
    dtype: str = "float32"
    standard_name: str | None = None
    attributes: Mapping[str, str | float | NDArray[Any]] = field(default_factory=dict)
    lowest: float | None = None
    highest: float | None = None
    may_be_missing: bool = False
    significant_bits: int | None = None
    needs: Feature | None = None
    packing: Packing | None = None

    @property
    def stored_dtype(self) -> str:
        """NumPy name of the type of the numbers in the file."""
        return self.dtype if self.packing is None else "int16"

    @property
    def needs_radiance(self) -> bool:
        """Whether the variable requires the radiance of pixels."""
        return self.kind in ("radiance", "derived")


TOTAL = "radiance"
TERM_PREFIX = "radiance_"
SHADOW_MASK = "shadow_mask"
SURFACE_CLASS, SURFACE_TEMPERATURE = "surface_class", "surface_temperature"
SEA_TEMPERATURE, WATER_VAPOUR_FACTOR = "sea_temperature", "water_vapour_factor"
ELEMENT, ELEMENT_SHARE, ELEMENT_RADIANCE = "element", "element_share", "element_radiance"
ELEMENT_POINT_RADIANCE, ELEMENT_TRANSMITTANCE = "element_point_radiance", "element_transmittance"
ELEMENT_PLACE = ("element_row", "element_column")
ELEMENT_RATE = ("element_row_rate", "element_column_rate")

BETWEEN_COLUMNS = f"{TERM_PREFIX}between_columns"
"""What light between columns adds to the total, beside the terms of independent columns."""

_ON_SCALE = {"units_metadata": "temperature: on_scale"}


def flags(meanings: str, dtype: str = "uint8") -> dict[str, str | float | NDArray[Any]]:
    """Return the attributes of a variable whose values 0, 1, ... have these meanings, separated by spaces."""
    return {"flag_values": np.arange(len(meanings.split()), dtype=dtype), "flag_meanings": meanings}


def _truth(name: str, units: str, long_name: str, description: str, **more: Any) -> VariableSpec:
    return VariableSpec(name, units, long_name, "truth", description, **more)


VARIABLES: tuple[VariableSpec, ...] = (
    VariableSpec("radiance", "W m-2 sr-1", "band-integrated radiance at the sensor", "radiance",
                 "Spectral radiance at the top of the atmosphere toward the sensor, integrated over the band; the "
                 "sum of all terms.", dims=BAND_FRAME, lowest=0.0),
    VariableSpec("brightness_temperature", "K", "brightness temperature in the band", "derived",
                 "Temperature of the black body with the same band radiance; without thermal meaning where sunlight "
                 "dominates.",
                 dims=BAND_FRAME, standard_name="toa_brightness_temperature", attributes=_ON_SCALE, lowest=0.0),
    _truth("cloud_mask", "1", "cloud mask",
           "1: cloud of any thickness in any layer on any part of the footprint; 0: clear.",
           dtype="uint8", standard_name="cloud_binary_mask", attributes=flags("clear cloudy"), lowest=0.0, highest=1.0),
    _truth("cloud_fraction", "1", "cloud fraction of the pixel",
           "Fraction of the pixel's points with cloud in any layer.",
           standard_name="cloud_area_fraction", lowest=0.0, highest=1.0),
    _truth(SHADOW_MASK, "1", "mask of clouds' shadows on the sea",
           "1: on some clear part of the pixel cloud is between sun and sea; 0: elsewhere, where the whole pixel is "
           "cloudy, and with the sun below the horizon.",
           dtype="uint8", needs="shadows", attributes=flags("not_shadowed shadowed"), lowest=0.0, highest=1.0),
    _truth("cloud_thickness", "m", "geometric thickness of the cloud",
           "Vertical extent of the cloud, summed over layers, mean over the footprint with its clear part. In each "
           "layer a point has one slab of cloud without gaps.",
           lowest=0.0),
    _truth("cloud_layer_thickness", "m", "geometric thickness of the cloud in each layer",
           "Vertical extent of the cloud of one layer, mean over the footprint with its clear part; layers from the "
           "lowest to the highest.", dims=LAYER_FRAME, needs="layers", lowest=0.0),
    _truth("cloud_optical_thickness", "1", "optical thickness of the cloud",
           "Vertical extinction optical thickness of the cloud particles at the central wavelength of the band, "
           "summed over layers, mean over the footprint with its clear part.",
           dims=BAND_FRAME, standard_name="atmosphere_optical_thickness_due_to_cloud", lowest=0.0),
    _truth("cloud_top_altitude", "m", "altitude of the cloud top",
           "Altitude of the top of the highest cloud above the sea, mean over the cloudy points; its base is lower by "
           "the thickness in its layer; missing where clear.",
           standard_name="cloud_top_altitude", lowest=0.0, may_be_missing=True),
    _truth("cloud_top_temperature", "K", "temperature at the cloud top",
           "Temperature at the top of the highest cloud, mean over the cloudy points; missing where clear.",
           standard_name="air_temperature_at_cloud_top", attributes=_ON_SCALE, lowest=0.0, may_be_missing=True),
    *(
        _truth(f"sea_slope_{axis}", "1", f"slope of the sea toward {bearing}",
               f"Slope along {axis} of the waves longer than two points of the image, mean over the "
               "footprint, also under clouds; only with resolved waves (sea.waves).", needs="waves")
        for axis, bearing in (("x", "east"), ("y", "north"))
    ),
    _truth(SURFACE_CLASS, "1", "class of the surface",
           "Class at most points of the pixel, also under clouds; the first in the order of the flags if several "
           "are equal.", dtype="uint8", needs="surfaces", lowest=0.0),
    _truth(SURFACE_TEMPERATURE, "K", "temperature of the surface",
           "Temperature of sea, land or ice, also under clouds; mean over the footprint.",
           standard_name="surface_temperature", attributes=_ON_SCALE, needs="surfaces", lowest=0.0),
    _truth(SEA_TEMPERATURE, "K", "skin temperature of the sea",
           "Skin temperature of the sea with its texture, also under clouds; mean over the footprint.",
           standard_name="sea_surface_skin_temperature", attributes=_ON_SCALE, needs="texture", lowest=0.0),
    _truth(WATER_VAPOUR_FACTOR, "1", "water vapour relative to the profile",
           "Factor on the water vapour of the profile at all levels; mean over the footprint.",
           needs="texture", lowest=0.0),
    _truth(ELEMENT, "1", "number of the element in the pixel",
           "Number of the [[elements]] section, from 1, of the highest element in the pixel; 0: none.",
           dtype="uint8", needs="elements", lowest=0.0),
    _truth(ELEMENT_SHARE, "1", "share of the element in the pixel",
           "Share of the pixel that its highest element covers and no higher one hides; of a plume, share of its "
           "energy in the pixel. 0: no element.", needs="elements", lowest=0.0, highest=1.0),
    _truth(ELEMENT_TRANSMITTANCE, "1", "transmittance before the element",
           "Of the air and, directly, of the clouds between the place of the highest small element in the pixel and "
           "the sensor; missing where there is none.", dims=BAND_FRAME, needs="elements", lowest=0.0, highest=1.0,
           may_be_missing=True),
    *(
        _truth(name, "1", f"{axis} of the element",
               f"{axis.capitalize()} of the small elements in the pixel, weighted with what they add to the radiance: "
               "their place within the pixel; pixel n of the image extends from n to n + 1. Missing without.",
               needs="elements", may_be_missing=True)
        for name, axis in zip(ELEMENT_PLACE, ("row", "column"), strict=True)
    ),
    *(
        _truth(name, "s-1", f"motion of the element along {axis}s",
               f"{axis.capitalize()}s per second by which the small elements in the pixel move against the image.",
               needs="elements", may_be_missing=True)
        for name, axis in zip(ELEMENT_RATE, ("row", "column"), strict=True)
    ),
    VariableSpec(BETWEEN_COLUMNS, "W m-2 sr-1", "part of the radiance: light between columns of cloud", "derived",
                 "Radiance less the sum of the terms of independent columns, without elements; negative where columns "
                 "send too much.", dims=BAND_FRAME, needs="light"),
    VariableSpec(ELEMENT_RADIANCE, "W m-2 sr-1", "radiance that elements add", "derived",
                 "Radiance less that of the scene without elements, which is the sum of the terms; negative where "
                 "elements hide more than they send.", dims=BAND_FRAME, needs="elements"),
    VariableSpec(ELEMENT_POINT_RADIANCE, "W m-2 sr-1", "radiance that small elements add", "derived",
                 "Part of element_radiance that sensors draw at the place of the elements within their pixels, through "
                 "the point spread.", dims=BAND_FRAME, needs="elements"),
)  # fmt: skip


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
