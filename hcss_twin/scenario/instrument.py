"""One instrument, from which camera, image and sensor of a scenario follow; and named instruments."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, model_validator
from pydantic_core import PydanticCustomError

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import Problem
from hcss_twin.core.units import UNITS, parse_quantity
from hcss_twin.core.units import QuantityParser as Quantity
from hcss_twin.models.sensor.parameters import OF_PHOTONS, RadiometerKeys, RadiometerParameters
from hcss_twin.scenario.bands import Bands
from hcss_twin.scenario.problems import read_model
from hcss_twin.scenario.response_file import StatedUnit
from hcss_twin.scenario.section_types import AGREEMENT

DEFAULT_MODEL = "radiometer"

FOLDER = "instruments"
"""Catalog folder with a file for each named instrument."""


def _pixels_or_angle(value: object) -> object:
    """Convert text with px to a number of pixels; text with an angle stays, since it needs the angle of a pixel."""
    if not isinstance(value, str):
        return value
    unit = value.strip().lstrip("+-.0123456789eE").strip()
    if unit in UNITS["angle of a pixel"]:
        return f"{parse_quantity(value, 'angle of a pixel')!r} rad"
    try:
        return parse_quantity(value, "image distance")
    except PydanticCustomError as error:
        angles = ", ".join(UNITS["angle of a pixel"])
        raise PydanticCustomError(
            "jitter", f"{Problem.shown(value)} is no jitter; allowed: a number of pixels, or text with px, {angles}"
        ) from error


_PixelsOrAngle = Annotated[float | str, BeforeValidator(_pixels_or_angle)]


class Instrument(RadiometerKeys):
    """Optics, detector and read-out. The keys of the sensor model `radiometer` are keys of the instrument, too."""

    rows: Quantity.Whole | None = Field(None, ge=1, le=16384, description="Rows of the detector.")
    columns: Quantity.Whole | None = Field(None, ge=1, le=16384, description="Columns of the detector.")
    focal_length: Quantity.InstrumentLength | None = Field(
        None,
        ge=1e-4,
        le=1000,
        description="Focal length, m; follows from f_number and aperture_diameter, or detector_pitch and pixel_angle.",
    )
    detector_pitch: Quantity.InstrumentLength | None = Field(
        None, ge=1e-7, le=0.01, description="Distance between detectors, m; follows from focal_length and pixel_angle."
    )
    f_number: Quantity.Number | None = Field(
        None, ge=0.5, le=1000, description="Focal length over diameter of the aperture."
    )
    cold_shield: Quantity.Number | None = Field(
        None, ge=0.5, le=500, description="F-number of the cold shield, if wider than that of the optics."
    )
    jitter: _PixelsOrAngle = Field(  # type: ignore[assignment]
        0.0,
        description='Rms movement of the line of sight about either axis: pixels, or text ("0.3 px", "20 '
        'urad"). Turns a camera in orbit (`[jitter]` has the spectrum), otherwise a blur.',
    )
    bands: Bands | None = Field(None, min_length=1, max_length=100, description="As `bands` of a scenario.")
    response: str | None = Field(
        None, min_length=1, description="Response file of a single band, which gets its name; in place of `bands`."
    )
    response_column: str | None = Field(
        None, min_length=1, description="Label or number (from 1) of the response, if the file has several."
    )
    response_unit: StatedUnit | None = Field(
        None, description="Unit of wavelength or wavenumber, if the file does not say it."
    )
    psf: Literal["none", "gaussian", "airy", "file"] | None = Field(  # type: ignore[assignment]
        None,
        description='Point-spread function of the optics: "none", "gaussian" (psf_sigma), "airy" '
        '(diffraction) or "file" (psf_file). Default: that whose key is given; else "airy" '
        "where aperture and angle of a pixel are known.",
    )
    model: str = Field(DEFAULT_MODEL, description="Sensor model (see `hcss plugins`).")
    parameters: dict[str, Any] = Field(
        default_factory=dict, description="Parameters of another sensor model, or further ones of this."
    )

    @model_validator(mode="after")
    def _is_consistent(self) -> Self:
        """Reject keys that contradict each other, or that the sensor model rejects."""
        if self.bands is not None and self.response is not None:
            raise PydanticCustomError("twice", "response with bands; allowed: one of them")
        for name in _OF_RESPONSE:
            if getattr(self, name) is not None and self.response is None:
                raise PydanticCustomError("idle", f"{name} has no effect without response")
        twice = sorted(set(self.parameters) & self.model_fields_set)
        if twice:
            raise PydanticCustomError("twice", f"{', '.join(twice)} also in parameters; allowed: once")
        geometry = self.geometry
        if self.cold_shield is not None:
            number = geometry.get("f_number")
            if number is None or not self.cold_shield < number:
                raise PydanticCustomError(
                    "cold_shield",
                    f"cold_shield f/{self.cold_shield:g} with optics of "
                    f"{'unknown f-number' if number is None else f'f/{number:.4g}'}; allowed: a known f_number, and a "
                    "smaller one of the cold shield",
                )
        if isinstance(self.jitter, str) and "pixel_angle" not in geometry:
            raise PydanticCustomError(
                "jitter", "jitter as an angle needs detector_pitch and focal_length, or pixel_angle"
            )
        if not isinstance(self.jitter, str) and not 0.0 <= self.jitter <= 100.0:
            raise PydanticCustomError("jitter", f"jitter {self.jitter:g} is out of range; allowed: 0 to 100 pixels")
        if self.is_radiometer:
            RadiometerParameters.model_validate(self.sensor_parameters())
        elif others := sorted(self.model_fields_set & set(RadiometerKeys.model_fields) - {"pixel_angle", "jitter"}):
            raise PydanticCustomError(
                "model", f"{', '.join(others)} with model '{self.model}'; allowed: its parameters in `parameters`"
            )
        return self

    @property
    def is_radiometer(self) -> bool:
        """Whether the sensor model is that of this package, whose keys are those of the instrument."""
        return self.model.rpartition("/")[2] == DEFAULT_MODEL

    @property
    def geometry(self) -> dict[str, float]:
        """Known ones of focal length, pitch, angle of a pixel, f-number and aperture, in m and rad.

        Raises
        ------
        PydanticCustomError
            If they contradict each other.
        """
        names = ("focal_length", "detector_pitch", "pixel_angle", "f_number", "aperture_diameter")
        known: dict[str, float] = {name: value for name in names if (value := getattr(self, name)) is not None}
        for _ in range(2):  # the aperture may give the focal length, and that the angle
            for top, bottom, ratio in _RATIOS:
                if {top, bottom} <= known.keys():
                    implied = known[top] / known[bottom]
                    if not abs(known.setdefault(ratio, implied) / implied - 1.0) <= AGREEMENT:
                        raise PydanticCustomError(
                            "geometry",
                            f"{ratio} {known[ratio]:.4g}, and {top} {known[top]:.4g} with {bottom} {known[bottom]:.4g} "
                            f"make {implied:.4g}; allowed: two of the three, or all within {100 * AGREEMENT:g} %",
                        )
                elif {top, ratio} <= known.keys():
                    known[bottom] = known[top] / known[ratio]
                elif {bottom, ratio} <= known.keys():
                    known[top] = known[bottom] * known[ratio]
        return known

    @property
    def jitter_pixels(self) -> float:
        """Jitter in pixels."""
        if isinstance(self.jitter, str):
            return float(self.jitter.removesuffix(" rad")) / self.geometry["pixel_angle"]
        return self.jitter

    def sensor_parameters(self, jitter: bool = True) -> dict[str, Any]:
        """Parameters of the sensor model, with or without the blur by jitter."""
        if not self.is_radiometer:
            return dict(self.parameters)
        own = {name: getattr(self, name) for name in RadiometerKeys.model_fields if name in self.model_fields_set}
        own = {name: value for name, value in own.items() if value is not None} | self.parameters
        own.pop("jitter", None)
        if jitter and self.jitter_pixels > 0.0:
            own["jitter"] = self.jitter_pixels
        geometry = self.geometry
        pair = ("aperture_diameter", "pixel_angle")
        own = {name: value for name, value in own.items() if name not in pair}
        if all(name in geometry for name in pair):
            own |= {name: geometry[name] for name in pair}
        if self.cold_shield is not None and "housing_etendue" not in own:
            own["housing_etendue"] = (geometry["f_number"] / self.cold_shield) ** 2 - 1.0
        for choice, kinds in _FOLLOWS.items():
            if choice not in own:
                own[choice] = next((kind for kind, keys in kinds.items() if any(key in own for key in keys)), "none")
        return own

    def band_keys(self) -> Any:
        """Value of the key ``bands`` of a scenario; None if the instrument says nothing."""
        if self.response is not None:
            stated = {name.removeprefix("response_"): getattr(self, name) for name in _OF_RESPONSE}
            about = {name: value for name, value in stated.items() if value is not None}
            return [{"name": Path(self.response).stem or "response", "response": self.response, **about}]
        return self.model_dump(mode="json")["bands"]


_OF_RESPONSE = "response_column", "response_unit"
"""Keys about the file of ``response``."""

_FOLLOWS: dict[str, dict[str, tuple[str, ...]]] = {
    "psf": {"gaussian": ("psf_sigma",), "file": ("psf_file",), "airy": ("aperture_diameter",)},
    "noise": {"photon": OF_PHOTONS, "nedt": ("nedt",), "ner": ("ner",)},
}
"""Parameters of the sensor model that follow from which others are known; otherwise they are "none"."""

_RATIOS = ("detector_pitch", "focal_length", "pixel_angle"), ("focal_length", "aperture_diameter", "f_number")
"""Two keys and that of their ratio."""


class InstrumentSection(Instrument):
    """The instrument: `[camera]`, or `[image]` and `[platform]`, and `[sensor]` and `bands` follow from it."""

    name: str | None = Field(
        None, min_length=1, description="Catalog name or TOML file of an instrument, whose keys these override."
    )


class NamedInstrument(Instrument):
    """An instrument file from ``catalogs/instruments`` or from a user."""

    title: str = Field(min_length=1, description="What it is.")
    description: str = Field("", description="Meaning of the numbers, and effects they omit.")
    sources: dict[str, str] = Field(description="Where each number comes from, by its key; 'bands' for the bands.")

    @model_validator(mode="after")
    def _every_number_has_its_source(self) -> Self:
        about = {"title", "description", "sources", "model", "parameters"}
        given = [name for name in type(self).model_fields if name in self.model_fields_set - about]
        missing = [key for key in (*given, *self.parameters) if key not in self.sources]
        if missing:
            raise PydanticCustomError(
                "sources", f"sources lacks {', '.join(missing)}; allowed: a source for each number given"
            )
        return self

    @property
    def keys(self) -> dict[str, Any]:
        """Keys of the instrument as in the file, in plain units."""
        of_file = {"title", "description", "sources"}
        return self.model_dump(mode="json", include=self.model_fields_set - of_file)


def load_instrument(name: str, catalog: Catalog) -> NamedInstrument:
    """Read a named instrument.

    Raises
    ------
    CatalogError
        If there is no such file, or it is not TOML.
    ScenarioError
        If a key of the file is wrong; its ``origin`` is the file.
    """
    return read_model(NamedInstrument, catalog, catalog.find(name, FOLDER, ".toml"))
