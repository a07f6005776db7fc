"""Parameter models of the sea providers; imports nothing heavy."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field


class CoxMunkParameters(BaseModel):
    """What a scenario can choose for the Cox-Munk sea."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)

    water_index: str = Field(
        default="water",
        min_length=1,
        description="Refractive index of the water: a name in catalogs/optical_constants, or a CSV file "
        "with the columns wavelength_um, n and k.",
    )
