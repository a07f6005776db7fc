"""The ``bands`` key: each entry a catalog name, limits, or a measured response; each band once."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import AfterValidator, BeforeValidator, Discriminator, Field, Tag
from pydantic_core import PydanticCustomError

from hcss_twin.scenario.section import Section
from hcss_twin.scenario.wording import shown


class ResponseBand(Section):
    """A band given by a measured spectral response."""

    name: str = Field(min_length=1, max_length=60, description="Name of the band in the cube.")
    response: str = Field(
        min_length=1,
        description="CSV file with columns wavelength_um and response (0 to 1), relative to the scenario.",
    )


Limits = tuple[float, float]

NARROWEST = 1e-6
"""Least width over wavelength; below, rounding shows in the spectral grid."""


def _band(value: object) -> object:
    if isinstance(value, str | dict | ResponseBand):
        return value
    if isinstance(value, list | tuple):
        return _limits(value)
    raise PydanticCustomError(
        "band",
        f"{shown(value)} is not a band; allowed: a name, [shortest_um, longest_um], or {{name, response}}",
    )


def _limits(value: list[Any] | tuple[Any, ...]) -> Limits:
    allowed = "allowed: [shortest_um, longest_um], two numbers from 0.1 to 1000"
    if len(value) != 2 or not all(map(_is_number, value)):
        raise PydanticCustomError("band", f"{shown(list(value))} is not a band; {allowed}")
    if not all(0.1 <= limit <= 1000 for limit in value):  # also refuses NaN
        raise PydanticCustomError("band", f"{shown(list(value))} um is out of range; {allowed}")
    low, high = float(value[0]), float(value[1])
    if low == high:
        raise PydanticCustomError("band", f"{shown(list(value))} um has no width; {allowed}, ascending")
    if abs(high - low) < NARROWEST * max(low, high):
        narrowest = f"allowed: at least {NARROWEST:g} of the wavelength"
        raise PydanticCustomError("band", f"{shown(list(value))} um is too narrow; {narrowest}")
    if low > high:
        raise PydanticCustomError(
            "band", f"[{low:g}, {high:g}] um is upside down; closest valid choice is [{high:g}, {low:g}]"
        )
    return (low, high)


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _form_of_band(value: object) -> str:
    if isinstance(value, str):
        return "a name"
    return "limits" if isinstance(value, tuple) else "a response"


# Told apart by their form, so that an error speaks of the form that was typed only.
Band = Annotated[
    Annotated[str, Tag("a name")]
    | Annotated[Limits, Tag("limits")]
    | Annotated[ResponseBand, Tag("a response")],
    Discriminator(_form_of_band),
    BeforeValidator(_band),
]


def band_name(band: str | Limits | ResponseBand) -> str:
    """Name under which a band stands in the cube."""
    if isinstance(band, str):
        return band
    if isinstance(band, tuple):
        # Twelve digits keep narrow bands apart and do not show rounding.
        return f"{band[0]:.12g}-{band[1]:.12g}um"
    return band.name


def _several(bands: object) -> object:
    if isinstance(bands, list | tuple) and len(bands) == 2 and all(map(_is_number, bands)):
        raise PydanticCustomError(
            "bands",
            f"{shown(list(bands))} is a single band, not a list of bands; "
            f"closest valid choice is [{shown(list(bands))}]",
        )
    return bands


def _distinct(bands: tuple[Any, ...]) -> tuple[Any, ...]:
    names = [band_name(band) for band in bands]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        listed = ", ".join(map(shown, twice))
        raise PydanticCustomError("bands", f"{listed} given twice; allowed: each band once")
    return bands


Bands = Annotated[tuple[Band, ...], BeforeValidator(_several), AfterValidator(_distinct)]
