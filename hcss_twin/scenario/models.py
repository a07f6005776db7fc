"""The sections of a scenario file, each key with its unit, range, default and meaning.

The JSON schema, the reference page and the error messages are made from these models.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, ValidationInfo, field_validator, model_validator
from pydantic_core import PydanticCustomError

from hcss_twin.core.errors import closest, shown
from hcss_twin.models.atmosphere.profile_file import STANDARD
from hcss_twin.providers.registry.registry import OWN_DISTRIBUTION
from hcss_twin.scenario.accuracy import Accuracy
from hcss_twin.scenario.bands import Bands
from hcss_twin.scenario.bands import ResponseBand as ResponseBand
from hcss_twin.scenario.section_types import (
    LARGEST_UM,
    MAX_WATER_KG_M3,
    NARROWEST,
    WIDEST,
    ImageWindow,
    Instant,
    Platform,
    PlatformSpeed,
    Section,
)
from hcss_twin.scenario.sensor import Sensor
from hcss_twin.scenario.units import (
    Angle,
    Duration,
    Fraction,
    Length,
    Number,
    ParticleRadius,
    Speed,
    Temperature,
    WaterContent,
    Whole,
    parse_quantity,
)


def selected(section: Section, key: str) -> str:
    """Name by which a section selects its provider.

    A provider the user did not name is ours, whatever else is installed under the same name.
    """
    name: str = getattr(section, key)
    return name if key in section.model_fields_set else own(name)


def own(name: str) -> str:
    """Qualified name of a default provider."""
    return f"{OWN_DISTRIBUTION}/{name}"


class Place(Section):
    """Where the scene's first image centre lies."""

    latitude: Angle = Field(ge=-90, le=90, description="Latitude, degrees north.")
    longitude: Angle = Field(ge=-180, le=360, description="Longitude, degrees east.")


class View(Section):
    """Direction from the surface point to the sensor."""

    zenith: Angle = Field(0.0, ge=0, le=85, description="Zenith angle at the surface point, degrees.")
    azimuth: Angle = Field(
        0.0, ge=0, lt=360, description="Bearing from the surface point toward the sensor, degrees clockwise from north."
    )


MAX_PIXELS = 100_000
"""Rows, and columns, of the largest image."""


class Image(Section):
    """Shape and sampling of one frame: x along columns (east), y along rows (north)."""

    rows: Whole = Field(800, ge=1, le=MAX_PIXELS, description="Number of rows (y).")
    columns: Whole = Field(800, ge=1, le=MAX_PIXELS, description="Number of columns (x).")
    pixel_size: Length = Field(20.0, gt=0, le=100_000, description="Side of the square ground pixel, m.")
    samples_per_pixel: Whole = Field(
        1,
        ge=1,
        le=64,
        description="n: each pixel is the mean over n x n points of its footprint; 1 takes the point at its centre.",
    )
    window: ImageWindow | None = Field(
        None,
        description="Part of the image that is computed, for example {rows = [0, 400], columns = [200, 600]}: from the "
        "first, counted from 0, up to but without the end, all where one is left out; "
        "default: all of it.",
    )

    @field_validator("window")
    @classmethod
    def _inside(cls, window: ImageWindow | None, info: ValidationInfo) -> ImageWindow | None:
        rows, columns = info.data.get("rows"), info.data.get("columns")
        # Where rows or columns are wrong themselves, that is told, and nothing can be said about the window.
        return window.within(rows, columns) if window and rows and columns else window


class Frames(Section):
    """The time series."""

    count: Whole = Field(8, ge=1, le=1_000_000, description="Number of frames.")
    interval: Duration = Field(1.0, gt=0, le=1e6, description="Time between frames, s.")
    first: Whole = Field(
        0, ge=0, le=10_000_000, description="Index of the first frame; frame n is at start + n x interval."
    )


