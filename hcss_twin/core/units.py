"""Quantities of a scenario: plain numbers in SI (angles in degrees, particles in um and g m-3), or text with a unit."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import BeforeValidator, WithJsonSchema
from pydantic_core import PydanticCustomError

from hcss_twin.core.errors import Problem

__all__ = ["QuantityParser"]

# unit -> (factor, offset): SI value = factor * value + offset. The first unit is the plain number's.
UNITS: dict[str, dict[str, tuple[float, float]]] = {
    "length": {"m": (1.0, 0.0), "km": (1e3, 0.0), "cm": (1e-2, 0.0), "ft": (0.3048, 0.0)},
    "length in km": {"km": (1.0, 0.0), "m": (1e-3, 0.0)},
    "area": {"m2": (1.0, 0.0), "cm2": (1e-4, 0.0), "km2": (1e6, 0.0)},
    "angle": {
        "deg": (1.0, 0.0),
        "rad": (180.0 / math.pi, 0.0),
        "mrad": (0.18 / math.pi, 0.0),
        "urad": (0.18e-3 / math.pi, 0.0),
        "arcsec": (1.0 / 3600.0, 0.0),
    },
    "angle of a pixel": {
        "rad": (1.0, 0.0),
        "mrad": (1e-3, 0.0),
        "urad": (1e-6, 0.0),
        "arcsec": (math.pi / 648e3, 0.0),
        "deg": (math.pi / 180.0, 0.0),
    },
    "temperature": {"K": (1.0, 0.0), "degC": (1.0, 273.15)},
    "temperature difference": {"K": (1.0, 0.0), "mK": (1e-3, 0.0)},
    "speed": {"m/s": (1.0, 0.0), "km/s": (1e3, 0.0), "km/h": (1 / 3.6, 0.0), "kn": (1852 / 3600, 0.0)},
    "duration": {"s": (1.0, 0.0), "ms": (1e-3, 0.0), "us": (1e-6, 0.0), "min": (60.0, 0.0), "h": (3600.0, 0.0)},
    "fraction": {"": (1.0, 0.0), "%": (0.01, 0.0)},
    "particle radius": {"um": (1.0, 0.0), "nm": (1e-3, 0.0), "mm": (1e3, 0.0)},
    "length in an instrument": {"m": (1.0, 0.0), "cm": (1e-2, 0.0), "mm": (1e-3, 0.0), "um": (1e-6, 0.0)},
    "image distance": {"px": (1.0, 0.0)},
    "electrons": {"e": (1.0, 0.0), "ke": (1e3, 0.0), "Me": (1e6, 0.0)},
    "electrons per time": {"e/s": (1.0, 0.0), "ke/s": (1e3, 0.0), "Me/s": (1e6, 0.0)},
    "frequency": {"Hz": (1.0, 0.0), "kHz": (1e3, 0.0)},
    "water content": {"g/m3": (1.0, 0.0), "kg/m3": (1e3, 0.0), "mg/m3": (1e-3, 0.0)},
}

_QUANTITY = re.compile(r"\s*([-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?)\s*(\S*)\s*")


def parse_quantity(value: object, dimension: str) -> object:
    """Convert ``"20 km"`` to 20000.0; return anything but text unchanged.

    Raises
    ------
    PydanticCustomError
        If the text is not a number with a unit of this dimension.
    """
    if not isinstance(value, str):
        return value
    units = UNITS[dimension]
    match = _QUANTITY.fullmatch(value)
    if match is None:
        raise PydanticCustomError(
            "not_a_quantity", f"{Problem.shown(value)} is not a number with a unit; {_allowed(dimension)}"
        )
    number, unit = match.groups()
    if unit not in units:
        if not unit:
            return float(number)
        guess = _closest_unit(unit, dimension)
        hint = f"; closest is '{guess}'" if guess else ""
        raise PydanticCustomError(
            "wrong_unit",
            f"{Problem.shown(value)}: {Problem.shown(unit)} is not a unit of {dimension}; {_allowed(dimension)}{hint}",
        )
    factor, offset = units[unit]
    per_plain = round(1.0 / factor)
    # Division by a whole number gives the float that is closest to the decimal number, 15 um = 1.5e-5.
    plain = float(number) / per_plain if factor * per_plain == 1.0 else factor * float(number)
    return plain + offset


def quantity_or_word(dimension: str, low: float, high: float, *words: str, above: str) -> Callable[[object], object]:
    """Return a validator for a quantity from ``low`` to ``high`` or a word; for larger values it suggests ``above``."""
    plain = next(iter(UNITS[dimension]))
    named = " or ".join(f'"{word}"' for word in words)
    allowed = f"allowed: {low:g} to {high:g} {plain}, or {named}".replace("e+", "e")

    def parse(value: object) -> object:
        if value in words:
            return value
        if isinstance(value, str) and (word := Problem.closest(value, words)):
            raise PydanticCustomError(
                "quantity_or_word", f"{Problem.shown(value)} is not a {dimension}; {allowed}; closest is '{word}'"
            )
        number = parse_quantity(value, dimension)
        if isinstance(number, bool) or not isinstance(number, int | float):
            raise PydanticCustomError("quantity_or_word", f"{Problem.shown(value)} is not a {dimension}; {allowed}")
        if not low <= number <= high:
            nearest = f"{low:g}" if number < low else above
            nearest = meant_in(dimension, number, low, high) or nearest
            hint = f"; closest valid choice is {nearest}" if number == number else ""  # NaN has no closest value
            raise PydanticCustomError("quantity_or_word", f"{Problem.shown(value)} is out of range; {allowed}{hint}")
        return float(number)

    return parse


_OFTEN_MEANT = {
    "temperature": ("degC",),
    "fraction": ("%",),
    "length": ("km",),
    "length in an instrument": ("um", "mm"),
}
"""Units in which plain numbers are often typed by mistake, by dimension; the first that fits the limits is meant."""


def meant_in(dimension: str, value: float, low: float, high: float) -> str | None:
    """Return the value in plain units if a number outside these limits was probably meant in another unit."""
    for unit in _OFTEN_MEANT.get(dimension, ()):
        factor, offset = UNITS[dimension][unit]
        plain = factor * value + offset
        if low <= plain <= high and (unit != "%" or value > 2.0):  # 1.2 is a fraction that is too large
            return f"{plain:.6g}, which is {value:g} {unit}"
    return None


def in_plain_units(text: str) -> float | None:
    """Return the value, in plain units, of text with any known unit; None for other text."""
    for dimension, units in UNITS.items():
        match = _QUANTITY.fullmatch(text)
        if match and match.group(2) in units:
            return float(str(parse_quantity(text, dimension)))
    return None


def _allowed(dimension: str) -> str:
    names = [name for name in UNITS[dimension] if name]
    plain = "a plain number" if "" in UNITS[dimension] else f"a number in {names[0]}"
    units = f"one of the units {', '.join(names)}" if len(names) > 1 else f"the unit {names[0]}"
    return f"allowed: {plain}, or text with {units}"


def _closest_unit(unit: str, dimension: str) -> str | None:
    names = [name for name in UNITS[dimension] if name]
    bare = unit.casefold().lstrip("°")
    # "C" and "°C" mean degC, though few of their letters agree.
    return Problem.closest(unit, names) or next((name for name in names if name.casefold().endswith(bare)), None)


def _refuse_bool(value: object, kind: str) -> None:
    if isinstance(value, bool):  # Python would treat it as 0 or 1
        raise PydanticCustomError(kind, "not a number")


def _plain(kind: str) -> Callable[[object], object]:
    def parse(value: object) -> object:
        _refuse_bool(value, kind)
        if isinstance(value, str):
            raise PydanticCustomError(kind, "text, not a number")
        return value

    return parse


@dataclass(frozen=True)
class QuantityOf:
    """Parser of quantities of one dimension, in whose annotations messages about limits read it.

    Attributes
    ----------
    dimension : str
        Of :data:`UNITS`.
    """

    dimension: str

    def __call__(self, value: object) -> object:
        """Return the value in plain units; raises PydanticCustomError."""
        _refuse_bool(value, "float_type")
        return parse_quantity(value, self.dimension)


class QuantityParser(QuantityOf):
    """Parser of quantities in plain units, such as metres, for ``BeforeValidator`` in a field's annotation.

    Attributes
    ----------
    dimension : str
        Of :data:`UNITS`: ``length`` (m), ``angle`` (deg), ``duration`` (s), ``length in an instrument`` (m) and others.
    Number, Whole
        Types of a number and of a whole number without unit: no text or boolean.
    Length, Kilometres, InstrumentLength, Area, Angle, PixelAngle, Temperature, TemperatureDifference
        Types of numbers that may be text with a unit; their values are in m, km, m, m2, deg, rad, K, K.
    Speed, Duration, Frequency, Fraction
        The same in m/s, s, Hz, 1.
    """

    Number = Annotated[float, BeforeValidator(_plain("float_type"))]
    Whole = Annotated[int, BeforeValidator(_plain("int_type"))]
    Length = Annotated[float, BeforeValidator(QuantityOf("length"))]
    Kilometres = Annotated[float, BeforeValidator(QuantityOf("length in km"))]
    InstrumentLength = Annotated[float, BeforeValidator(QuantityOf("length in an instrument"))]
    Area = Annotated[float, BeforeValidator(QuantityOf("area"))]
    Angle = Annotated[float, BeforeValidator(QuantityOf("angle"))]
    PixelAngle = Annotated[float, BeforeValidator(QuantityOf("angle of a pixel"))]
    Temperature = Annotated[float, BeforeValidator(QuantityOf("temperature"))]
    TemperatureDifference = Annotated[float, BeforeValidator(QuantityOf("temperature difference"))]
    Speed = Annotated[float, BeforeValidator(QuantityOf("speed"))]
    Duration = Annotated[float, BeforeValidator(QuantityOf("duration"))]
    Frequency = Annotated[float, BeforeValidator(QuantityOf("frequency"))]
    Fraction = Annotated[float, BeforeValidator(QuantityOf("fraction"))]

    @staticmethod
    def parse_accuracy(value: Any) -> float | str:
        """Validate an accuracy: a fraction of the radiance as a number, or kelvin as text, ``"0.1 K"``.

        Raises
        ------
        PydanticCustomError
            If it is not an accuracy, or out of range.
        """
        unit, number = "", value
        if isinstance(value, str):
            match = _ACCURACY_TEXT.fullmatch(value)
            if match is None:
                raise PydanticCustomError(
                    "not_an_accuracy", f"{Problem.shown(value)} is not an accuracy; {_ACCURACY_ALLOWED}"
                )
            number, unit = float(match.group(1)), match.group(2)
            if unit not in _ACCURACY_FACTORS:
                closest = "K" if any(map(str.isalpha, unit)) else "%"
                raise PydanticCustomError(
                    "not_an_accuracy",
                    f"{Problem.shown(value)}: {Problem.shown(unit)} is not a unit of accuracy; {_ACCURACY_ALLOWED}; "
                    f"closest is '{closest}'",
                )
        if isinstance(number, bool) or not isinstance(number, int | float):
            raise PydanticCustomError(
                "not_an_accuracy", f"{Problem.shown(value)} is not an accuracy; {_ACCURACY_ALLOWED}"
            )
        try:
            plain = float(number) * _ACCURACY_FACTORS[unit]
        except OverflowError:  # an integer too large for a float
            plain = float("inf") if number > 0 else -float("inf")
        kelvin = unit.endswith("K")
        least, most = (MIN_ACCURACY_K, MAX_ACCURACY_K) if kelvin else (MIN_ACCURACY, MAX_ACCURACY)
        if not least <= plain <= most:
            nearest = most if plain > most else least
            raise PydanticCustomError(
                "accuracy_range",
                f"{Problem.shown(value)} is out of range; allowed: {MIN_ACCURACY:g} to {MAX_ACCURACY:g} of the "
                f"radiance, or text from '{MIN_ACCURACY_K:g} K' to '{MAX_ACCURACY_K:g} K'; closest valid choice is "
                + (f"'{nearest:g} K'" if kelvin else f"{nearest:g}"),
            )
        return f"{plain:g} K" if kelvin else plain


def _gas_amount(value: object) -> object:
    _refuse_bool(value, "gas_amount")
    allowed = 'allowed: a factor above 0 to 100, or text with ppm, ppb or DU, for example "420 ppm"'
    if isinstance(value, str):
        match = _QUANTITY.fullmatch(value)
        if match is None or match.group(2) not in ("ppm", "ppb", "DU") or not float(match.group(1)) > 0.0:
            raise PydanticCustomError("gas_amount", f"{Problem.shown(value)} is not an amount of a gas; {allowed}")
        return f"{match.group(1)} {match.group(2)}"
    if not isinstance(value, int | float) or not 0.0 < value <= 100.0:
        raise PydanticCustomError("gas_amount", f"{Problem.shown(value)} is not an amount of a gas; {allowed}")
    return float(value)


GasAmount = Annotated[float | str, BeforeValidator(_gas_amount)]
"""A factor on the amount in the profile, or text with an amount."""

Pixels = Annotated[float, BeforeValidator(QuantityParser("image distance"))]
Electrons = Annotated[float, BeforeValidator(QuantityParser("electrons"))]
ElectronRate = Annotated[float, BeforeValidator(QuantityParser("electrons per time"))]
ParticleRadius = Annotated[float, BeforeValidator(QuantityParser("particle radius"))]
"""In um, as usual for particles."""

WaterContent = Annotated[float, BeforeValidator(QuantityParser("water content"))]
"""In g m-3, as in the literature on clouds."""


MIN_ACCURACY, MAX_ACCURACY = 1e-6, 0.1
MIN_ACCURACY_K, MAX_ACCURACY_K = 1e-3, 10.0

_ACCURACY_ALLOWED = (
    f"allowed: a number from {MIN_ACCURACY:g} to {MAX_ACCURACY:g}, or text with one of the units %, K, mK"
)
_ACCURACY_TEXT = re.compile(r"\s*(\+?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?)\s*(\S*)\s*")
_ACCURACY_FACTORS = {"": 1.0, "%": 0.01, "K": 1.0, "mK": 1e-3}


def kelvin_of(accuracy: float | str) -> float | None:
    """Return a validated accuracy in kelvin; None if it is a fraction of the radiance."""
    return float(accuracy.removesuffix(" K")) if isinstance(accuracy, str) else None


Accuracy = Annotated[
    float | str,
    BeforeValidator(QuantityParser.parse_accuracy),
    WithJsonSchema(
        {
            "anyOf": [
                {"type": "number", "minimum": MIN_ACCURACY, "maximum": MAX_ACCURACY},
                {"type": "string", "pattern": r"^\s*[+0-9.eE-]+\s*(%|K|mK)?\s*$"},
            ]
        }
    ),
]
"""A fraction of the radiance, or text with a unit: ``"0.1 %"`` becomes 0.001, ``"50 mK"`` becomes ``"0.05 K"``."""
