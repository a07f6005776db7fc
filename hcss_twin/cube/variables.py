"""Tables of the variables that a cube can contain, used by writer, reader, documentation and tests.

To add an output variable, add an entry here and compute its values in the engine. Standard names come from
the CF standard name table. Band-integrated radiance has none (the names for radiance at the top of the
atmosphere are per unit wavelength), so it has only a ``long_name``.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from hcss_twin.providers import OutputVariable

Kind = Literal["radiance", "truth", "derived", "coordinate", "geometry", "own"]
Feature = Literal["layers", "shadows", "waves", "altitude", "elements", "surfaces"]

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
    dims : tuple of str
        Dimensions, in order.
    dtype : str
        NumPy name of the type in the file; arrays passed to the writer must have this type. Text is ``str``.
    units : str or None
        UDUNITS string; None for text.
    long_name : str
        Label for plots.
    kind : {"radiance", "truth", "derived", "coordinate", "geometry", "own"}
        ``radiance``: total and its terms; ``truth``: state of the scene; ``derived``: computed from radiance;
        ``geometry``: coordinates of every pixel, written on request; ``own``: of a variable provider.
    description : str
        Definition in one or two sentences; written as ``comment``.
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
    needs : {"layers", "shadows", "waves", "altitude", "elements", "surfaces"} or None
        Scene feature that the variable requires.
    """

    name: str
    dims: tuple[str, ...]
    dtype: str
    units: str | None
    long_name: str
    kind: Kind
    description: str
    standard_name: str | None = None
    attributes: Mapping[str, str | float | NDArray[Any]] = field(default_factory=dict)
    lowest: float | None = None
    highest: float | None = None
    may_be_missing: bool = False
    significant_bits: int | None = None
    needs: Feature | None = None

    @property
    def needs_radiance(self) -> bool:
        """Whether the variable requires the radiance of pixels."""
        return self.kind in ("radiance", "derived")


TERM_PREFIX = "radiance_"
SHADOW_MASK = "shadow_mask"
SURFACE_CLASS, SURFACE_TEMPERATURE = "surface_class", "surface_temperature"
ELEMENT, ELEMENT_SHARE, ELEMENT_RADIANCE = "element", "element_share", "element_radiance"

_TERM = re.compile(r"[a-z][a-z0-9_]*\Z")
_ON_SCALE = {"units_metadata": "temperature: on_scale"}

VARIABLES: tuple[VariableSpec, ...] = (
    VariableSpec(
        name="radiance",
        dims=BAND_FRAME,
        dtype="float32",
        units="W m-2 sr-1",
        long_name="band-integrated radiance at the sensor",
        kind="radiance",
        description="Spectral radiance at the top of the atmosphere toward the sensor, integrated over the band; the "
        "sum of all terms.",
        lowest=0.0,
    ),
    VariableSpec(
        name="brightness_temperature",
        dims=BAND_FRAME,
        dtype="float32",
        units="K",
        long_name="brightness temperature in the band",
        kind="derived",
        description="Temperature of the black body with the same band radiance; without thermal meaning where sunlight "
        "dominates.",
        standard_name="toa_brightness_temperature",
        attributes=_ON_SCALE,
        lowest=0.0,
    ),
    VariableSpec(
        name="cloud_mask",
        dims=FRAME,
        dtype="uint8",
        units="1",
        long_name="cloud mask",
        kind="truth",
        description="1: cloud of any thickness in any layer on any part of the footprint; 0: clear.",
        standard_name="cloud_binary_mask",
        attributes={"flag_values": np.array([0, 1], dtype=np.uint8), "flag_meanings": "clear cloudy"},
        lowest=0.0,
        highest=1.0,
    ),
    VariableSpec(
        name="cloud_fraction",
        dims=FRAME,
        dtype="float32",
        units="1",
        long_name="cloud fraction of the pixel",
        kind="truth",
        description="Fraction of the pixel's points with cloud in any layer.",
        standard_name="cloud_area_fraction",
        lowest=0.0,
        highest=1.0,
    ),
    VariableSpec(
        name=SHADOW_MASK,
        dims=FRAME,
        dtype="uint8",
        units="1",
        long_name="mask of clouds' shadows on the sea",
        kind="truth",
        description="1: on some clear part of the pixel cloud is between sun and sea; 0: elsewhere, where the whole "
        "pixel is cloudy, and with the sun below the horizon.",
        needs="shadows",
        attributes={"flag_values": np.array([0, 1], dtype=np.uint8), "flag_meanings": "not_shadowed shadowed"},
        lowest=0.0,
        highest=1.0,
    ),
    VariableSpec(
        name="cloud_thickness",
        dims=FRAME,
        dtype="float32",
        units="m",
        long_name="geometric thickness of the cloud",
        kind="truth",
        description="Vertical extent of the cloud, summed over layers, mean over the footprint with its clear part.",
        lowest=0.0,
    ),
    VariableSpec(
        name="cloud_layer_thickness",
        dims=LAYER_FRAME,
        dtype="float32",
        units="m",
        long_name="geometric thickness of the cloud in each layer",
        kind="truth",
        description="Vertical extent of the cloud of one layer, mean over the footprint with its clear part; layers "
        "from the lowest to the highest.",
        needs="layers",
        lowest=0.0,
    ),
    VariableSpec(
        name="cloud_optical_thickness",
        dims=BAND_FRAME,
        dtype="float32",
        units="1",
        long_name="optical thickness of the cloud",
        kind="truth",
        description="Vertical extinction optical thickness of the cloud particles at the central wavelength of the "
        "band, summed over layers, mean over the footprint with its clear part.",
        standard_name="atmosphere_optical_thickness_due_to_cloud",
        lowest=0.0,
    ),
    VariableSpec(
        name="cloud_top_altitude",
        dims=FRAME,
        dtype="float32",
        units="m",
        long_name="altitude of the cloud top",
        kind="truth",
        description="Altitude of the top of the highest cloud above the sea, mean over the cloudy points; missing "
        "where clear.",
        standard_name="cloud_top_altitude",
        lowest=0.0,
        may_be_missing=True,
    ),
    VariableSpec(
        name="cloud_top_temperature",
        dims=FRAME,
        dtype="float32",
        units="K",
        long_name="temperature at the cloud top",
        kind="truth",
        description="Temperature at the top of the highest cloud, mean over the cloudy points; missing where clear.",
        standard_name="air_temperature_at_cloud_top",
        attributes=_ON_SCALE,
        lowest=0.0,
        may_be_missing=True,
    ),
    *(
        VariableSpec(
            name=f"sea_slope_{axis}",
            dims=FRAME,
            dtype="float32",
            units="1",
            long_name=f"slope of the sea toward {bearing}",
            kind="truth",
            description=f"Slope along {axis} of the waves longer than two points of the image, mean over the "
            "footprint, also under clouds; only with resolved waves (sea.waves).",
            needs="waves",
        )
        for axis, bearing in (("x", "east"), ("y", "north"))
    ),
    VariableSpec(
        name=SURFACE_CLASS,
        dims=FRAME,
        dtype="uint8",
        units="1",
        long_name="class of the surface",
        kind="truth",
        description="Class at most points of the pixel, also under clouds; the first in the order of the flags if "
        "several are equal.",
        needs="surfaces",
        lowest=0.0,
    ),
    VariableSpec(
        name=SURFACE_TEMPERATURE,
        dims=FRAME,
        dtype="float32",
        units="K",
        long_name="temperature of the surface",
        kind="truth",
        description="Temperature of sea, land or ice, also under clouds; mean over the footprint.",
        standard_name="surface_temperature",
        attributes=_ON_SCALE,
        needs="surfaces",
        lowest=0.0,
    ),
    VariableSpec(
        name=ELEMENT,
        dims=FRAME,
        dtype="uint8",
        units="1",
        long_name="number of the element in the pixel",
        kind="truth",
        description="Number of the [[elements]] section, from 1, of the highest element in the pixel; 0: none.",
        needs="elements",
        lowest=0.0,
    ),
    VariableSpec(
        name=ELEMENT_SHARE,
        dims=FRAME,
        dtype="float32",
        units="1",
        long_name="share of the element in the pixel",
        kind="truth",
        description="Share of the pixel that its highest element covers; of an unresolved source, share of its energy "
        "in the pixel. 0: no element.",
        needs="elements",
        lowest=0.0,
        highest=1.0,
    ),
    VariableSpec(
        name=ELEMENT_RADIANCE,
        dims=BAND_FRAME,
        dtype="float32",
        units="W m-2 sr-1",
        long_name="radiance that elements add",
        kind="derived",
        description="Radiance less that of the scene without elements, which is the sum of the terms; negative where "
        "elements hide more than they send.",
        needs="elements",
    ),
)