def _evolution_time(value: object) -> object:
    if value == "frozen":
        return value
    allowed = 'allowed: 0.001 to 1e12 s, or "frozen"'
    if isinstance(value, str) and closest(value, ("frozen",)):
        raise PydanticCustomError("evolution_time", f"{shown(value)} is not a duration; {allowed}; closest is 'frozen'")
    number = parse_quantity(value, "duration")
    if isinstance(number, bool) or not isinstance(number, int | float):
        raise PydanticCustomError("evolution_time", f"{shown(value)} is not a duration; {allowed}")
    if not 1e-3 <= number <= 1e12:
        hint = "; closest valid choice is 0.001" if number < 1 else "; closest valid choice is 'frozen'"
        hint = "" if number != number else hint  # NaN is close to nothing
        raise PydanticCustomError("evolution_time", f"{shown(value)} is out of range; {allowed}{hint}")
    return float(number)


EvolutionTime = Annotated[Duration | Literal["frozen"], BeforeValidator(_evolution_time)]


class Motion(Section):
    """What moves and changes between frames."""

    platform_speed: PlatformSpeed = Field(
        0.0,
        description="Ground speed of the image footprint toward +x (east), m/s, -1e5 to 1e5; 0 stares; "
        '"orbit": that of a circular orbit at `platform.altitude`.',
    )
    wind_speed: Speed = Field(10.0, ge=0, le=150, description="Wind that carries the clouds, m/s.")
    wind_from: Angle = Field(
        270.0, ge=0, lt=360, description="Bearing the cloud wind comes from, degrees clockwise from north."
    )
    evolution_time: EvolutionTime = Field(
        1800.0,
        description='Time in which the largest cloud structures change, s, 0.001 to 1e12; "frozen" keeps every shape.',
    )


class Atmosphere(Section):
    """The gas between sea, clouds and sensor."""

    provider: str = Field("band-model", description="Transmittance provider (see `hcss plugins`).")
    profile: str | None = Field(
        None,
        description="Profile: a catalog name, or a CSV or NetCDF file; default: the provider's own, or the model "
        "atmosphere for place and date.",
    )
    profile_above: str = Field(
        STANDARD, description="Profile that completes a file: the air above its last level and the gases it leaves out."
    )
    water_vapour_scale: Number | None = Field(
        None, ge=0, le=10, description="Factor on the profile's water vapour, at all levels."
    )
    water_vapour_column: Number | None = Field(
        None,
        ge=0,
        le=100,
        description="Column of water vapour to scale the profile to, kg m-2; not beside water_vapour_scale.",
    )
    parameters: dict[str, Any] = Field(default_factory=dict, description="Parameters of the provider.")

    @model_validator(mode="after")
    def _one_amount(self) -> Self:
        if self.water_vapour_scale is not None and self.water_vapour_column is not None:
            raise PydanticCustomError(
                "water_vapour", "water_vapour_scale beside water_vapour_column; allowed: one of them"
            )
        return self


class Layer(Section):
    """One cloud layer."""

    type: str = Field("stratus", description="Cloud type: a catalog name or a TOML file of the same form.")
    coverage: Fraction = Field(0.5, ge=0, le=1, description="Fraction of cloudy pixels.")
    coverage_mode: Literal["frame", "field"] = Field(
        "frame",
        description='"frame": exactly the coverage in every frame; "field": one threshold for the unbounded sky, '
        "exact in the mean and the same for every sensor. As far as the generator honours it: `hcss plan` says where "
        "it may not.",
    )
    edge_taper: Fraction = Field(
        0.0,
        ge=0,
        le=1,
        description="Part of the cloudy area, from the edge inward, over which thickness rises smoothly from its "
        "minimum; 0 is eq 7 as printed. As far as the generator honours it; `imagery` and `surrogate` refuse it.",
    )
    generator: str = Field("fractal", description="Cloud generator (see `hcss plugins`).")
    base: Length | None = Field(
        None, ge=0, le=20_000, description="Altitude of the cloud base, m; default: the type's."
    )
    top: Length | None = Field(
        None, gt=0, le=20_000, description="Altitude of the highest cloud top, m; default: the type's."
    )
    thickness_min: Length | None = Field(
        None, gt=0, le=20_000, description="Thickness of the thinnest cloudy pixel, m; default: the type's."
    )
    anchor: Literal["base", "top"] | None = Field(
        None, description="Which side of a thin cloud stays at its altitude; default: the type's."
    )
    temperature: Temperature | None = Field(
        None, ge=150, le=350, description="Cloud temperature, K; default: the profile's at the cloud top."
    )
    phase: Literal["water", "ice"] | None = Field(
        None, description="Phase of the particles; default: the type's. The mass per volume stays."
    )
    effective_radius: ParticleRadius | None = Field(
        None, gt=0, le=LARGEST_UM, description="Area-weighted mean radius of the particles, um; default: the type's."
    )
    effective_variance: Number | None = Field(
        None,
        ge=NARROWEST,
        le=WIDEST,
        description="Width of the area-weighted distribution of radii; default: the type's.",
    )
    water_content: WaterContent | None = Field(
        None,
        gt=0,
        le=1000.0 * MAX_WATER_KG_M3,
        description="Liquid water or ice per volume of cloud, g m-3; default: the type's.",
    )
    parameters: dict[str, Any] = Field(default_factory=dict, description="Parameters of the generator.")


