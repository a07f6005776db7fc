"""The ``bands`` key: each entry a catalog name, limits, a measured response or a Gaussian one; each band once."""

from __future__ import annotations

import math
from typing import Annotated, Any, Self

from pydantic import AfterValidator, BeforeValidator, Discriminator, Field, Tag, model_validator
from pydantic_core import PydanticCustomError

from hcss_twin.errors import closest
from hcss_twin.scenario.section import Section
from hcss_twin.scenario.units import Number
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

SHORTEST_UM, LONGEST_UM = 0.1, 1000.0

GAUSSIAN_CUT = 1e-4
"""Response, relative to its peak, at which a Gaussian one ends; 2e-5 of its area lies beyond."""

GAUSSIAN_REACH = math.sqrt(math.log(1.0 / GAUSSIAN_CUT) / (4.0 * math.log(2.0)))
"""Distance of the ends from the centre in full widths at half maximum, 1.82."""


def _band(value: object) -> object:
    if isinstance(value, dict):
        forms = [form for form, keys in _FORMS.items() if any(key in value for key in keys)]
        if len(forms) > 1:
            given = ", ".join(key for keys in _FORMS.values() for key in keys if key in value)
            raise PydanticCustomError("band", f"{given} in one band; allowed: {_ALLOWED}")
        return value
    if isinstance(value, str | ResponseBand | LimitsBand | GaussianBand):
        return value
    if isinstance(value, list | tuple):
        return _limits(value)
    raise PydanticCustomError("band", f"{shown(value)} is not a band; allowed: {_ALLOWED}")


_FORMS = {"named limits": ("limits",), "a Gaussian": ("center_um", "fwhm_um"), "a response": ("response",)}
"""Keys by which the forms of a table are told apart."""

_ALLOWED = "a name, [shortest_um, longest_um], {name, response}, {name, limits} or {name, center_um, fwhm_um}"


def _limits_of(value: object) -> object:
    if isinstance(value, list | tuple):
        return _limits(value)
    raise PydanticCustomError("band", f"{shown(value)} is not [shortest_um, longest_um]")


def _limits(value: list[Any] | tuple[Any, ...]) -> Limits:
    allowed = "allowed: [shortest_um, longest_um], two numbers from 0.1 to 1000"
    if len(value) != 2 or not all(map(_is_number, value)):
        raise PydanticCustomError("band", f"{shown(list(value))} is not a band; {allowed}")
    if not all(SHORTEST_UM <= limit <= LONGEST_UM for limit in value):  # also refuses NaN
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


class LimitsBand(Section):
    """A band of response 1 between two limits, with a name of its own."""

    name: str = Field(min_length=1, max_length=60, description="Name of the band in the cube.")
    limits: Annotated[tuple[float, float], BeforeValidator(_limits_of)] = Field(
        description="[shortest_um, longest_um]."
    )


class GaussianBand(Section):
    """A band whose response over wavelength is a Gaussian of peak 1, cut where it is 1e-4."""

    name: str = Field(min_length=1, max_length=60, description="Name of the band in the cube.")
    center_um: Number = Field(ge=SHORTEST_UM, le=LONGEST_UM, description="Wavelength of the peak, um.")
    fwhm_um: Number = Field(gt=0, le=LONGEST_UM, description="Full width at half of the maximum, um.")

    @property
    def ends_um(self) -> Limits:
        """Wavelengths at which the response is cut."""
        reach = GAUSSIAN_REACH * self.fwhm_um
        return self.center_um - reach, self.center_um + reach

    @model_validator(mode="after")
    def _inside(self) -> Self:
        low, high = self.ends_um
        allowed = f"allowed: {SHORTEST_UM:g} to {LONGEST_UM:g} um"
        if low < SHORTEST_UM or high > LONGEST_UM:
            widest = min(self.center_um - SHORTEST_UM, LONGEST_UM - self.center_um) / GAUSSIAN_REACH
            raise PydanticCustomError(
                "fwhm_um",
                f"its response ends at {low:g} and {high:g} um, where it is {GAUSSIAN_CUT:g} of its peak; {allowed}; "
                f"closest valid choice of fwhm_um is {widest:g}",
            )
        if high - low < NARROWEST * self.center_um:
            raise PydanticCustomError(
                "fwhm_um",
                f"fwhm_um {self.fwhm_um:g} is too narrow; allowed: at least {NARROWEST:g} of the wavelength",
            )
        return self


def _form_of_band(value: object) -> str:
    if isinstance(value, str):
        return "a name"
    if isinstance(value, dict):
        return next(
            (form for form, keys in _FORMS.items() if any(map(value.__contains__, keys))), _meant(value)
        )
    if isinstance(value, LimitsBand | GaussianBand):
        return "named limits" if isinstance(value, LimitsBand) else "a Gaussian"
    return "limits" if isinstance(value, tuple) else "a response"


def _meant(table: dict[Any, Any]) -> str:
    """Form of which a table has a misspelt key; a response where there is none."""
    form_of = {key: form for form, keys in _FORMS.items() for key in keys}
    meant = [closest(key, form_of) for key in table if isinstance(key, str) and key != "name"]
    return next((form_of[key] for key in meant if key is not None), "a response")


# Told apart by their form, so that an error speaks of the form that was typed only.
Band = Annotated[
    Annotated[str, Tag("a name")]
    | Annotated[Limits, Tag("limits")]
    | Annotated[LimitsBand, Tag("named limits")]
    | Annotated[GaussianBand, Tag("a Gaussian")]
    | Annotated[ResponseBand, Tag("a response")],
    Discriminator(_form_of_band),
    BeforeValidator(_band),
]


AnyBand = str | Limits | LimitsBand | GaussianBand | ResponseBand


def band_name(band: AnyBand) -> str:
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