def term_variable(name: str, description: str) -> VariableSpec:
    """Return the variable ``radiance_<name>`` of one term of the radiance model.

    Raises
    ------
    ValueError
        If ``name`` contains anything but lower-case letters, digits and underscores.
    """
    if not _TERM.match(name):
        raise ValueError(f"radiance term '{name}': a term is named with lower-case letters, digits and underscores")
    return VariableSpec(
        name=TERM_PREFIX + name,
        dims=BAND_FRAME,
        dtype="float32",
        units="W m-2 sr-1",
        long_name=f"part of the radiance: {name.replace('_', ' ')}",
        kind="radiance",
        description=description,
        lowest=0.0,
    )


def surface_class(spec: VariableSpec, names: Sequence[str]) -> VariableSpec:
    """Return the variable ``surface_class`` with the names of the scene's classes as its flags."""
    flags: Mapping[str, str | float | NDArray[np.uint8]] = {
        "flag_values": np.arange(len(names), dtype=np.uint8),
        "flag_meanings": " ".join(names),
    }
    return replace(spec, attributes=flags) if names else spec


def element_variable(name: str, units: str, description: str) -> VariableSpec:
    """Return the truth variable ``element_<name>`` of an element provider."""
    return VariableSpec(
        name=f"{ELEMENT}_{name}",
        dims=FRAME,
        dtype="float32",
        units=units,
        long_name=f"{name.replace('_', ' ')} of the element",
        kind="truth",
        description=description,
        may_be_missing=True,
        needs="elements",
    )


INPUTS = "hcss_inputs"
"""Attribute of a variable of a provider: the variables and the geometry that it is derived from."""


def own_variable(name: str, about: OutputVariable, needs: Iterable[str] = ()) -> VariableSpec:
    """Return a variable of a variable provider, derived from ``needs``."""
    meanings = about.flag_meanings
    attributes: dict[str, str | float | NDArray[Any]] = {INPUTS: " ".join(needs)}
    if meanings:
        attributes |= {"flag_values": np.arange(len(meanings), dtype=about.dtype), "flag_meanings": " ".join(meanings)}
    return VariableSpec(
        name=name,
        dims=BAND_FRAME if about.per_band else FRAME,
        dtype=about.dtype,
        units=about.units,
        long_name=about.long_name,
        kind="own",
        description=about.description,
        standard_name=about.standard_name,
        attributes=attributes,
        lowest=about.lowest,
        highest=about.highest,
        may_be_missing=about.may_be_missing,
    )


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
    return VariableSpec(name, ("y", "x"), dtype, units, long_name, "geometry", description, standard_name, needs=needs)


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
