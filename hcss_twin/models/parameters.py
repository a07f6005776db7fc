"""Parameters that a scenario can set for the atmosphere, sea, optics and radiance providers.

This module imports no heavy packages, so that listing the providers stays fast.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from hcss_twin.core.units import QuantityParser as Quantity


class TableParameters(BaseModel):
    """Parameters of the ``table`` provider."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)

    file: str = Field(
        "us-standard-1976-lowtran7",
        description="Atmosphere table: a catalog name or a NetCDF file in the documented format.",
    )

    @model_validator(mode="before")
    @classmethod
    def _of_one_air(cls, given: dict[str, Any]) -> dict[str, Any]:
        for name in given:
            if name in BandModelParameters.model_fields and name not in cls.model_fields:
                raise ValueError(
                    f"{name} is a key of 'band-model', and a table is computed for one air; allowed: file, or "
                    "atmosphere.provider = 'band-model'"
                )
        return given


Aerosol = Literal["none", "maritime", "navy-maritime", "rural", "urban"]
NAVY_MARITIME = "navy-maritime"
DEFAULT_VISIBILITY_KM = 23.0
Season = Literal["spring-summer", "fall-winter"]


COEFFICIENTS: Mapping[str, str] = MappingProxyType({"rrtmgp": "band-model-rrtmgp", "lowtran7": "lowtran7-band-model"})
"""Catalog names of the coefficients of the band model."""

DEFAULT_COEFFICIENTS = "rrtmgp"


class BandModelParameters(BaseModel):
    """Parameters of the ``band-model`` provider."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)

    aerosol: Aerosol = Field(
        "maritime",
        description="Aerosol of the lowest 2 km, with LOWTRAN7's background above; 'navy-maritime' "
        "follows sea.wind_speed; 'none' omits all.",
    )
    visibility_km: Quantity.Kilometres | None = Field(
        None,
        ge=2.0,
        le=50.0,
        description="Meteorological range at the surface in km; by default 23, or with 'navy-maritime' "
        "that of wind and humidity.",
    )
    wind_24h_m_s: Quantity.Speed | None = Field(
        None,
        ge=0.0,
        le=20.0,
        description="Mean wind of the last 24 hours, for 'navy-maritime'; by default sea.wind_speed.",
    )
    air_mass_character: int | None = Field(
        None,
        ge=1,
        le=10,
        description="1 (open ocean) to 10 (strong continental influence), for 'navy-maritime'; by default 3.",
    )
    season: Season = Field(
        "spring-summer", description="Season of the aerosol above 2 km: spring-summer or fall-winter."
    )
    earth_radius_m: Quantity.Length = Field(
        6_371_230.0,
        ge=6.3e6,
        le=6.4e6,
        description="Radius of the Earth in m; LOWTRAN7 uses 6378390 for tropical and 6356910 for subarctic air.",
    )
    file: str = Field(
        COEFFICIENTS[DEFAULT_COEFFICIENTS],
        description="Coefficients: a catalog name or a NetCDF file in the same format.",
    )

    @model_validator(mode="after")
    def _needs_navy_maritime(self) -> Self:
        for name in ("wind_24h_m_s", "air_mass_character"):
            if self.aerosol != NAVY_MARITIME and getattr(self, name) is not None:
                raise ValueError(
                    f"{name} {getattr(self, name)} has no effect with aerosol '{self.aerosol}'; allowed: "
                    f"'{NAVY_MARITIME}'"
                )
        return self


class CoxMunkParameters(BaseModel):
    """Parameters of the ``cox-munk`` sea model."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)

    water_index: str = Field(
        default="water",
        min_length=1,
        description="Refractive index of the water: a name in catalogs/optical_constants, or a CSV file "
        "(wavelength_um, n, k).",
    )


