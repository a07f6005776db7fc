"""Parameters of the sensor model ``radiometer``; some are a number for all bands or a table by band."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, model_validator
from pydantic_core import PydanticCustomError

from hcss_twin.core.errors import Problem, ScenarioError, choose_from
from hcss_twin.core.units import ElectronRate, Electrons, Pixels, parse_quantity
from hcss_twin.core.units import QuantityParser as Quantity

__all__ = ["OfBands"]

AT = " at "
"""Between a temperature difference and the temperature of its black body."""

PerBand = float | dict[str, float]


def _parser(low: float, high: float, dimension: str) -> Callable[[object], object]:
    allowed = f"allowed: a number from {low:g} to {high:g}, or a table of such numbers by band"

    def number(value: object, where: str) -> float:
        if dimension:
            value = parse_quantity(value, dimension)
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise PydanticCustomError("per_band", f"{where}{value!r} is not a number; {allowed}")
        if not low <= value <= high:  # also rejects NaN
            nearest = "" if math.isnan(value) else f"; closest valid choice is {min(max(value, low), high):g}"
            raise PydanticCustomError("per_band", f"{where}{value:g} is out of range; {allowed}{nearest}")
        return float(value)

    def parse(value: object) -> object:
        if not isinstance(value, Mapping):
            return number(value, "")
        if not value or not all(isinstance(name, str) for name in value):
            raise PydanticCustomError("per_band", f"a table without names of bands; {allowed}")
        return {name: number(band_value, f"band '{name}': ") for name, band_value in value.items()}

    return parse


class OfBands:
    """A parameter that is a number for all bands, or a table with one for each."""

    @staticmethod
    def within(low: float, high: float, dimension: str = "") -> BeforeValidator:
        """Return a check that the numbers of a ``PerBand`` parameter are within ``low`` to ``high``, inclusive.

        With a dimension of :data:`hcss_twin.core.units.UNITS` they may be text with a unit.
        """
        return BeforeValidator(_parser(low, high, dimension))

    @staticmethod
    def number(value: PerBand, band: str, field: str) -> float:
        """Return the number of one band.

        Raises
        ------
        ScenarioError
            If the table does not contain the band.
        """
        if not isinstance(value, Mapping):
            return value
        if band not in value:
            message = f"gives no number for band '{band}'; {choose_from(band, value)}"
            raise ScenarioError([Problem(f"sensor.parameters.{field}", message)])
        return value[band]


_Fraction = Annotated[PerBand, OfBands.within(1e-6, 1.0, "fraction")]
_Kelvin = Annotated[PerBand, OfBands.within(1e-6, 1e3, "temperature difference")]
_Drift = Annotated[PerBand, OfBands.within(-1e3, 1e3, "temperature difference")]
_Scene = Annotated[PerBand, OfBands.within(60.0, 3000.0, "temperature")]
_Radiance = Annotated[PerBand, OfBands.within(1e-12, 1e9)]
_Offset = Annotated[PerBand, OfBands.within(0.0, 1e9)]

OF_PHOTONS = (
    "quantum_efficiency",
    "read_noise",
    "dark_current",
    "shot_noise",
    "offset_electrons",
    "well_depth",
    "electrons_per_number",
    "optics_temperature",
    "housing_temperature",
    "housing_etendue",
)
"""Parameters that count electrons."""

OF_RADIANCE = ("offset_radiance", "saturation_radiance", "radiance_per_number")
"""Their counterparts where electrons are not counted."""


class RadiometerKeys(BaseModel):
    """Keys of the ``radiometer``; "number or table" is one number, or a table with one for each band."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    psf: Literal["none", "gaussian", "airy", "file"] = Field(
        "none",
        description='Point-spread function of the optics: "gaussian" (psf_sigma), "airy" (aperture_diameter, '
        'pixel_angle) or "file" (psf_file).',
    )
    psf_sigma: Pixels | None = Field(
        None, gt=0, le=1000, description="Standard deviation of the Gaussian along either axis, pixels."
    )
    psf_file: str | None = Field(
        None,
        min_length=1,
        description="Text file with the image of a point on the image's pixels: rows of numbers, the "
        "southernmost first, odd numbers of rows and columns.",
    )
    aperture_diameter: Quantity.InstrumentLength | None = Field(None, gt=0, le=100, description="Of the telescope, m.")
    pixel_angle: Quantity.PixelAngle | None = Field(
        None,
        gt=0,
        le=0.1,
        description="Angle that the side of a pixel subtends, rad: detector pitch over focal length.",
    )
    transmission: _Fraction = Field(1.0, description="Of the optics, above 0 to 1.")
    integration_time: Quantity.Duration | None = Field(
        None, gt=0, le=1e4, description="Integration time of a frame, s."
    )
    jitter: Pixels = Field(
        0.0,
        ge=0,
        le=100,
        description="Rms movement of the line of sight within the integration time along either axis, pixels: a blur.",
    )
    smear: bool = Field(
        True, description="Blur along x by the footprint motion during integration_time, centred on the frame time."
    )
    noise: Literal["none", "photon", "nedt", "ner"] = Field(
        "none",
        description='"photon": computed from electron counts (needs aperture_diameter, pixel_angle, integration_time); '
        '"nedt" or "ner": Gaussian, with the given standard deviation.',
    )
    nedt: _Kelvin | None = Field(
        None,
        description='Noise-equivalent temperature difference (NEDT) of a black body, K, or text "20 mK at'
        ' 300 K". With noise = "photon" the read noise follows from it.',
    )
    nedt_temperature: _Scene = Field(300.0, description="Temperature of that black body, K.")
    ner: _Radiance | None = Field(None, description="Standard deviation of the noise as band radiance, W m-2 sr-1.")
    photon_temperature: Quantity.Temperature | None = Field(
        None,
        ge=60,
        le=10_000,
        description="Black-body temperature of the spectrum within a band, K, to convert radiance to "
        "photons; default: flat.",
    )
    quantum_efficiency: _Fraction = Field(1.0, description="Electrons per photon, above 0 to 1.")
    shot_noise: bool = Field(True, description="Whether to add shot noise (Poisson statistics of electrons).")
    read_noise: Electrons = Field(
        0.0, ge=0, le=1e9, description="Read noise of a pixel (standard deviation), electrons."
    )
    dark_current: ElectronRate = Field(
        0.0, ge=0, le=1e15, description="Electrons per second and pixel without light; its mean is subtracted."
    )
    optics_temperature: Quantity.Temperature | None = Field(
        None, ge=20, le=400, description="Of the optics, which emit 1 - transmission of a black body."
    )
    housing_temperature: Quantity.Temperature | None = Field(
        None, ge=20, le=400, description="Of the housing around the optics, black, which detectors see beside them."
    )
    housing_etendue: float | None = Field(
        None,
        gt=0,
        le=1e7,
        description="Etendue of the housing relative to that of the optics: (F / F_c)^2 - 1, with the "
        "f-number of the cold shield.",
    )
    drift: _Drift | None = Field(
        None,
        description="Change of the offset between two calibrations, as temperature of a black body of "
        "nedt_temperature, K.",
    )
    calibration_cycle: Quantity.Duration | None = Field(
        None, gt=0, le=1e7, description="Time between calibrations, the first of which is at the start, s."
    )
    fixed_pattern: Literal["pixel", "row"] = Field(
        "pixel",
        description='"pixel": one detector per pixel; "row": one detector per row, which causes stripes along x.',
    )
    gain_deviation: float = Field(0.0, ge=0, le=1, description="Standard deviation of the detectors' gain, relative.")
    offset_electrons: Electrons = Field(
        0.0, ge=0, le=1e9, description="Standard deviation of the detectors' offset, electrons."
    )
    offset_radiance: _Offset = Field(0.0, description="Standard deviation of the detectors' offset, W m-2 sr-1.")
    well_depth: Electrons | None = Field(
        None, gt=0, le=1e15, description="Full-well capacity of a detector, electrons, including dark current."
    )
    saturation_radiance: _Radiance | None = Field(
        None, description="Band radiance at which a detector saturates, W m-2 sr-1."
    )
    saturation_temperature: _Scene | None = Field(
        None, description="Temperature of the black body at which a detector saturates, K."
    )
    bits: int | None = Field(None, ge=1, le=24, description="Of the converter; default: not digitised.")
    electrons_per_number: Electrons | None = Field(
        None, gt=0, le=1e15, description="Electrons per digital number; default: the range / largest digital number."
    )
    radiance_per_number: _Radiance | None = Field(
        None, description="Radiance per digital number, W m-2 sr-1; default: the range / largest digital number."
    )
    number_offset: int = Field(
        0, ge=0, le=2**24 - 1, description="Digital number at zero signal; prevents clipping of noise around 0."
    )

    @model_validator(mode="before")
    @classmethod
    def _with_scene_temperature(cls, data: Any) -> Any:
        """Split ``nedt = "20 mK at 300 K"`` into ``nedt`` and ``nedt_temperature``."""
        given = data.get("nedt") if isinstance(data, Mapping) else None
        of_bands = given if isinstance(given, Mapping) else {"": given}
        pairs = {
            band: value.partition(AT)[::2] for band, value in of_bands.items() if isinstance(value, str) and AT in value
        }
        if not pairs:
            return data
        if "nedt_temperature" in data or len(pairs) < len(of_bands):
            raise PydanticCustomError(
                "nedt", f'"{next(iter(pairs.values()))[0]}{AT}..." with another scene temperature; allowed: "X{AT}Y" '
                "for every band, or nedt_temperature"
            )  # fmt: skip
        nedt, scene = ({band: pair[index] for band, pair in pairs.items()} for index in (0, 1))
        single = not isinstance(given, Mapping)
        return {**data, "nedt": nedt[""] if single else nedt, "nedt_temperature": scene[""] if single else scene}


