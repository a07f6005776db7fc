"""Parameters of the surface providers of this package."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field

from hcss_twin.core.units import QuantityParser as Quantity

_EACH = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class CoastParameters(BaseModel):
    """Parameters of the surface provider ``coast``."""

    model_config = _EACH

    land: str = Field(
        "land", min_length=1, description="Class of land: land, vegetation, forest, tundra, soil, sand, rock or snow."
    )
    land_temperature: Quantity.Temperature | None = Field(
        None, ge=180, le=350, description="Of land, K; default: that of the air at the surface."
    )


class RasterParameters(BaseModel):
    """Parameters of the surface provider ``raster``; `classes`, `temperature` or both."""

    model_config = _EACH

    file: str = Field(min_length=1, description="GeoTIFF, or NetCDF with latitude and longitude along its dimensions.")
    classes: dict[int, str] = Field(
        default_factory=dict,
        description='Name of the class of each number in the file, e.g. {0 = "sea", 1 = "ice"}; default: all is sea.',
    )
    class_layer: str | None = Field(
        None, description="Band (from 1) or variable of the classes; default: the first, or `surface_class`."
    )
    temperature_layer: str | None = Field(
        None, description="Band (from 1) or variable of the temperature, K; default: no field of temperature."
    )
    temperatures: dict[str, Quantity.Temperature] = Field(
        default_factory=dict,
        description="Temperature of classes, K, instead of the layer's; default without a layer: that of the sea or of "
        "the air at the surface.",
    )
