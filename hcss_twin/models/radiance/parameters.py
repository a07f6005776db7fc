"""Parameters of the radiance models."""

from __future__ import annotations

from typing import Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator


class AsPrintedParameters(BaseModel):
    """Parameters of the ``as-printed`` model.

    The four ``literal_...`` switches restore forms of the HCSS paper that its own tables exclude.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)

    glint_scale: float = Field(
        1.0,
        ge=0,
        le=10,
        description="Factor on the sunlight reflected by the sea; 0.162 fits Tables II and IV, 1 is eq 18.",
    )
    cloud_sun_scale: float = Field(
        1.0,
        ge=0,
        le=10,
        description="Factor on the sunlight reflected by the cloud; 0 fits Tables II and IV, 1 is eq 16.",
    )
    literal_eq14: bool = Field(False, description="Scattering angle with the printed sign of eq 14.")
    literal_eq18: bool = Field(False, description="Sunlight on the sea crosses the air once, from sea to sensor.")
    literal_eq19: bool = Field(False, description="Path radiance of the full column over clouds.")
    literal_eq20: bool = Field(False, description="Adds the sea unattenuated by the cloud as well as through it.")


class PhysicalParameters(BaseModel):
    """Parameters of the ``physical`` models: how accurate, and what to leave out."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    streams: int = Field(8, ge=2, le=32, description="Gauss streams per hemisphere, for diffuse light and the sky.")
    closure_order: int = Field(
        1,
        ge=0,
        le=2,
        description="Changes of direction up to which the absorption of whole paths is exact; later ones see gas as "
        "along the view.",
    )
    sun_streams: int = Field(
        8, ge=2, le=64, description="Gauss streams for sunlight that clouds scatter toward the sensor."
    )
    azimuth_modes: int = Field(
        16,
        ge=1,
        le=128,
        description="Terms of the Fourier series over azimuth for sunlight; at most twice sun_streams.",
    )
    cloud_temperature: Literal["profile", "isothermal-top"] = Field(
        "profile",
        description='"profile": from the air\'s at base and top; "isothermal-top": that of the top throughout.',
    )
    space_temperature: float = Field(
        2.725, ge=0.0, le=400.0, allow_inf_nan=False, description="Kelvin of the sky beyond the atmosphere."
    )
    leave_out: tuple[
        Literal[
            "cloud_emission",
            "cloud_reflected_sun",
            "sea_emission",
            "sea_reflected_sun",
            "path_emission",
            "reflected_air_emission",
            "path_scattered_sun",
        ],
        ...,
    ] = Field((), description="Terms to set to 0, for comparisons.")

    @model_validator(mode="after")
    def _enough_streams(self) -> Self:
        if self.azimuth_modes > 2 * self.sun_streams:
            raise ValueError(
                f"azimuth_modes {self.azimuth_modes}: allowed up to twice sun_streams, {2 * self.sun_streams}"
            )
        return self
