"""Parameters that a scenario can set; separate from the generator, so that checking a scenario needs no numpy."""

from pydantic import BaseModel, ConfigDict, Field


class FollowedParameters(BaseModel):
    """Parameters of the generator `followed`."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    state: str = Field(description="State file of `hcss follow`, beside the scenario, or a path.")
    member: int | None = Field(
        None,
        ge=0,
        lt=2**32,
        description="Number of the member of the ensemble: what the images do not say is drawn with it; default: the "
        "mean forecast, which is smoother the later it is.",
    )
    lead: float = Field(
        0.0,
        ge=-21600.0,
        le=21600.0,
        description="Time of the scenario's start after the latest image, s; negative for those taken while live.",
    )
    limits_um: tuple[float, float] = Field(
        (10.3, 11.3), description="Limits of the images' band, of equal response in wavenumber, um."
    )
    detail: float | None = Field(
        None,
        ge=0.0,
        le=1.0,
        description="Strength of the detail below the image's pixel, as of the generator `example`; default: "
        "extrapolated from the image.",
    )
