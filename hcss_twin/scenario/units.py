"""Quantities in a scenario: a plain number in SI (degrees for angles), or text with a unit."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import Annotated

from pydantic import BeforeValidator
from pydantic_core import PydanticCustomError

from hcss_twin.errors import closest

# unit -> (factor, offset): SI value = factor * value + offset. The first unit is the plain number's.
UNITS: dict[str, dict[str, tuple[float, float]]] = {
    "length": {"m": (1.0, 0.0), "km": (1e3, 0.0), "cm": (1e-2, 0.0), "ft": (0.3048, 0.0)},
    "angle": {"deg": (1.0, 0.0), "rad": (180.0 / math.pi, 0.0)},
    "temperature": {"K": (1.0, 0.0), "degC": (1.0, 273.15)},
    "speed": {"m/s": (1.0, 0.0), "km/s": (1e3, 0.0), "km/h": (1 / 3.6, 0.0), "kn": (1852 / 3600, 0.0)},
    "duration": {"s": (1.0, 0.0), "ms": (1e-3, 0.0), "min": (60.0, 0.0), "h": (3600.0, 0.0)},
    "fraction": {"": (1.0, 0.0), "%": (0.01, 0.0)},
}

_QUANTITY = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(\S*)\s*")


def parse_quantity(value: object, dimension: str) -> object:
    """Turn ``"20 km"`` into 20000.0; pass anything that is not text on unchanged.

    Raises
    ------
    PydanticCustomError
        If the text is not a number with a unit of this dimension.
    """
    if not isinstance(value, str):
        return value
    units = UNITS[dimension]
    names = [name for name in units if name]
    match = _QUANTITY.fullmatch(value)
    allowed = f"allowed: a number in {names[0]}, or text with one of the units {', '.join(names)}"
    if match is None:
        raise PydanticCustomError("not_a_quantity", f"'{value}' is not a number with a unit; {allowed}")
    number, unit = match.groups()
    if unit not in units:
        if not unit:
            return float(number)
        guess = closest(unit, names)
        hint = f"; closest is '{guess}'" if guess else ""
        raise PydanticCustomError(
            "wrong_unit", f"'{value}': '{unit}' is not a unit of {dimension}; {allowed}{hint}"
        )
    factor, offset = units[unit]
    return factor * float(number) + offset


def _parser(dimension: str) -> Callable[[object], object]:
    def parse(value: object) -> object:
        if isinstance(value, bool):
            raise PydanticCustomError("not_a_number", f"{value} is not a number")
        return parse_quantity(value, dimension)

    return parse


Length = Annotated[float, BeforeValidator(_parser("length"))]
Angle = Annotated[float, BeforeValidator(_parser("angle"))]
Temperature = Annotated[float, BeforeValidator(_parser("temperature"))]
Speed = Annotated[float, BeforeValidator(_parser("speed"))]
Duration = Annotated[float, BeforeValidator(_parser("duration"))]
Fraction = Annotated[float, BeforeValidator(_parser("fraction"))]
