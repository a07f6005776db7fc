"""Parameters that a scenario can set; separate from the generator, so that checking a scenario needs no numpy."""

from pydantic import BaseModel, ConfigDict, Field

from hcss_twin.core.units import QuantityParser as Quantity


class FallStreakParameters(BaseModel):
    """Parameters of the generator `fall-streaks`."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    shear: float = Field(
        5e-3,
        ge=0.0,
        le=0.1,
        description="Change of the wind with height inside the layer, 1/s: streaks are carried by it.",
    )
    shear_from: Quantity.Angle | None = Field(
        None,
        ge=0.0,
        lt=360.0,
        description="Direction from which the wind grows with height, degrees clockwise from the image's y axis; "
        "streaks trail that way. Default: where the clouds come from (270 without wind), turned by -90 to 90 degrees "
        "as the seed decides.",
    )
    turning: Quantity.Angle = Field(
        50.0,
        ge=-180.0,
        le=180.0,
        description="By which the shear turns clockwise from the layer's top to its base, degrees: hooks.",
    )
    fall_speed: Quantity.Speed = Field(0.6, ge=0.05, le=5.0, description="Fall speed of the ice that is seen, m/s.")
    outer_scale: Quantity.Kilometres = Field(
        50.0,
        ge=1.0,
        le=1000.0,
        description="Wavelength, km, up to which the variance of ice water grows as that of a spectrum k^-5/3.",
    )
    deviation: float = Field(
        1.2,
        ge=0.05,
        le=3.0,
        description="Standard deviation of the logarithm of ice water content at the generating level.",
    )
    cells: float = Field(
        0.25,
        ge=0.0,
        le=1.0,
        description="Part of the variance that generating cells of about 1.2 km have, the heads of streaks.",
    )
