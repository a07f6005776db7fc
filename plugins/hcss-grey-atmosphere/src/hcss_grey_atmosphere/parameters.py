"""Parameters that a scenario can set; separate from the provider, so that checking a scenario needs no numpy."""

from pydantic import BaseModel, ConfigDict, Field


class GreyParameters(BaseModel):
    """Parameters of the provider `grey`."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    optical_depth: float = Field(0.3, ge=0, le=100, description="Optical depth of the whole vertical column.")
