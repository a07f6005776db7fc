"""Parameters of the transmittance providers."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field


class TableParameters(BaseModel):
    """Parameters of the ``table`` provider."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)

    file: str = Field(
        "us-standard-1976-lowtran7",
        description="Atmosphere table: a catalog name or a NetCDF file in the documented format.",
    )
