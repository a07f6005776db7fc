"""Parameters that a scenario can set; separate from the provider, so that checking a scenario compiles nothing."""

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

from hcss_twin.core.units import QuantityParser as Quantity


class Lowtran7Parameters(BaseModel):
    """Parameters of the provider `lowtran7`."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    aerosol: Literal["none", "maritime", "rural", "urban", "tropospheric"] = Field(
        "none",
        description="Aerosol of the lowest 2 km (IHAZE 0, 4, 1, 5, 6). All but 'none' also bring "
        "LOWTRAN7's tropospheric and background stratospheric aerosol above.",
    )
    visibility_km: Quantity.Kilometres | None = Field(
        None,
        ge=2,
        le=50,
        description="Surface meteorological range; by default 23 km (maritime, rural), 5 km (urban), "
        "50 km (tropospheric). The aerosol profiles of LOWTRAN7 are made for 2 to 50 km.",
    )
    season: Literal["spring-summer", "fall-winter"] | None = Field(
        None,
        description="Season of the aerosol above 2 km; by default fall-winter for the built-in winter "
        "atmospheres, else spring-summer.",
    )

    precision: Literal["single", "double"] = Field(
        "single",
        description="Of the compiled program. Single is the original, whose ray tracing leaves a noise of up "
        "to 2e-4 in transmittance and 5e-4 of a band's path radiance; double has none.",
    )

    @model_validator(mode="after")
    def _needs_aerosol(self) -> "Lowtran7Parameters":
        for name in ("visibility_km", "season"):
            if self.aerosol == "none" and getattr(self, name) is not None:
                raise ValueError(f"{name} {getattr(self, name)} has no effect with aerosol 'none'; closest: 'maritime'")
        return self
