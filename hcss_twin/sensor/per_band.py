"""Parameters that are one number for all bands, or a table of numbers by band."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from pydantic import BeforeValidator
from pydantic_core import PydanticCustomError

from hcss_twin.errors import Problem, ScenarioError, choose_from

PerBand = float | dict[str, float]


def within(low: float, high: float) -> BeforeValidator:
    """Return the check of a ``PerBand`` parameter whose numbers lie within ``low`` to ``high``, both allowed."""
    return BeforeValidator(_parser(low, high))


def _parser(low: float, high: float) -> Callable[[object], object]:
    allowed = f"allowed: a number from {low:g} to {high:g}, or a table of such numbers by band"

    def number(value: object, where: str) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise PydanticCustomError("per_band", f"{where}{value!r} is not a number; {allowed}")
        if not low <= value <= high:  # also refuses NaN
            nearest = "" if math.isnan(value) else f"; closest valid choice is {min(max(value, low), high):g}"
            raise PydanticCustomError("per_band", f"{where}{value:g} is out of range; {allowed}{nearest}")
        return float(value)

    def parse(value: object) -> object:
        if not isinstance(value, Mapping):
            return number(value, "")
        if not value or not all(isinstance(name, str) for name in value):
            raise PydanticCustomError("per_band", f"a table without names of bands; {allowed}")
        return {name: number(each, f"band '{name}': ") for name, each in value.items()}

    return parse


def of_band(value: PerBand, band: str, field: str) -> float:
    """Return the number of one band.

    Raises
    ------
    ScenarioError
        If the table does not have the band.
    """
    if not isinstance(value, Mapping):
        return value
    if band not in value:
        message = f"gives no number for band '{band}'; {choose_from(band, value)}"
        raise ScenarioError([Problem(f"sensor.parameters.{field}", message)])
    return value[band]
