"""Parameters of the cloud generator ``imagery``, which extracts clouds from satellite images."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from hcss_twin.models.clouds.imagery.moving_window import MovingWindow

__all__ = ["ImageReading"]

# Only for an image: the clouds of an entry are already extracted.
_OF_AN_IMAGE = ("variable", "at", "method", "limits_um", "window_pixels", "cloud_is")

# Only for a whole scene, which has a border and gaps.
_OF_A_SCENE = ("row_origin", "column_origin", "missing", "beyond")

_Wavelength = Annotated[float, Field(ge=3.0, le=15.0)]


class ImageReading(BaseModel):
    """Parameters that select a part of an image and define its clouds.

    Attributes
    ----------
    Window
        The part of an image, in which a scene moves.
    """

    Window: ClassVar = MovingWindow

    model_config = ConfigDict(extra="forbid", frozen=True)

    variable: str | None = Field(
        None,
        min_length=1,
        description="Variable of a NetCDF or .npz file, or number of a GeoTIFF's band, if there are several.",
    )
    at: Mapping[str, Annotated[int, Field(ge=0)]] = Field(
        {}, description="Index along each further dimension of a NetCDF variable of several images: {time = 3}."
    )
    method: Literal["auto", "temperature", "otsu", "local", "coverage"] = Field(
        "auto",
        description='Cloud detection. "temperature", for images in kelvin: each pixel gets the thickness '
        'with which the scene has that brightness temperature. "otsu" splits the histogram, '
        '"local" adds pixels that are cloudier than their surroundings, "coverage" takes the '
        'cloudiest. "auto": "temperature" for images in kelvin where cloud is cold, "otsu" '
        "for others.",
    )
    limits_um: tuple[_Wavelength, _Wavelength] | None = Field(
        None,
        description='Limits of the image\'s band in um, for method "temperature"; default 10.3 to 11.3. '
        "Below 5 um the image must be one by night.",
    )
    window_pixels: int | None = Field(
        None,
        ge=3,
        le=16384,
        description='Side of the surroundings of method "local"; default: an eighth of the shorter side.',
    )
    cloud_is: Literal["auto", "bright", "dark"] = Field(
        "auto",
        description='Whether large or small values are cloud; "auto": small for temperatures and thermal radiances.',
    )
    reinterpret_pixel_size: bool = Field(
        False, description="Treat image pixels as scene pixels although their sizes differ."
    )
    row_origin: int | None = Field(
        None, ge=0, description="First image row of the scene, counted from the first stored row; default: centred."
    )
    column_origin: int | None = Field(
        None, ge=0, description="First image column of the scene, counted from the first stored one; default: centred."
    )
    missing: Literal["error", "clear"] = Field(
        "error", description='Treatment of missing pixels inside the scene: as an error, or as "clear" sky.'
    )

    @model_validator(mode="after")
    def _limits_of_a_band(self) -> Self:
        """Reject limits without a band between them, or that would be ignored."""
        if self.limits_um is None:
            return self
        low, high = self.limits_um
        if not low < high:
            closest = f", closest is [{high:g}, {low:g}]" if low > high else ""
            raise ValueError(f"limits_um: [{low:g}, {high:g}] given; allowed: ascending{closest}")
        if self.method not in ("auto", "temperature"):
            raise ValueError(f"limits_um: has no meaning with the method {self.method!r}; allowed: leave it out")
        return self


class ImageryParameters(ImageReading):
    """Parameters of the ``imagery`` generator: image, part of it, and definition of cloud."""

    image: str | None = Field(
        None,
        min_length=1,
        description="Image file, relative to the scenario: NetCDF, GeoTIFF, PNG, JPEG or other picture, .npy or .npz.",
    )
    entry: str | None = Field(
        None,
        min_length=1,
        description="Entry of the cloud database instead of an image: name of a file in the folder clouds beside "
        "the scenario, or a path.",
    )
    placement: Literal["scene", "single-clouds"] = Field(
        "scene",
        description='"scene": clouds where the image has them; "single-clouds": single clouds of an entry'
        " scattered at random over an unbounded sky.",
    )
    beyond: Literal["unknown", "clear", "mirror"] = Field(
        "unknown",
        description="What slant paths, cameras, blur and light meet beyond the border of the image: "
        '"clear" sky, or its "mirror" image. "unknown": scenes that need clouds there are '
        "refused.",
    )
    turned: bool = Field(True, description="Rotate scattered clouds by quarter turns and mirror them, at random.")
    cloud_pixels: tuple[Annotated[int, Field(ge=1)], Annotated[int, Field(ge=1)]] | None = Field(
        None, description="Smallest and largest area of the clouds that are scattered, pixels; default: all."
    )

    @model_validator(mode="after")
    def _one_kind_of_source(self) -> Self:
        """Reject parameters that would be ignored."""
        if (self.image is None) is (self.entry is None):
            given = "neither" if self.image is None else "both"
            raise ValueError(f"image, entry: {given} given; allowed: one of them")
        scattered = self.placement == "single-clouds"
        if scattered and self.entry is None:
            raise ValueError('placement "single-clouds" needs an entry; make one with hcss import')
        refused = {
            "with an entry": _OF_AN_IMAGE if self.entry is not None else (),
            'with the placement "single-clouds"': _OF_A_SCENE if scattered else (),
            'without the placement "single-clouds"': () if scattered else ("turned", "cloud_pixels"),
        }
        for why, names in refused.items():
            ignored = [name for name in names if name in self.model_fields_set]
            if ignored:
                raise ValueError(f"{', '.join(ignored)}: has no meaning {why}; allowed: leave it out")
        if self.cloud_pixels is not None and self.cloud_pixels[0] > self.cloud_pixels[1]:
            low, high = self.cloud_pixels
            raise ValueError(
                f"cloud_pixels: {low} is greater than {high}; allowed: ascending, closest is [{high}, {low}]"
            )
        return self
