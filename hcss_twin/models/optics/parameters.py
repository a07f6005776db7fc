"""Parameters of the optics providers; light enough to import for a list of what there is."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field


class MieParameters(BaseModel):
    """Parameters of :class:`hcss_twin.models.optics.mie.MieOptics`."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)

    water_index: str = Field(
        default="water",
        min_length=1,
        description="Refractive index of water clouds: a name in catalogs/optical_constants or a CSV file",
    )
    water_temperature_K: float | None = Field(
        default=None,
        ge=200.0,
        le=330.0,
        description="Temperature of the droplets, interpolated between the tables water-<T>K; instead of water_index",
    )
    ice_index: str = Field(
        default="ice",
        min_length=1,
        description="Refractive index of ice clouds: a name in catalogs/optical_constants or a CSV file",
    )
    phase_function: Literal["mie", "henyey-greenstein"] = Field(
        default="mie", description="Phase function of spheres: of Mie theory, or eq 13 with the same asymmetry"
    )
    moments: int = Field(default=128, ge=3, le=2048, description="Legendre moments of the Mie phase function")
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


class BulkParameters(MieParameters):
    """Parameters of :class:`hcss_twin.models.optics.mie.BulkOptics`."""

    water_index: str = Field(
        default="water-273K",
        min_length=1,
        description="Refractive index of water clouds: a name in catalogs/optical_constants or a CSV file",
    )
    ice_table: str = Field(
        default="ice-yang-2013",
        min_length=1,
        description="Bulk optics of ice crystals: a name in catalogs/optics or a NetCDF file of that form",
    )
    roughness: Literal["smooth", "moderate", "severe"] = Field(
        default="severe", description="Roughness of the crystals' faces"
    )
