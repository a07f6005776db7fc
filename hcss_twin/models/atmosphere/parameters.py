"""Parameters of the transmittance providers.

Parameters of the ``band-model`` provider.
"""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field


class TableParameters(BaseModel):
    """Parameters of the ``table`` provider."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)

    file: str = Field(
        "us-standard-1976-lowtran7",
        description="Atmosphere table: a catalog name or a NetCDF file in the documented format.",
    )


Aerosol = Literal["none", "maritime", "rural", "urban"]
Season = Literal["spring-summer", "fall-winter"]


class BandModelParameters(BaseModel):
    """Parameters of the ``band-model`` provider."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)

    aerosol: Aerosol = Field(
        "maritime",
        description="Aerosol of the lowest 2 km, with LOWTRAN7's background aerosol above; 'none' leaves all out.",
    )
    visibility_km: float = Field(
        23.0, ge=2.0, le=50.0, description="Meteorological range at the surface in km, 2 to 50."
    )
    season: Season = Field(
        "spring-summer", description="Season of the aerosol above 2 km: spring-summer or fall-winter."
    )
    earth_radius_m: float = Field(
        6_371_230.0,
        ge=6.3e6,
        le=6.4e6,
        description="Radius of the Earth in m; LOWTRAN7 takes 6378390 for tropical and 6356910 for subarctic air.",
    )
    file: str = Field(
        "lowtran7-band-model", description="Coefficients: a catalog name or a NetCDF file of the same format."
    )
