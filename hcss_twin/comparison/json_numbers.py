"""Numbers for JSON, which has no NaN and no infinity."""

from __future__ import annotations

import math
from typing import Any

from numpy.typing import NDArray


def json_number(value: float) -> float | None:
    """Return a number, or None where it is not finite."""
    return float(value) if math.isfinite(value) else None


def json_list(values: NDArray[Any]) -> list[float | None]:
    """Return numbers, with None for those that are not finite."""
    return [json_number(float(value)) for value in values]
