"""The sections of clouds and of the optical properties of their particles."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, model_validator
from pydantic_core import PydanticCustomError

from hcss_twin.core.errors import Problem
from hcss_twin.core.units import ParticleRadius, WaterContent, quantity_or_word
from hcss_twin.core.units import QuantityParser as Quantity
from hcss_twin.scenario.section_types import (
    LARGEST_UM,
    MAX_WATER_KG_M3,
    MIN_WATER_G_M3,
    NARROWEST,
    SMALLEST_UM,
    THINNEST_M,
    WIDEST,
    Material,
    ScenarioSection,
)


class OpticsSection(ScenarioSection):
    """Optical properties of the cloud particles, of layers without an `optics` table of their own."""

    provider: str = Field("bulk", description="Optics provider (see `hcss plugins`).")
    parameters: dict[str, Any] = Field(default_factory=dict, description="Parameters of the provider.")


CloudTemperature = Annotated[
    Annotated[Quantity.Temperature, Field(ge=150, le=350)] | Literal["climatology"],
    BeforeValidator(quantity_or_word("temperature", 150.0, 350.0, "climatology", above="350")),
]


class Layer(ScenarioSection):
    """One cloud layer."""

    type: str = Field("stratus", description="Cloud type: catalog name or TOML file.")
    coverage: Quantity.Fraction = Field(0.5, ge=0, le=1, description="Fraction of cloudy pixels.")
    coverage_mode: Literal["frame", "field"] | None = Field(
        None,
        description='"frame": exactly this coverage in every frame; "field": one threshold for the '
        'unbounded sky, exact in the mean; default: "field" for several frames that differ '
        'and for cameras, if the generator can, else "frame".',
    )
    edge_taper: Quantity.Fraction = Field(
        0.0,
        ge=0,
        le=1,
        description="Part of the cloudy area, from the edge inward, over which thickness rises smoothly; "
        "0 is eq 7 as printed.",
    )
    generator: str = Field("fractal", description="Cloud generator (see `hcss plugins`).")
    base: Quantity.Length | None = Field(
        None,
        ge=0,
        le=20_000,
        description="Altitude of the base, m; default: that of the type, as for all keys below without a default.",
    )
    top: Quantity.Length | None = Field(None, ge=THINNEST_M, le=20_000, description="Altitude of the highest top, m.")
    thickness_min: Quantity.Length | None = Field(
        None, ge=THINNEST_M, le=20_000, description="Thickness of the thinnest cloudy pixel, m."
    )
    anchor: Literal["base", "top"] | None = Field(None, description="Side of a thin cloud that stays at its altitude.")
    temperature: CloudTemperature | None = Field(
        None,
        description='Cloud temperature, K, 150 to 350, or "climatology": that of the top by place and date; default: '
        "that of the air at the cloud top.",
    )
    material: Material | None = Field(None, description="What the particles are made of; the mass per volume stays.")
    effective_radius: ParticleRadius | None = Field(
        None, ge=SMALLEST_UM, le=LARGEST_UM, description="Area-weighted mean radius of the particles, um."
    )
    effective_variance: Quantity.Number | None = Field(
        None, ge=NARROWEST, le=WIDEST, description="Relative variance of the area-weighted distribution of radii."
    )
    water_content: WaterContent | None = Field(
        None,
        ge=MIN_WATER_G_M3,
        le=1000.0 * MAX_WATER_KG_M3,
        description="Mass of particles per volume of cloud, g m-3.",
    )
    wind_speed: Quantity.Speed | None = Field(
        None, ge=0, le=150, description="Wind at this layer, m/s; default: `motion.wind_speed`."
    )
    wind_from: Quantity.Angle | None = Field(
        None,
        ge=0,
        lt=360,
        description="Bearing the wind at this layer comes from, degrees; default: `motion.wind_from`.",
    )
    optics: OpticsSection | None = Field(
        None, description="Table of keys as in `[optics]`: the optics of this layer; default: those of the scene."
    )
    parameters: dict[str, Any] = Field(default_factory=dict, description="Parameters of the generator.")


MAX_LAYERS = 5
"""Maximum number of cloud layers of a scene."""


class Clouds(ScenarioSection):
    """Cloud layers: none, one, or several, one above the other.

    Without keys in this section the sky is clear. The defaults below apply to each layer that you specify.
    """

    layers: tuple[Layer, ...] = Field(
        (),
        max_length=MAX_LAYERS,
        description="`[[clouds.layers]]`: up to five layers, one above the other, in any order.",
    )

    @model_validator(mode="before")
    @classmethod
    def _single_layer(cls, data: Any) -> Any:
        return single_layer(data)


def has_single_layer(data: Any) -> bool:
    """Whether a raw ``[clouds]`` has the keys of a single layer."""
    return isinstance(data, dict) and any(key != "layers" for key in data)


def single_layer(data: Any) -> Any:
    """Move the keys of a single layer from ``[clouds]`` into ``layers``.

    Raises
    ------
    PydanticCustomError
        If ``data`` is not a table, or has these keys as well as ``layers``.
    """
    if isinstance(data, Clouds):
        return data
    keys = tuple(Layer.model_fields)
    if not isinstance(data, dict):
        hint = f"; closest valid choice is {{type = {Problem.shown(data)}}}" if isinstance(data, str) else ""
        raise PydanticCustomError(
            "clouds", f"{Problem.shown(data)} is not a table; allowed: a table with the keys {', '.join(keys)}{hint}"
        )
    if not has_single_layer(data):
        return data
    short = {key: value for key, value in data.items() if key != "layers"}
    if "layers" in data:
        raise PydanticCustomError(
            "layers",
            f"{', '.join(map(Problem.shown, short))} with [[clouds.layers]]; allowed: the keys of the layer in "
            "[clouds] or in [[clouds.layers]], not in both",
        )
    for key in short:
        if isinstance(key, str) and key not in keys and Problem.closest(key, (*keys, "layers")) == "layers":
            raise PydanticCustomError(
                "layers", f"unknown key {Problem.shown(key)}; closest is 'layers', as in [[clouds.layers]]"
            )
    return {"layers": [short]}
