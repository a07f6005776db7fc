"""Parameters of the cloud generator ``surrogate``, which imitates a measured image."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from hcss_twin.models.clouds.imagery.parameters import ImageReading


class SurrogateParameters(ImageReading):
    """Parameters of the ``surrogate`` generator: image, crop, definition of cloud, and iterations."""

    image: str = Field(
        min_length=1,
        description="Image file, relative to the scenario: NetCDF, GeoTIFF, PNG, JPEG or other picture, .npy or .npz.",
    )
    row_origin: int | None = Field(
        None, ge=0, description="First image row of the crop, counted from the first stored row; default: centred."
    )
    column_origin: int | None = Field(
        None, ge=0, description="First image column of the crop, counted from the first stored one; default: centred."
    )
    crop_rows: int | None = Field(
        None,
        ge=16,
        le=16384,
        description="Rows of the image that the surrogates imitate; default: as many as the scene has, at "
        "least 64, at most the whole image.",
    )
    crop_columns: int | None = Field(
        None, ge=16, le=16384, description="Columns of the image that the surrogates imitate; default as for crop_rows."
    )
    period_rows: int | None = Field(
        None,
        ge=16,
        le=16384,
        description="Rows after which the cloud field repeats; default: those of the scene or of the crop, "
        "whichever has more.",
    )
    period_columns: int | None = Field(
        None, ge=16, le=16384, description="Columns after which the cloud field repeats; default as for period_rows."
    )
    structure: Literal["spectrum", "bands"] = Field(
        "spectrum",
        description='What clouds have of the image besides its amplitudes: "spectrum", its power spectrum; "bands", '
        "its amplitudes in each octave of scale, too, so that smooth and rough parts differ more nearly as in the "
        "image; frames take more than twice as long.",
    )
    iterations: int | None = Field(
        None,
        ge=0,
        le=1000,
        description="Iterations of the amplitude adjustment: for every frame 4 by default; where shapes are "
        "frozen, once for all frames, at most 200 by default.",
    )
    tolerance: float = Field(
        1e-3,
        gt=0.0,
        lt=1.0,
        description="Frozen shapes only: iterations end when the spectral misfit falls by less than this "
        "fraction from one to the next.",
    )
    evolution_exponent: float = Field(
        1.0,
        ge=0.0,
        le=2.0,
        allow_inf_nan=False,
        description="Structures of half the size change 2 to this power times as fast; 0: all equally fast, 2/3: as in "
        "turbulence, 1: as in the fractal generator with gamma = 2.",
    )