class RoughSeaParameters(BaseModel):
    """Parameters of the ``rough-sea`` model."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)

    water_index: str = Field(
        default="water",
        min_length=1,
        description="Refractive index of pure water at 25 degC: a name in catalogs/optical_constants, or "
        "a CSV file (wavelength_um, n, k).",
    )
    water_temperature: bool = Field(
        default=True,
        description="Whether the refractive index depends on the sea temperature (-10 to 45 degC, from 0.67 um).",
    )
    salinity_psu: float = Field(default=35.0, ge=0.0, le=45.0, description="Salinity; 0 is fresh water.")
    slopes: Literal["isotropic", "upwind-crosswind", "gram-charlier"] = Field(
        default="isotropic",
        description="Slope statistics (Cox and Munk): the same in all directions, wider along the wind, "
        "or also skewed and peaked (to 20 m/s).",
    )
    shadowing: Literal["none", "separable", "height-correlated"] = Field(
        default="height-correlated", description="Model of how waves hide facets from sensor and source (Smith)."
    )
    re_reflection: bool = Field(
        default=True,
        description="Whether facets also reflect light from other facets (second reflection); this raises emissivity "
        "toward the horizon.",
    )
    foam: bool = Field(default=True, description="Whether foam covers part of the sea.")
    foam_law: Literal["monahan-1980", "monahan-1980-least-squares", "monahan-1986"] = Field(
        default="monahan-1980-least-squares",
        description="Foam coverage from wind speed U: 3.84e-6 U^3.41, 2.95e-6 U^3.52 or 1.95e-5 U^2.55, at most 1.",
    )
    foam_emissivity: float = Field(
        default=0.98, ge=0.0, le=1.0, description="Emissivity of foam in the thermal infrared, isotropic."
    )
    spectrum: Literal["pierson-moskowitz", "jonswap"] = Field(
        default="pierson-moskowitz", description="Wave spectrum, which determines the significant wave height."
    )
    fetch_m: Quantity.Length = Field(
        default=100e3, ge=1e3, le=2e6, description="Fetch of the JONSWAP spectrum: the upwind distance to the coast."
    )


class MieParameters(BaseModel):
    """Parameters of :class:`hcss_twin.models.optics.mie.MieOptics`."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)

    water_index: str = Field(
        default="water",
        min_length=1,
        description="Refractive index of water clouds: a name in catalogs/optical_constants or a CSV file",
    )
    water_temperature_K: Quantity.Temperature | None = Field(
        default=None,
        ge=240.0,
        le=273.0,
        description="Droplet temperature, an alternative to water_index: interpolates between the tables water-<T>K",
    )
    ice_index: str = Field(
        default="ice",
        min_length=1,
        description="Refractive index of ice clouds: a name in catalogs/optical_constants or a CSV file",
    )
    phase_function: Literal["mie", "henyey-greenstein"] = Field(
        default="mie", description="Phase function of spheres: from Mie theory, or eq 13 with the same asymmetry"
    )
    moments: int | None = Field(
        default=None,
        ge=3,
        le=2048,
        description="Legendre moments of the Mie phase function; by default 128 for water and 512 for ice",
    )
    radius_nodes: int = Field(
        default=250,
        ge=50,
        le=4000,
        description="Number of radii in the size quadrature; up to 16 times as many where absorption is weak",
    )
    spectral_step: float = Field(
        default=0.01,
        ge=0.0005,
        le=0.1,
        description="Widest panel of the spectral interpolation, as a fraction of the wavelength",
    )

    def moments_of(self, material: str) -> int:
        """Return how many moments the phase function of a material has; 2 stand for Henyey and Greenstein's."""
        if self.phase_function == "henyey-greenstein":
            return 2
        return self.moments or (512 if material == "ice" else 128)


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
        description="Bulk optics of ice crystals: a name in catalogs/optics, or a NetCDF file in that format",
    )
    ice_phase_function: Literal["henyey-greenstein", "diffraction-and-rays"] = Field(
        default="diffraction-and-rays",
        description="Phase function of crystals, both with the table's asymmetry: diffraction, outer "
        "reflection, and Henyey-Greenstein for light from inside; or Henyey-Greenstein for "
        "all",
    )
    roughness: Literal["smooth", "moderate", "severe"] = Field(
        default="severe", description="Surface roughness of the crystals, one that the table has"
    )


class AsPrintedParameters(BaseModel):
    """Parameters of the ``as-printed`` model.

    The four ``literal_...`` switches restore printed equations of the HCSS paper that its own tables contradict.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)

    glint_scale: float = Field(
        1.0,
        ge=0,
        le=10,
        description="Scale factor for sunlight reflected by the sea; 0.087 fits Tables II and IV to VII, 1 is eq 18.",
    )
    cloud_sun_scale: float = Field(
        1.0,
        ge=0,
        le=10,
        description="Scale factor for sunlight reflected by the cloud; 0 fits Tables II and IV, 1 is eq 16.",
    )
    literal_eq14: bool = Field(False, description="Use the printed sign of eq 14 in the scattering angle.")
    literal_eq18: bool = Field(False, description="Attenuate sunlight on the sea only once, from sea to sensor.")
    literal_eq19: bool = Field(False, description="Use the path radiance of the full column over clouds.")
    literal_eq20: bool = Field(False, description="Add the sea radiance both unattenuated and attenuated by the cloud.")


STREAMS, SUN_STREAMS, AZIMUTH_MODES = 8, 8, 16
"""Sizes of the physical model where a scenario states one of them only."""


class PhysicalParameters(BaseModel):
    """Parameters of the ``physical`` models: accuracy, and terms to leave out."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    streams: int | None = Field(
        None,
        ge=2,
        le=32,
        description="Gauss streams per hemisphere for diffuse light and sky radiance. By default this, "
        "sun_streams, sun_moments and azimuth_modes are chosen for the scene's accuracy; with"
        " any of them, streams and sun_streams are 8.",
    )
    closure_order: int = Field(
        1,
        ge=0,
        le=2,
        description="Scattering and reflection order up to which gas absorption is exact; higher orders use that "
        "along the line of sight.",
    )
    sun_streams: int | None = Field(
        None, ge=2, le=64, description="Gauss streams for sunlight that clouds scatter toward the sensor."
    )
    sun_moments: int | None = Field(
        None,
        ge=2,
        le=128,
        description="Moments of the phase function for this sunlight, at most twice sun_streams; as many "
        "by default. More are exact for smooth phase functions only.",
    )
    azimuth_modes: int | None = Field(
        None,
        ge=1,
        le=128,
        description="Terms of the Fourier series over azimuth for sunlight; at most twice sun_streams, 16 by default.",
    )
    cloud_temperature: Literal["profile", "isothermal-top"] = Field(
        "profile",
        description='"profile": air temperature at base and top; "isothermal-top": that of the top throughout.',
    )
    space_temperature: Quantity.Temperature = Field(
        2.725, ge=0.0, le=400.0, allow_inf_nan=False, description="Temperature of the sky beyond the atmosphere, K."
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
        most = 2 * (self.sun_streams or SUN_STREAMS)
        stated = self.sun_streams or self.azimuth_modes
        for name, value in (
            ("sun_moments", self.sun_moments),
            ("azimuth_modes", (self.azimuth_modes or AZIMUTH_MODES) if stated else None),
        ):
            if value is not None and value > most:
                raise ValueError(f"{name} {value}: allowed up to twice sun_streams, {most}")
        return self