MAX_LAYERS = 2
"""Cloud layers that a scene can have."""


class Clouds(Section):
    """Cloud layers, at most two and one above the other; keys of a single layer may stand in `[clouds]` itself."""

    layers: tuple[Layer, ...] = Field(
        (),
        max_length=MAX_LAYERS,
        description="`[[clouds.layers]]`: up to two layers, one above the other, in either order.",
    )

    @model_validator(mode="before")
    @classmethod
    def _single_layer(cls, data: Any) -> Any:
        return single_layer(data)


def has_single_layer(data: Any) -> bool:
    """Whether the keys of a single layer stand in a raw ``[clouds]`` itself."""
    return isinstance(data, dict) and any(key != "layers" for key in data)


def single_layer(data: Any) -> Any:
    """Move the keys of a single layer from ``[clouds]`` into ``layers``.

    Raises
    ------
    PydanticCustomError
        If ``data`` is no table, or the keys stand beside ``layers``.
    """
    if isinstance(data, Clouds):
        return data
    keys = tuple(Layer.model_fields)
    if not isinstance(data, dict):
        hint = f"; closest valid choice is {{type = {shown(data)}}}" if isinstance(data, str) else ""
        raise PydanticCustomError(
            "clouds", f"{shown(data)} is not a table; allowed: a table with the keys {', '.join(keys)}{hint}"
        )
    if not has_single_layer(data):
        return data
    short = {key: value for key, value in data.items() if key != "layers"}
    if "layers" in data:
        raise PydanticCustomError(
            "layers",
            f"{', '.join(map(shown, short))} beside [[clouds.layers]]; allowed: the keys of the layer in [clouds] or "
            "in [[clouds.layers]], not in both",
        )
    for key in short:
        if isinstance(key, str) and key not in keys and closest(key, (*keys, "layers")) == "layers":
            raise PydanticCustomError(
                "layers", f"unknown key {shown(key)}; closest is 'layers', as in [[clouds.layers]]"
            )
    return {"layers": [short]}


class Slant(Section):
    """Where slant paths of sight and sunlight meet the clouds; off, each pixel is a column of its own.

    With either option on, layers need `coverage_mode = "field"` and a generator that gives windows, because slant
    paths leave the image (docs/shadows-and-parallax.md).
    """

    shadows: bool = Field(
        False, description="Clouds between sun and sea take the direct sunlight from clear points in their shadow."
    )
    parallax: bool = Field(
        False, description="Clouds appear where the slant line of sight meets them, displaced from the sea below them."
    )


class Sea(Section):
    """The sea surface."""

    model: str = Field("rough-sea", description="Sea model (see `hcss plugins`).")
    temperature: Temperature | None = Field(
        None, ge=260, le=330, description="Skin temperature, K; default: the climatology's for place and date."
    )
    wind_speed: Speed | None = Field(
        None, ge=0, le=60, description="Wind speed over the sea, m/s; default: the climatology's for place and date."
    )
    wind_from: Angle = Field(
        270.0, ge=0, lt=360, description="Bearing the sea wind comes from, degrees clockwise from north."
    )
    waves: Literal["averaged", "resolved", "auto"] = Field(
        "averaged",
        description='Waves longer than two pixels: "averaged" over, the plan says what that leaves out at most; '
        '"resolved": drawn in clear pixels; "auto": drawn where that changes more than the accuracy and the model can.',
    )
    parameters: dict[str, Any] = Field(default_factory=dict, description="Parameters of the model.")


