"""Parameter models of the sea providers; imports nothing heavy."""

from __future__ import annotations

from typing import Literal

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


class RoughSeaParameters(BaseModel):
    """What a scenario can choose for the rough sea."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)

    water_index: str = Field(
        default="water",
        min_length=1,
        description="Refractive index of pure water at 25 degC: a name in catalogs/optical_constants, or a CSV "
        "file with the columns wavelength_um, n and k.",
    )
    water_temperature: bool = Field(
        default=True,
        description="Whether the refractive index follows the sea's temperature (-10 to 45 degC, from 0.67 um).",
    )
    salinity_psu: float = Field(default=35.0, ge=0.0, le=45.0, description="Salinity; 0 is fresh water.")
    slopes: Literal["isotropic", "upwind-crosswind", "gram-charlier"] = Field(
        default="isotropic",
        description="Statistics of slopes (Cox and Munk): the same in all directions, wider along the wind, or "
        "also skewed and peaked (to 20 m/s). The latter two depend on the bearing of view and sun to the wind.",
    )
    shadowing: Literal["none", "separable", "height-correlated"] = Field(
        default="height-correlated", description="How waves hide facets from sensor and source (Smith)."
    )
    re_reflection: bool = Field(
        default=True,
        description="Whether light that one facet reflects can come from another facet; it raises emissivity "
        "toward the horizon.",
    )
    foam: bool = Field(default=True, description="Whether part of the sea is under foam.")
    foam_law: Literal["monahan-1980", "monahan-1980-least-squares", "monahan-1986"] = Field(
        default="monahan-1980-least-squares",
        description="Foam coverage by wind: 3.84e-6 U^3.41, 2.95e-6 U^3.52 or 1.95e-5 U^2.55, at most 1.",
    )
    foam_emissivity: float = Field(
        default=0.98, ge=0.0, le=1.0, description="Emissivity of foam in the thermal infrared, all directions."
    )
    spectrum: Literal["pierson-moskowitz", "jonswap"] = Field(
        default="pierson-moskowitz",
        description="Spectrum of the waves, from which the significant wave height follows.",
    )
    fetch_m: float = Field(
        default=100e3, ge=1e3, le=2e6, description="Fetch of the JONSWAP spectrum, upwind distance to the coast."
    )
