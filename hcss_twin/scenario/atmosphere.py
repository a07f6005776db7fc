"""The section of the atmosphere."""

from __future__ import annotations

from typing import Any, Literal, Self

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from hcss_twin.core.units import GasAmount
from hcss_twin.core.units import QuantityParser as Quantity
from hcss_twin.models.atmosphere.profile_file import STANDARD
from hcss_twin.scenario.section_types import ScenarioSection, filled, own

BAND_MODEL = ("band-model", own("band-model"))


class GasesSection(ScenarioSection):
    """Amounts of gases: a factor on the profile, or text with ppm or ppb (at the surface) or DU (the column)."""

    CO2: GasAmount | None = Field(None, description='Carbon dioxide, for example `"420 ppm"`.')
    CH4: GasAmount | None = Field(None, description='Methane, for example `"1.9 ppm"`.')
    N2O: GasAmount | None = Field(None, description='Nitrous oxide, for example `"335 ppb"`.')
    O3: GasAmount | None = Field(None, description='Ozone, for example `"300 DU"`.')
    CO: GasAmount | None = Field(None, description="Carbon monoxide, for example `1.5`.")
    others: Literal["year", "profile"] = Field(
        "year",
        description='Gases that are not given: "year": CO2, CH4 and N2O of model atmospheres are means of'
        ' the scene\'s year; "profile": as in the profile.',
    )

    @property
    def asks_for_year(self) -> bool:
        """Whether the scenario states that other gases are those of its year."""
        return self.others == "year" and "others" in self.model_fields_set

    def given(self) -> dict[str, float | str]:
        """Return the given amounts by the names of profiles."""
        amounts = {name: getattr(self, name) for name in type(self).model_fields if name != "others"}
        return {name.lower(): amount for name, amount in amounts.items() if amount is not None}


class InversionSection(ScenarioSection):
    """A trade inversion over a well-mixed marine boundary layer; `inversion = {}` selects the defaults."""

    height: Quantity.Length = Field(
        1000.0, ge=200, le=3000, description="Altitude of the inversion, m: that of cloud tops."
    )
    strength: Quantity.Number = Field(10.0, ge=0, le=25, description="Rise of temperature through the inversion, K.")
    cloud_base: Quantity.Length = Field(
        600.0, ge=0, le=3000, description="Altitude from which the air is saturated, m."
    )
    humidity_above: Quantity.Fraction = Field(0.2, ge=0.01, le=1, description="Relative humidity above the inversion.")
    surface_temperature: Quantity.Temperature | None = Field(
        None,
        ge=250,
        le=310,
        description="Air temperature at the sea, K; default: the climatology's, or that of the profile without one.",
    )

    @model_validator(mode="after")
    def _base_below(self) -> Self:
        if self.cloud_base > self.height:
            raise PydanticCustomError(
                "cloud_base",
                f"cloud_base {self.cloud_base:g} m is above the inversion; allowed: up to height, {self.height:g}",
            )
        return self


class Atmosphere(ScenarioSection):
    """Gas and aerosol between sea, clouds and sensor."""

    provider: str = Field("band-model", description="Transmittance provider (see `hcss plugins`).")
    coefficients: Literal["rrtmgp", "lowtran7"] | None = Field(
        None,
        description='Of `band-model`: "rrtmgp" (the default), fitted to RRTMGP\'s gas optics, or "lowtran7"; '
        "excludes its parameter `file`.",
    )
    gases: GasesSection = filled(GasesSection, "Amounts of gases other than water vapour.")
    profile: str | None = Field(
        None,
        description="Catalog name, or CSV or NetCDF file of one place or several; default: the air of place and date.",
    )
    profile_above: str = Field(
        STANDARD, description="Profile that adds to a file the air above its last level and missing gases."
    )
    water_vapour_scale: Quantity.Number | None = Field(
        None, ge=0, le=10, description="Scale factor for the water vapour of all levels."
    )
    water_vapour_column: Quantity.Number | None = Field(
        None,
        ge=0,
        le=100,
        description="Column of water vapour to scale the profile to, kg m-2; excludes water_vapour_scale.",
    )
    water_vapour_texture: Quantity.Fraction | None = Field(
        None,
        ge=0,
        le=0.2,
        description="Relative standard deviation of the water vapour over some hundred km, the same at "
        "all levels: a random field that drifts with `motion.wind_speed`; 0: one profile; "
        "default: 0.05 in images of 100 km or more without camera or `platform.altitude`, "
        "whose bands lie above 5 um, else one profile.",
    )
    inversion: InversionSection | Literal["off"] | None = Field(
        None,
        description='Table: a trade inversion and the marine boundary layer below it; "off": none; '
        "default: one above stratus and stratocumulus, unless `profile` is given.",
    )
    parameters: dict[str, Any] = Field(default_factory=dict, description="Parameters of the provider.")

    @model_validator(mode="after")
    def _one_amount(self) -> Self:
        if self.water_vapour_scale is not None and self.water_vapour_column is not None:
            raise PydanticCustomError(
                "water_vapour", "water_vapour_scale given with water_vapour_column; allowed: one of them"
            )
        if isinstance(self.inversion, InversionSection) and self.water_vapour_column is not None:
            raise PydanticCustomError(
                "water_vapour",
                "water_vapour_column given with inversion, which sets the lower part of the column; "
                "allowed: water_vapour_scale, for the air above",
            )
        return self

    @model_validator(mode="after")
    def _coefficients_of_band_model(self) -> Self:
        if self.coefficients is not None and self.provider not in BAND_MODEL:
            raise PydanticCustomError(
                "coefficients", f"coefficients given with provider '{self.provider}'; allowed: with 'band-model'"
            )
        if self.coefficients is not None and "file" in self.parameters:
            raise PydanticCustomError("coefficients", "coefficients given with parameters.file; allowed: one of them")
        return self
