"""Parameters of the cloud generator that takes its clouds from a satellite image."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field


class ImageryParameters(BaseModel):
    """Which image, which part of it, and what in it is cloud."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    image: str = Field(
        min_length=1,
        description="Image file, relative to the scenario: NetCDF, PNG, JPEG or other picture, .npy or .npz.",
    )
    variable: str | None = Field(
        None,
        min_length=1,
        description="Variable of a NetCDF or .npz file; may be left out where there is only one.",
    )
    method: Literal["otsu", "local", "coverage"] = Field(
        "otsu",
        description='How cloudy pixels are found: "otsu" splits the histogram, "local" adds pixels that are '
        'cloudier than their surroundings, "coverage" takes the cloudiest until the coverage is reached.',
    )
    window_pixels: int | None = Field(
        None,
        ge=3,
        le=16384,
        description='Side of the surroundings of method "local"; default: an eighth of the shorter side.',
    )
    cloud_is: Literal["auto", "bright", "dark"] = Field(
        "auto",
        description='Whether large or small values are cloud; "auto": small for temperatures and '
        "thermal radiances.",
    )
    reinterpret_pixel_size: bool = Field(
        False, description="Take image pixels for scene pixels although their sizes differ."
    )
    row_origin: int | None = Field(
        None,
        ge=0,
        description="First image row of the scene, counted from the first stored row; default: centred.",
    )
    column_origin: int | None = Field(
        None,
        ge=0,
        description="First image column of the scene, counted from the first stored one; default: centred.",
    )
    missing: Literal["error", "clear"] = Field(
        "error", description='What missing pixels inside the scene are: an error, or "clear" sky.'
    )
