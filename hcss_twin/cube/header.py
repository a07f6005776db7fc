"""Coordinates, geometry, variables and provenance of a cube, checked before its first frame."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import Any

from numpy.typing import NDArray

from hcss_twin.core.errors import CubeError
from hcss_twin.cube.variables import LAYER, VariableSpec

FORMAT_ATTRIBUTE = "hcss_cube_format"
FORMAT_VERSION = 1
SCENARIO_ATTRIBUTE = "hcss_scenario"

Attribute = str | float | int


@dataclass(frozen=True)
class BandInfo:
    """One spectral band: its name, limits and centre in micrometres."""

    name: str
    lower_um: float
    upper_um: float
    central_um: float


@dataclass(frozen=True)
class LayerInfo:
    """One cloud layer: its name, and the lowest and highest altitude of its clouds."""

    name: str
    base_m: float
    top_m: float


@dataclass(frozen=True)
class WindowInfo:
    """Position of a cube in a larger image: first row and column, and size of the image."""

    first_row: int
    first_column: int
    image_rows: int
    image_columns: int


IMAGE_AXES = {"y": "row", "x": "column"}
"""Names in the file of the dimensions of images that are no grid on the ground; rows count downward."""


@dataclass(frozen=True)
class ImageLayout:
    """Coordinates and extent of an image that is no grid on the ground; its axes are ``row`` and ``column``.

    Attributes
    ----------
    coordinates : tuple of (VariableSpec, ndarray)
        Coordinate variables with their values, in place of those of the grid on the ground; their dimensions are
        those of the file.
    south, north, west, east : float
        Extent of all frames, degrees; longitudes continue beyond 180, so that west <= east.
    """

    coordinates: tuple[tuple[VariableSpec, NDArray[Any]], ...]
    south: float
    north: float
    west: float
    east: float


@dataclass(frozen=True)
class CubeHeader:
    """Coordinates, geometry, variables and provenance of a cube.

    Attributes
    ----------
    start : datetime
        Start of the scenario; must have a time zone.
    frame_times_s : sequence of float (F,)
        Time of each frame after ``start``, increasing.
    bands : tuple of BandInfo
        Bands in the order of the ``band`` dimension.
    rows, columns : int
        Size of a frame.
    pixel_size_m : float
        Edge of the square pixel on the surface.
    latitude, longitude : float
        Centre of the image at the start, degrees north and east.
    view_zenith_deg, view_azimuth_deg : float
        Direction from the surface point to the sensor.
    solar_zenith_deg, solar_azimuth_deg : sequence of float (F,)
        Direction from the surface point to the sun at each frame.
    variables : tuple of VariableSpec
        Data variables to write.
    attributes : mapping
        Global attributes: provenance (the scenario's text belongs under ``hcss_scenario``) and
        replacements for the defaults of the discovery metadata.
    platform_speed_m_s : float
        Speed of the image centre over the ground along +x.
    layers : tuple of LayerInfo
        Cloud layers in the order of the ``layer`` dimension; required if a variable has this dimension.
    window : WindowInfo or None
        Position of the cube in a larger image; None if it covers all of it. ``rows`` and ``columns`` refer to
        the cube, ``latitude`` and ``longitude`` to the centre of the whole image.
    geometry : tuple of VariableSpec
        Per-pixel coordinates to write, from the table in :mod:`hcss_twin.cube.variables`.
    sensor_altitude_m : float or None
        Above the ellipsoid; None if unknown.
    layout : ImageLayout or None
        Of an image that is no grid on the ground; ``pixel_size_m`` is then a typical one, and variables of kind
        ``geometry`` are coordinates of pixels.

    Raises
    ------
    CubeError
        If a value is out of range or lengths are inconsistent.
    """

    start: datetime
    frame_times_s: Sequence[float]
    bands: tuple[BandInfo, ...]
    rows: int
    columns: int
    pixel_size_m: float
    latitude: float
    longitude: float
    view_zenith_deg: float
    view_azimuth_deg: float
    solar_zenith_deg: Sequence[float]
    solar_azimuth_deg: Sequence[float]
    variables: tuple[VariableSpec, ...]
    attributes: Mapping[str, Attribute] = field(default_factory=dict)
    platform_speed_m_s: float = 0.0
    layers: tuple[LayerInfo, ...] = ()
    window: WindowInfo | None = None
    geometry: tuple[VariableSpec, ...] = ()
    sensor_altitude_m: float | None = None
    layout: ImageLayout | None = None

    def __post_init__(self) -> None:
        if self.start.utcoffset() is None:
            raise CubeError(f"start: {self.start.isoformat()} has no time zone")
        _check_sizes(self)
        _check_ranges(self)
        _check_bands(self.bands)
        _check_layers(self.layers)
        check_attributes(self.attributes)

    @property
    def frames(self) -> int:
        """Number of frames."""
        return len(self.frame_times_s)

    @property
    def start_utc(self) -> datetime:
        """Start in UTC."""
        return self.start.astimezone(UTC)

    def in_file(self, dims: tuple[str, ...]) -> tuple[str, ...]:
        """Return the names of dimensions in the file."""
        return dims if self.layout is None else tuple(IMAGE_AXES.get(dim, dim) for dim in dims)

    @property
    def image_window(self) -> WindowInfo:
        """Position of the cube in its image, which may be all of it."""
        return self.window or WindowInfo(0, 0, self.rows, self.columns)

    @property
    def sizes(self) -> dict[str, int]:
        """Length of each dimension of the data variables; ``layer`` only if a variable has it."""
        sizes = {"time": self.frames, "band": len(self.bands), "y": self.rows, "x": self.columns}
        if any(LAYER in spec.dims for spec in self.variables):
            sizes[LAYER] = len(self.layers)
        return sizes


def _check_sizes(header: CubeHeader) -> None:
    for name, size in header.sizes.items():
        if size < 1:
            raise CubeError(f"dimension {name}: length {size}; at least 1 is needed")
    for name in ("solar_zenith_deg", "solar_azimuth_deg"):
        count = len(getattr(header, name))
        if count != header.frames:
            raise CubeError(f"{name}: {count} values for {header.frames} frames")
    window = header.image_window
    for name, first, size, whole in (
        ("rows", window.first_row, header.rows, window.image_rows),
        ("columns", window.first_column, header.columns, window.image_columns),
    ):
        if not 0 <= first <= first + size <= whole:
            raise CubeError(f"window: {size} {name} from {first} on; the image has {whole}")
    names = [spec.name for spec in (*header.variables, *header.geometry)]
    if not names:
        raise CubeError("variables: none; a cube holds at least one")
    repeated = sorted({name for name in names if names.count(name) > 1})
    if repeated:
        raise CubeError(f"variables: named more than once: {', '.join(repeated)}")


def _check_ranges(header: CubeHeader) -> None:
    times = header.frame_times_s
    for index, value in enumerate(times):
        if not math.isfinite(value) or (index > 0 and value <= times[index - 1]):
            raise CubeError(f"frame_times_s[{index}]: {value}; times must be finite and increase from frame to frame")
    ranges = {
        "pixel_size_m": (header.pixel_size_m, math.nextafter(0.0, 1.0), math.inf),
        "latitude": (header.latitude, -90.0, 90.0),
        "longitude": (header.longitude, -180.0, 360.0),
        "view_zenith_deg": (header.view_zenith_deg, 0.0, 90.0),
        "view_azimuth_deg": (header.view_azimuth_deg, -360.0, 360.0),
        "platform_speed_m_s": (header.platform_speed_m_s, -math.inf, math.inf),
    }
    if header.sensor_altitude_m is not None:
        ranges["sensor_altitude_m"] = (header.sensor_altitude_m, math.nextafter(0.0, 1.0), math.inf)
    for index in range(header.frames):
        ranges[f"solar_zenith_deg[{index}]"] = (header.solar_zenith_deg[index], 0.0, 180.0)
        ranges[f"solar_azimuth_deg[{index}]"] = (header.solar_azimuth_deg[index], -360.0, 360.0)
    for name, (value, low, high) in ranges.items():
        if not (math.isfinite(value) and low <= value <= high):
            raise CubeError(f"{name}: {value} is outside {low:g} to {high:g}")


def _check_bands(bands: tuple[BandInfo, ...]) -> None:
    names = [band.name for band in bands]
    for band in bands:
        if not band.name or names.count(band.name) > 1:
            raise CubeError(f"bands: the name '{band.name}' is empty or used more than once")
        if not 0.0 < band.lower_um < band.central_um < band.upper_um < math.inf:
            raise CubeError(
                f"band '{band.name}': {band.lower_um}, {band.central_um}, {band.upper_um} um; "
                "lower limit, centre and upper limit must increase"
            )


def _check_layers(layers: tuple[LayerInfo, ...]) -> None:
    for layer in layers:
        if not layer.name or not -math.inf < layer.base_m < layer.top_m < math.inf:
            raise CubeError(
                f"layer '{layer.name}': {layer.base_m} to {layer.top_m} m; a layer needs a name and a base below "
                "its top"
            )


def check_attributes(attributes: Mapping[str, Attribute]) -> None:
    """Check that values of global attributes can be stored; raises :class:`CubeError`."""
    for name, value in attributes.items():
        if isinstance(value, bool) or not isinstance(value, str | float | int):
            raise CubeError(f"attribute {name}: {type(value).__name__}; text, float or integer is allowed")
        if isinstance(value, int) and not -(2**63) <= value < 2**63:
            raise CubeError(f"attribute {name}: {value} does not fit 64 bits; give it as text")
        if isinstance(value, str) and "\0" in value:
            raise CubeError(f"attribute {name}: a NUL character cannot be stored")