class RadiometerParameters(RadiometerKeys):
    """Parameters of the ``radiometer``, complete and without contradictions."""

    @model_validator(mode="after")
    def _complete(self) -> Self:
        """Reject parameters that need missing ones, or that would have no effect."""
        needed = {
            "psf": {"gaussian": ("psf_sigma",), "airy": ("aperture_diameter", "pixel_angle"), "file": ("psf_file",)},
            "noise": {
                "photon": ("aperture_diameter", "pixel_angle", "integration_time"),
                "nedt": ("nedt",),
                "ner": ("ner",),
            },
        }
        for key, table in needed.items():
            choice = getattr(self, key)
            missing = [name for name in table.get(choice, ()) if getattr(self, name) is None]
            if missing:
                raise PydanticCustomError("needs", f'{key} = "{choice}" needs {" and ".join(missing)}')
        for name, key, choices in _IDLE:
            if name in self.model_fields_set and getattr(self, key) not in choices:
                wanted = " or ".join(f'"{choice}"' for choice in choices)
                raise PydanticCustomError(
                    "idle",
                    f'{name} has no influence with {key} = "{getattr(self, key)}"; allowed with {key} = {wanted}',
                )
        given = [name for name in _ETENDUE if getattr(self, name) is not None]
        if len(given) == 1:
            other = next(name for name in _ETENDUE if name not in given)
            raise PydanticCustomError("needs", f"{given[0]} has no effect without {other}")
        for name, other in (*_PAIRS, *(pair[::-1] for pair in _PAIRS)):
            if getattr(self, name) is not None and getattr(self, other) is None:
                raise PydanticCustomError("needs", f"{name} has no effect without {other}")
        if self.optics_temperature is not None and self.transmission == 1.0:
            raise PydanticCustomError("needs", "optics_temperature has no effect without transmission below 1")
        if "nedt_temperature" in self.model_fields_set and self.nedt is None and self.drift is None:
            raise PydanticCustomError("idle", "nedt_temperature has no effect without nedt or drift")
        if self.saturation_temperature is not None and self.saturation_radiance is not None:
            raise PydanticCustomError("twice", "saturation_temperature with saturation_radiance; allowed: one of them")
        for name in ("transmission", "photon_temperature"):
            if name in self.model_fields_set and not given:
                raise PydanticCustomError("idle", f"{name} has no effect without {' and '.join(_ETENDUE)}")
        self._check_converter()
        return self

    def _check_converter(self) -> None:
        if self.bits is None:
            for name in ("electrons_per_number", "radiance_per_number", "number_offset"):
                if name in self.model_fields_set:
                    raise PydanticCustomError("idle", f"{name} has no effect without bits")
            return
        range_of, step = (
            ("well_depth", "electrons_per_number")
            if self.noise == "photon"
            else ("saturation_radiance", "radiance_per_number")
        )
        if getattr(self, range_of) is None and getattr(self, step) is None and self.saturation_temperature is None:
            raise PydanticCustomError("needs", f"bits needs {step}, {range_of} or saturation_temperature")
        if self.number_offset > 2**self.bits - 1:
            raise PydanticCustomError(
                "number_offset",
                f"number_offset {self.number_offset}; allowed with {self.bits} bits: 0 to {2**self.bits - 1}",
            )


_ETENDUE = ("aperture_diameter", "pixel_angle")
"""Parameters that convert radiance to photons."""

_PAIRS = ("drift", "calibration_cycle"), ("housing_temperature", "housing_etendue")
"""Parameters that mean nothing alone."""

_IDLE = (
    ("psf_sigma", "psf", ("gaussian",)),
    ("psf_file", "psf", ("file",)),
    ("nedt", "noise", ("nedt", "photon")),
    ("ner", "noise", ("ner",)),
    *((name, "noise", ("photon",)) for name in OF_PHOTONS),
    *((name, "noise", ("none", "nedt", "ner")) for name in OF_RADIANCE),
)
"""Parameter, the option it depends on, and the values with which it has an effect."""
