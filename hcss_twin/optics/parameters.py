"""Parameters of the optics providers; light enough to import for a list of what there is."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field


class MieParameters(BaseModel):
    """Parameters of :class:`hcss_twin.optics.mie.MieOptics`."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)

    water_index: str = Field(
        default="water",
        min_length=1,
        description="Refractive index of water clouds: a name in catalogs/optical_constants or a CSV file",
    )
    ice_index: str = Field(
        default="ice",
        min_length=1,
        description="Refractive index of ice clouds: a name in catalogs/optical_constants or a CSV file",
    )
    radius_nodes: int = Field(
        default=250,
        ge=50,
        le=4000,
        description="Radii of the quadrature over sizes; up to 16 times as many where absorption is weak",
    )
    spectral_step: float = Field(
        default=0.01,
        ge=0.0005,
        le=0.1,
        description="Widest panel of the spectral interpolation, as a fraction of the wavelength",
    )
