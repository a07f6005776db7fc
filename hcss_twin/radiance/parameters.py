"""Parameters of the radiance models."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field


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
    literal_eq18: bool = Field(
        False, description="Sunlight on the sea crosses the air once, from sea to sensor."
    )
    literal_eq19: bool = Field(False, description="Path radiance of the full column over clouds.")
    literal_eq20: bool = Field(
        False, description="Adds the sea unattenuated by the cloud as well as through it."
    )