class Optics(Section):
    """Optical properties of the cloud particles."""

    provider: str = Field("bulk", description="Optics provider (see `hcss plugins`).")
    parameters: dict[str, Any] = Field(default_factory=dict, description="Parameters of the provider.")


class Radiance(Section):
    """How the terms of radiance are put together."""

    model: str = Field("physical", description="Radiance model (see `hcss plugins`).")
    parameters: dict[str, Any] = Field(default_factory=dict, description="Parameters of the model.")


class Output(Section):
    """What the cube holds."""

    variables: tuple[str, ...] = Field(
        ("radiance", "cloud_mask"),
        min_length=1,
        description='Output variables, or the groups "terms", "truth", "geometry" and "all".',
    )
    compression: Whole = Field(0, ge=0, le=9, description="zlib level; 0 writes uncompressed, which is fastest.")
    quantization: Fraction = Field(
        0.0,
        ge=0,
        le=0.05,
        description="Relative error that rounding of the stored numbers may make, a share or text with %, at most "
        "three tenths of accuracy, so that they compress better; 0 stores all digits. Temperatures are rounded sixteen "
        "times as finely.",
    )
    certificate: Whole = Field(
        24,
        ge=0,
        le=3000,
        description="Random pixels that are computed again without tables to certify the accuracy "
        "(docs/certificate.md); 0 for none.",
    )


class ScenarioModel(Section):
    """A whole scenario file."""

    title: str = Field("", max_length=200, description="Title of the cube.")
    seed: Whole = Field(0, ge=0, lt=2**63, description="Seed of every random choice.")
    accuracy: Accuracy = Field(
        1e-3,
        description="Error allowed to the engine: a share of the total radiance of the band (1e-6 to 0.1), or text "
        'with a unit: % of the radiance, or K or mK of its brightness temperature (`"0.1 K"`; 0.001 to 10 K).',
    )
    time: Instant = Field(description="Start: date and time with zone, for example 2024-04-20T12:30:00+10:00.")
    place: Place = Field(
        description="Where the first image centre lies, for example {latitude = 35.0, longitude = 150.0}."
    )
    view: View = Field(default_factory=lambda: View.model_validate({}), description="Viewing direction.")
    platform: Platform = Field(
        default_factory=lambda: Platform.model_validate({}), description="Platform and instrument."
    )
    image: Image = Field(default_factory=lambda: Image.model_validate({}), description="Image shape.")
    frames: Frames = Field(default_factory=lambda: Frames.model_validate({}), description="Time series.")
    motion: Motion = Field(default_factory=lambda: Motion.model_validate({}), description="Motion.")
    bands: Bands = Field(
        ("swir-2.7-3.0", "mwir", "lwir"),
        min_length=1,
        max_length=100,
        description="Bands: catalog names, [shortest_um, longest_um], {name, response}, {name, limits} or "
        "{name, center_um, fwhm_um}.",
    )
    atmosphere: Atmosphere = Field(default_factory=lambda: Atmosphere.model_validate({}), description="Atmosphere.")
    clouds: Clouds = Field(default_factory=lambda: Clouds.model_validate({}), description="Clouds; none by default.")
    slant: Slant = Field(
        default_factory=lambda: Slant.model_validate({}), description="Shadows and parallax of clouds."
    )
    sea: Sea = Field(default_factory=lambda: Sea.model_validate({}), description="Sea.")
    optics: Optics = Field(default_factory=lambda: Optics.model_validate({}), description="Cloud optics.")
    radiance: Radiance = Field(default_factory=lambda: Radiance.model_validate({}), description="Radiance model.")
    output: Output = Field(default_factory=lambda: Output.model_validate({}), description="Output.")
    sensor: Sensor | None = Field(None, description="Sensor; none by default.")
