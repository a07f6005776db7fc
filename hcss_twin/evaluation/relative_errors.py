"""Eq 24 of the HCSS paper: errors relative to the simulated values, and their root mean square."""

from __future__ import annotations

import math
from collections.abc import Sequence


def relative_errors(real: Sequence[float], simulated: Sequence[float]) -> tuple[float, ...]:
    """Return the errors of eq 24, |real - simulated| / |simulated|, as fractions.

    Parameters
    ----------
    real, simulated : sequence of float
        The same measures of both images, none of the simulated ones 0. With the images exchanged, errors are
        relative to the real values.
    """
    return tuple(abs(one - other) / abs(other) for one, other in zip(real, simulated, strict=True))


def root_mean_square(errors: Sequence[float]) -> float:
    """Return the RMSE of eq 24, in the unit of the errors."""
    return math.sqrt(sum(error**2 for error in errors) / len(errors))
