"""Parameters that a scenario can set; separate from the generator, so that checking a scenario needs no numpy."""

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field


class ExampleParameters(BaseModel):
    """Parameters of the generator `example`."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    example: str = Field(
        "open-cells-1",
        description="Name of a shipped example or of one in skies/ beside the scenario (without .nc), or a file.",
    )
    detail: float | None = Field(
        None,
        ge=0.0,
        le=1.0,
        description="Strength of the detail below the example's pixel: standard deviation of the logarithm of "
        "thickness where it changes by itself from one pixel to the next; default: that of the example's file, "
        "else 0.31.",
    )
    detail_exponent: float | None = Field(
        None,
        ge=1.2,
        le=4.0,
        description="Exponent of the power spectrum, along a line, of the detail; default: that of the example's file, "
        "else 2.3.",
    )
    distribution: Literal["image", "expected"] = Field(
        "image",
        description="Of cloud over the sky: that of the example in the middle of the sky, an area as large as the "
        "example at time 0, or left to chance, with which cold clouds are too few in the mean.",
    )
    clear_sky: Literal["uniform", "example"] = Field(
        "uniform",
        description="Clear sky: without texture, or with that of the example, which cloud of a few metres gives; it "
        "needs a small clouds.thickness_min, and counts as cloud in masks.",
    )
    tops: Literal["layer", "example"] = Field(
        "layer", description="Cloud tops: those of the layer, or those of the example, for scenes of one layer."
    )
    shape: Literal["relief", "columns"] = Field(
        "relief",
        description="Shape in height, which light between columns sees: a smooth body with soft tops, or columns of "
        "thickness alone. Clouds with tops of their own have none.",
    )


class SimulationParameters(BaseModel):
    """Parameters of the generator `simulation`."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    film: str = Field(
        "trade-cumulus",
        description="Name of a shipped film or of one in skies/ beside the scenario (without .nc), or a file of `hcss "
        "skies pack`.",
    )
    where: str | None = Field(
        None,
        description="Name of an example (as for the generator `example`), or a file, whose bright and dark places have "
        "more and fewer of the film's clouds; default: clouds everywhere alike.",
    )
    tops: Literal["layer", "film"] = Field(
        "layer",
        description="Cloud tops: those of the layer, from which columns of thickness alone stand or hang, or those of "
        "the film. Light between columns, which needs the first, sees tops and bases of the film.",
    )


class VolumeParameters(BaseModel):
    """Parameters of the generator `volume`."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    volume: str = Field(
        "trade-cumulus",
        description="Name of a shipped volume or of one in skies/ beside the scenario (without .nc), or a file of "
        "`hcss skies pack --volume`.",
    )
