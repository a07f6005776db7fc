"""How wrong a band radiance may be: a share of it, or kelvin of its brightness temperature."""

from __future__ import annotations

import re
from typing import Annotated, Any

from pydantic import BeforeValidator, WithJsonSchema
from pydantic_core import PydanticCustomError

from hcss_twin.core.errors import shown

MIN, MAX = 1e-6, 0.1
MIN_K, MAX_K = 1e-3, 10.0

_ALLOWED = f"allowed: a number from {MIN:g} to {MAX:g}, or text with one of the units %, K, mK"
_TEXT = re.compile(r"\s*(\+?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?)\s*(\S*)\s*")
_FACTORS = {"": 1.0, "%": 0.01, "K": 1.0, "mK": 1e-3}


def kelvin_of(accuracy: float | str) -> float | None:
    """Kelvin that a validated accuracy stands for; None for a share of the radiance."""
    return float(accuracy.removesuffix(" K")) if isinstance(accuracy, str) else None


def parse_accuracy(value: Any) -> float | str:
    """Read an accuracy: a share of the radiance as a number, or kelvin as text, ``"0.1 K"``.

    Raises
    ------
    PydanticCustomError
        If it is none, or out of range.
    """
    unit, number = "", value
    if isinstance(value, str):
        match = _TEXT.fullmatch(value)
        if match is None:
            raise PydanticCustomError("not_an_accuracy", f"{shown(value)} is not an accuracy; {_ALLOWED}")
        number, unit = float(match.group(1)), match.group(2)
        if unit not in _FACTORS:
            closest = "K" if any(map(str.isalpha, unit)) else "%"
            raise PydanticCustomError(
                "not_an_accuracy",
                f"{shown(value)}: {shown(unit)} is not a unit of accuracy; {_ALLOWED}; closest is '{closest}'",
            )
    if isinstance(number, bool) or not isinstance(number, int | float):
        raise PydanticCustomError("not_an_accuracy", f"{shown(value)} is not an accuracy; {_ALLOWED}")
    try:
        plain = float(number) * _FACTORS[unit]
    except OverflowError:  # a whole number beyond all others
        plain = float("inf") if number > 0 else -float("inf")
    kelvin = unit.endswith("K")
    least, most = (MIN_K, MAX_K) if kelvin else (MIN, MAX)
    if not least <= plain <= most:
        nearest = most if plain > most else least
        raise PydanticCustomError(
            "accuracy_range",
            f"{shown(value)} is out of range; allowed: {MIN:g} to {MAX:g} of the radiance, or text from "
            f"'{MIN_K:g} K' to '{MAX_K:g} K'; closest valid choice is "
            + (f"'{nearest:g} K'" if kelvin else f"{nearest:g}"),
        )
    return f"{plain:g} K" if kelvin else plain


Accuracy = Annotated[
    float | str,
    BeforeValidator(parse_accuracy),
    WithJsonSchema(
        {
            "anyOf": [
                {"type": "number", "minimum": MIN, "maximum": MAX},
                {"type": "string", "pattern": r"^\s*[+0-9.eE-]+\s*(%|K|mK)?\s*$"},
            ]
        }
    ),
]
"""A share of the radiance, or text with a unit: ``"0.1 %"`` becomes 0.001, ``"50 mK"`` becomes ``"0.05 K"``."""
