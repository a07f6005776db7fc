"""The sections of a scenario file, each key with its unit, range, default and meaning.

The JSON schema, the reference page and the error messages follow these models.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, ValidationInfo, field_validator

from hcss_twin.core.units import Accuracy, quantity_or_word
from hcss_twin.core.units import QuantityParser as Quantity
from hcss_twin.scenario.atmosphere import Atmosphere
from hcss_twin.scenario.bands import Bands
from hcss_twin.scenario.clouds import Clouds, OpticsSection
from hcss_twin.scenario.instrument import InstrumentSection
from hcss_twin.scenario.section_types import (
    ImageWindow,
    Instant,
    Platform,
    PlatformSpeed,
    ScenarioSection,
    Switch,
    filled,
)
from hcss_twin.scenario.sensor import SensorSection


class PlaceSection(ScenarioSection):
    """Centre of the image at the start."""

    latitude: Quantity.Angle = Field(ge=-90, le=90, description="Latitude, degrees north.")
    longitude: Quantity.Angle = Field(ge=-180, le=360, description="Longitude, degrees east.")


class ViewSection(ScenarioSection):
    """Direction from the surface point to the sensor."""

    zenith: Quantity.Angle = Field(0.0, ge=0, le=85, description="Zenith angle at the surface point, degrees.")
    azimuth: Quantity.Angle = Field(
        0.0, ge=0, lt=360, description="Bearing from the surface point toward the sensor, degrees."
    )


MAX_PIXELS = 100_000
"""Maximum number of rows and of columns of an image."""


class ImageSection(ScenarioSection):
    """Shape and sampling of one frame: x along columns (east), y along rows (north)."""

    rows: Quantity.Whole = Field(800, ge=1, le=MAX_PIXELS, description="Number of rows (y).")
    columns: Quantity.Whole = Field(800, ge=1, le=MAX_PIXELS, description="Number of columns (x).")
    pixel_size: Quantity.Length = Field(20.0, ge=1e-3, le=100_000, description="Side of the square ground pixel, m.")
    samples_per_pixel: Quantity.Whole = Field(
        1,
        ge=1,
        le=64,
        description="n: a pixel is the mean of n x n points of its footprint; 1: the point at its centre.",
    )
    window: ImageWindow | None = Field(None, description="Part of the image to compute; default: all.")

    @field_validator("window")
    @classmethod
    def _inside(cls, window: ImageWindow | None, info: ValidationInfo) -> ImageWindow | None:
        rows, columns = info.data.get("rows"), info.data.get("columns")
        # invalid rows or columns are reported at their own keys; the window cannot be checked then
        return window.within(rows, columns) if window and rows and columns else window


class Frames(ScenarioSection):
    """The time series."""

    count: Quantity.Whole = Field(8, ge=1, le=1_000_000, description="Number of frames.")
    interval: Quantity.Duration = Field(1.0, gt=0, le=1e6, description="Time between frames, s.")
    first: Quantity.Whole = Field(
        0, ge=0, le=10_000_000, description="Number of the first frame; frame n is at start + n x interval."
    )


EvolutionTime = Annotated[
    Quantity.Duration | Literal["frozen", "by-scale"],
    BeforeValidator(quantity_or_word("duration", 1e-3, 1e12, "frozen", "by-scale", above="'frozen'")),
]


class MotionSection(ScenarioSection):
    """Motion of platform and clouds, and evolution of cloud shapes."""

    platform_speed: PlatformSpeed = Field(
        0.0,
        description='Ground speed of the footprint toward +x (east), m/s, -1e5 to 1e5, or "orbit": that '
        "of a circular orbit.",
    )
    wind_speed: Quantity.Speed = Field(10.0, ge=0, le=150, description="Wind at the clouds, m/s.")
    wind_from: Quantity.Angle = Field(
        270.0, ge=0, lt=360, description="Bearing the wind at the clouds comes from, degrees."
    )
    evolution_time: EvolutionTime = Field(
        "by-scale",
        description='Time in which the largest cloud structures change, s, 0.001 to 1e12, "frozen", or '
        '"by-scale": fractal clouds change in 165 s per km of wavelength, below 8 km as '
        "turbulence does; others as with 1800 s.",
    )


class Slant(ScenarioSection):
    """Slant paths of sight and sunlight through clouds.

    They leave the image, so that they need a cloud generator that knows the clouds around it. "auto": where the scene
    can have them and they matter at this accuracy.
    """

    shadows: Switch = Field(
        "auto", description='Clouds shade clear points of the sea from direct sunlight: "auto", "on" or "off".'
    )
    parallax: Switch = Field(
        "auto", description='Clouds appear where the slant line of sight meets them: "auto", "on" or "off".'
    )


class Sea(ScenarioSection):
    """The sea surface."""

    model: str = Field("rough-sea", description="Sea model (see `hcss plugins`).")
    temperature: Quantity.Temperature | None = Field(
        None, ge=260, le=330, description="Skin temperature, K; default: climatology for place and date."
    )
    wind_speed: Quantity.Speed | None = Field(
        None, ge=0, le=60, description="Wind speed at 10 m, m/s; default: climatology for place and date."
    )
    wind_from: Quantity.Angle = Field(
        270.0, ge=0, lt=360, description="Bearing the wind over the sea comes from, degrees."
    )
    waves: Switch = Field(
        "auto",
        description='Waves longer than two pixels: "on": as shapes, in clear pixels; "off": statistical; '
        '"auto": as shapes if they matter and the model can.',
    )
    temperature_texture: Quantity.Number | None = Field(
        None,
        ge=0,
        le=3,
        description="Standard deviation of the skin temperature over some hundred km, K: a random field "
        "with the spectrum of measured sea; 0: one temperature; default: 0.3 where that "
        "matters.",
    )
    parameters: dict[str, Any] = Field(default_factory=dict, description="Parameters of the model.")


class Radiance(ScenarioSection):
    """Assembly of the terms of radiance."""

    model: str = Field("physical", description="Radiance model (see `hcss plugins`).")
    parameters: dict[str, Any] = Field(default_factory=dict, description="Parameters of the model.")
    light: str = Field(
        "auto",
        pattern="^[a-z][a-z0-9-]*$",
        max_length=40,
        description='Sides of clouds: "columns": none; with the plugin hcss-light "slant": slanted rays; '
        '"source": light scattered many times, too; "reference": Monte Carlo of small images;'
        ' "auto": the cheapest expected to be within `light_accuracy`, columns without it.',
    )
    light_profile: Literal["uniform", "adiabatic"] = Field(
        "uniform",
        description='Extinction in a cloud for `light`; "adiabatic": as the power 2/3 of the height above its base.',
    )
    light_accuracy: Quantity.Fraction | None = Field(
        None, gt=0, le=1, description="Error of `light` to choose it by, or to note (rms over pixels, relative)."
    )

    @property
    def is_between_columns(self) -> bool:
        """Whether light between columns is asked for, or left to the plan to choose."""
        return self.light != "columns" and (self.light != "auto" or self.light_accuracy is not None)


class ElementSection(ScenarioSection):
    """Other things in the scene, from the surface to above the clouds: one `[[elements]]` section for each provider."""

    provider: str = Field("point-sources", description="Element provider (see `hcss plugins`).")
    parameters: dict[str, Any] = Field(default_factory=dict, description="Parameters of the provider.")


class SurfaceSection(ScenarioSection):
    """A map of the ground: sea, land, ice and their temperatures. Without this section there is sea everywhere."""

    provider: str = Field("coast", description="Surface provider (see `hcss plugins`).")
    parameters: dict[str, Any] = Field(default_factory=dict, description="Parameters of the provider.")


class DerivedSection(ScenarioSection):
    """Variables of a provider, derived from radiance, truth and geometry: one `[[output.derived]]` for each provider.

    Request them by name in `output.variables`.
    """

    provider: str = Field(description="Variable provider (see `hcss plugins`).")
    parameters: dict[str, Any] = Field(default_factory=dict, description="Parameters of the provider.")


class OutputSection(ScenarioSection):
    """Contents of the cube."""

    variables: tuple[str, ...] = Field(
        ("radiance", "cloud_mask"),
        min_length=1,
        description='Output variables, or groups: "terms", "truth", "geometry", "all".',
    )
    derived: tuple[DerivedSection, ...] = Field(
        (),
        max_length=100,
        description="`[[output.derived]]` with `provider` and `parameters`: variables of plugins. Request "
        "them by name.",
    )
    compression: Quantity.Whole = Field(0, ge=0, le=9, description="zlib level; 0: uncompressed, fastest.")
    quantization: Quantity.Fraction = Field(
        0.0,
        ge=0,
        le=0.05,
        description="Largest relative error of rounding stored numbers, for better compression, up to 0.3"
        " x accuracy; 0: all digits.",
    )
    packing: Literal["int16"] | None = Field(
        None,
        description='"int16": variables of known range are stored as 16-bit integers (CF `scale_factor`),'
        " in steps of at most 0.6 x accuracy; half the bytes. Radiance that such steps do not"
        " fit stays in single precision.",
    )
    certificate: Quantity.Whole = Field(
        24, ge=0, le=3000, description="Random pixels recomputed without tables to certify the accuracy; 0: none."
    )
    store_inputs: bool = Field(
        True, description="Store your input files of at most 256 kB in the cube; false: only their SHA-256."
    )


class ScenarioModel(ScenarioSection):
    """A whole scenario file."""

    title: str = Field("", max_length=200, description="Title of the cube.")
    seed: Quantity.Whole = Field(0, ge=0, lt=2**63, description="Seed of every random choice.")
    accuracy: Accuracy = Field(
        1e-3,
        description="Allowed error of the engine: a fraction of the band radiance (1e-6 to 0.1), or text with %, K or "
        'mK, the latter of brightness temperature (`"0.1 K"`; 0.001 to 10 K).',
    )
    time: Instant = Field(description="Start, with time zone, for example 2024-04-20T12:30:00+10:00.")
    place: PlaceSection = Field(
        description="Centre of the first image, for example {latitude = 35.0, longitude = 150.0}."
    )
    view: ViewSection = filled(ViewSection, "Viewing direction.")
    platform: Platform = filled(Platform, "Platform and instrument.")
    image: ImageSection = filled(ImageSection, "Image shape.")
    frames: Frames = filled(Frames, "Time series.")
    motion: MotionSection = filled(MotionSection, "Motion.")
    bands: Bands = Field(
        ("swir-2.7-3.0", "mwir", "lwir"),
        min_length=1,
        max_length=100,
        description="Catalog names, [shortest_um, longest_um], {name, response}, {name, limits} or "
        "{name, center_um, fwhm_um}.",
    )
    atmosphere: Atmosphere = filled(Atmosphere, "Atmosphere.")
    clouds: Clouds = filled(Clouds, "Clouds; without layers the sky is clear.")
    slant: Slant = filled(Slant, "Shadows and parallax of clouds.")
    sea: Sea = filled(Sea, "Sea.")
    optics: OpticsSection = filled(OpticsSection, "Cloud optics.")
    radiance: Radiance = filled(Radiance, "Radiance model.")
    elements: tuple[ElementSection, ...] = Field(
        (), max_length=255, description="`[[elements]]`: other things in the scene; higher ones hide lower ones."
    )
    surfaces: SurfaceSection | None = Field(None, description="Map of the ground; sea everywhere by default.")
    output: OutputSection = filled(OutputSection, "Output.")
    instrument: str | InstrumentSection | None = Field(
        None,
        description="Catalog name or file of an instrument, or `[instrument]`: replaces keys of camera, image, "
        "platform, bands and sensor.",
    )
    sensor: SensorSection | None = Field(None, description="Sensor; none by default.")
