"""The ``bands`` key: catalog names, limits, and measured or Gaussian responses; without duplicates."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Self

import numpy as np
from pydantic import AfterValidator, BeforeValidator, Discriminator, Field, Tag, model_validator
from pydantic_core import PydanticCustomError

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import CatalogError, Problem, choose_from
from hcss_twin.core.units import QuantityParser
from hcss_twin.models.radiance.spectral_grid import SpectralBand
from hcss_twin.providers import SensorBand
from hcss_twin.scenario.response_file import LONGEST_UM, NARROWEST, SHORTEST_UM, StatedUnit, read_response
from hcss_twin.scenario.section_types import ScenarioSection

__all__ = ["spectral_band"]


class ResponseBand(ScenarioSection):
    """A band with a measured spectral response."""

    name: str = Field(min_length=1, max_length=60, description="Name of the band in the cube.")
    response: str = Field(
        min_length=1,
        description="Text file with columns of wavelength (um, nm) or wavenumber (cm-1) and response, as agencies "
        "publish them, relative to the scenario.",
    )
    column: str | None = Field(
        default=None, min_length=1, description="Label or number (from 1) of the response, if the file has several."
    )
    unit: StatedUnit | None = Field(
        default=None, description="Unit of wavelength or wavenumber, if the file does not say it."
    )


Limits = tuple[float, float]

GAUSSIAN_CUT = 1e-4
"""Response, relative to its peak, at which a Gaussian is truncated; this omits 2e-5 of its area."""

GAUSSIAN_REACH = math.sqrt(math.log(1.0 / GAUSSIAN_CUT) / (4.0 * math.log(2.0)))
"""Distance of the limits from the centre in full widths at half maximum, 1.82."""


def _band(value: object) -> object:
    if isinstance(value, dict):
        forms = [form for form, keys in _FORMS.items() if any(key in value for key in keys)]
        if len(forms) > 1:
            given = ", ".join(key for keys in _FORMS.values() for key in keys if key in value)
            raise PydanticCustomError("band", f"{given} in one band; allowed: {_ALLOWED}")
        return value
    if isinstance(value, str):
        return value if (limits := written_limits(value)) is None else _limits(limits)
    if isinstance(value, ResponseBand | LimitsBand | GaussianBand):
        return value
    if isinstance(value, list | tuple):
        return _limits(value)
    raise PydanticCustomError("band", f"{Problem.shown(value)} is not a band; allowed: {_ALLOWED}")


_FORMS = {
    "named limits": ("limits",),
    "a Gaussian": ("center_um", "fwhm_um"),
    "a response": ("response", "column", "unit"),
}
"""Keys by which the forms of a table are told apart."""

_ALLOWED = "a name, [shortest_um, longest_um], {name, response}, {name, limits} or {name, center_um, fwhm_um}"


_NUMBER = r"[0-9]+(?:\.[0-9]+)?"
_WRITTEN = re.compile(rf"({_NUMBER}) ?- ?({_NUMBER}) ?[uµμ]m")


def written_limits(text: str) -> tuple[float, float] | None:
    """Return limits that are written as text with their unit, such as ``8-14 um``; None if the text is no such."""
    match = _WRITTEN.fullmatch(text)
    return (float(match[1]), float(match[2])) if match else None


def _limits_of(value: object) -> object:
    if isinstance(value, list | tuple):
        return _limits(value)
    raise PydanticCustomError("band", f"{Problem.shown(value)} is not [shortest_um, longest_um]")


def _limits(value: list[Any] | tuple[Any, ...]) -> Limits:
    allowed = "allowed: [shortest_um, longest_um], two numbers from 0.1 to 1000"
    if len(value) != 2 or not all(map(_is_number, value)):
        raise PydanticCustomError("band", f"{Problem.shown(list(value))} is not a band; {allowed}")
    if not all(SHORTEST_UM <= limit <= LONGEST_UM for limit in value):  # also refuses NaN
        raise PydanticCustomError("band", f"{Problem.shown(list(value))} um is out of range; {allowed}")
    low, high = float(value[0]), float(value[1])
    if low == high:
        raise PydanticCustomError("band", f"{Problem.shown(list(value))} um has no width; {allowed}, ascending")
    if abs(high - low) < NARROWEST * max(low, high):
        narrowest = f"allowed: at least {NARROWEST:g} of the wavelength"
        raise PydanticCustomError("band", f"{Problem.shown(list(value))} um is too narrow; {narrowest}")
    if low > high:
        raise PydanticCustomError(
            "band", f"[{low:g}, {high:g}] um is reversed; closest valid choice is [{high:g}, {low:g}]"
        )
    return (low, high)


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


class LimitsBand(ScenarioSection):
    """A named band with response 1 between two limits."""

    name: str = Field(min_length=1, max_length=60, description="Name of the band in the cube.")
    limits: Annotated[tuple[float, float], BeforeValidator(_limits_of)] = Field(
        description="[shortest_um, longest_um]."
    )


class GaussianBand(ScenarioSection):
    """A band with a Gaussian response over wavelength, peak 1, truncated at 1e-4."""

    name: str = Field(min_length=1, max_length=60, description="Name of the band in the cube.")
    center_um: QuantityParser.Number = Field(ge=SHORTEST_UM, le=LONGEST_UM, description="Wavelength of the peak, um.")
    fwhm_um: QuantityParser.Number = Field(gt=0, le=LONGEST_UM, description="Full width at half of the maximum, um.")

    @property
    def ends_um(self) -> Limits:
        """Wavelengths at which the response is truncated."""
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
                "fwhm_um", f"fwhm_um {self.fwhm_um:g} is too narrow; allowed: at least {NARROWEST:g} of the wavelength"
            )
        return self


def _form_of_band(value: object) -> str:
    if isinstance(value, str):
        return "a name"
    if isinstance(value, dict):
        return next((form for form, keys in _FORMS.items() if any(map(value.__contains__, keys))), _meant(value))
    if isinstance(value, LimitsBand | GaussianBand):
        return "named limits" if isinstance(value, LimitsBand) else "a Gaussian"
    return "limits" if isinstance(value, tuple) else "a response"


def _meant(table: dict[Any, Any]) -> str:
    """Return the form whose key a table misspells; a response if there is none."""
    form_of = {key: form for form, keys in _FORMS.items() for key in keys}
    meant = [Problem.closest(key, form_of) for key in table if isinstance(key, str) and key != "name"]
    return next((form_of[key] for key in meant if key is not None), "a response")


# Discriminated by form, so that an error refers only to the form that was typed.
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
    """Return the name of a band in the cube."""
    if isinstance(band, str):
        return band
    if isinstance(band, tuple):
        # Twelve digits distinguish narrow bands and hide rounding.
        return f"{band[0]:.12g}-{band[1]:.12g}um"
    return band.name


def _several(bands: object) -> object:
    if isinstance(bands, list | tuple) and len(bands) == 2 and all(map(_is_number, bands)):
        raise PydanticCustomError(
            "bands",
            f"{Problem.shown(list(bands))} is a single band, not a list of bands; "
            f"closest valid choice is [{Problem.shown(list(bands))}]",
        )
    return bands


def _distinct(bands: tuple[Any, ...]) -> tuple[Any, ...]:
    names = [band_name(band) for band in bands]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        listed = ", ".join(map(Problem.shown, twice))
        raise PydanticCustomError("bands", f"{listed} given twice; allowed: each band once")
    return bands


Bands = Annotated[tuple[Band, ...], BeforeValidator(_several), AfterValidator(_distinct)]


_WAVELENGTH = re.compile(rf"([a-z]+)-?({_NUMBER})(?: ?um)?")


def named_bands(catalog: Catalog) -> Mapping[str, Mapping[str, Any]]:
    """Catalog bands by name."""
    bands: Mapping[str, Mapping[str, Any]] = catalog.toml(catalog.find("bands", "", ".toml"))["bands"]
    return bands


GAUSSIAN_NODES = 129
"""Number of wavelengths of a Gaussian response; linear interpolation errs by at most 6e-4 of the peak."""


def unknown_band(name: str, known: Mapping[str, Mapping[str, Any]]) -> str:
    """Return the message for an unknown band, with the known and the closest names.

    A number at the end of a name is interpreted as a wavelength in um: the closest band is the narrowest one around
    it with the same prefix, or else the one with the nearest centre. Two numbers are interpreted as limits.
    """
    message = f"no band named {Problem.shown(name)}; {choose_from(name, known)}"
    numbers = sorted(float(number) for number in re.findall(_NUMBER, name))
    if len(numbers) == 2 and SHORTEST_UM <= numbers[0] < numbers[1] <= LONGEST_UM:
        ends = {band: known[band]["limits_um"] for band in known}
        guess = min(ends, key=lambda band: sum(abs(np.log(np.divide(ends[band], numbers)))))
        low, high = ends[guess]
        message = f"{message.partition('; closest is')[0]}; closest is '{guess}' ({low:g} to {high:g} um)"
        return f"{message}; a band of your own is written [{numbers[0]}, {numbers[1]}]"
    match = _WAVELENGTH.fullmatch(name)
    alike = [band for band in known if match and band.startswith(f"{match[1]}-")]
    if not match or not alike:
        return message
    wavelength = float(match[2])
    limits = {band: known[band]["limits_um"] for band in alike}
    around = [band for band in alike if limits[band][0] <= wavelength <= limits[band][1]]
    guess = (
        min(around, key=lambda band: limits[band][1] - limits[band][0])
        if around
        else min(alike, key=lambda band: abs(sum(limits[band]) / 2 - wavelength))
    )
    low, high = limits[guess]
    return f"{message.partition('; closest is')[0]}; closest is '{guess}' ({low:g} to {high:g} um)"


def spectral_band(band: AnyBand, catalog: Catalog) -> SpectralBand:
    """Resolve one entry of a scenario's ``bands``.

    Raises
    ------
    CatalogError
        If a name is unknown or a response file is malformed.
    """
    if isinstance(band, ResponseBand):
        measured = read_response(band.response, catalog, band.name, band.column, band.unit)
        return SpectralBand(band.name, measured.wavelength_um, measured.response, measured.read_as)
    if isinstance(band, GaussianBand):
        wavelength = np.linspace(*band.ends_um, GAUSSIAN_NODES)
        distance = (wavelength - band.center_um) / band.fwhm_um
        return SpectralBand(band.name, wavelength, np.exp(-4.0 * np.log(2.0) * distance**2))
    if isinstance(band, str):
        known = named_bands(catalog)
        if band not in known:
            raise CatalogError(unknown_band(band, known))
        limits = known[band]["limits_um"]
    elif isinstance(band, LimitsBand):
        limits = band.limits
    else:
        limits = band
    return SpectralBand(band_name(band), np.array(limits, dtype=np.float64), np.ones(2))


def sensor_bands(bands: Sequence[SpectralBand]) -> tuple[SensorBand, ...]:
    """Return the bands in the form of the provider API."""
    return tuple(SensorBand(band.name, band.wavelength_um, band.response) for band in bands)
