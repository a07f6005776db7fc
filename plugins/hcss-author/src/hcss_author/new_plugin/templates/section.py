"""A section of scenarios: keys of your own, which `hcss validate` checks and every cube records."""

from pydantic import BaseModel, ConfigDict, Field


class Settings(BaseModel):
    """Keys of the section. In code: `scenario.sections["NAME"].flight`."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    flight: int = Field(default=1, ge=1, description="Number of the flight that the scene stands for.")
    leg: float = Field(default=0.0, ge=0, le=1, description="Part of the flight before the first frame.")
