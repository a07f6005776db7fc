"""Numbers with their standard errors, as text."""

from __future__ import annotations

import math

MOST_DECIMALS = 8
"""Numbers that need more are written with an exponent."""


def with_error(value: float, error: float) -> str:
    """Return ``280.65 ± 0.11``: the error with two digits, the value with as many decimals.

    Without an error greater than 0 the value stands alone, with five digits; what is no number is ``-``.
    """
    if not math.isfinite(value):
        return "-"
    if not math.isfinite(error) or error <= 0.0:
        return plain(value)
    decimals = max(0, 1 - math.floor(math.log10(error)))
    if decimals > MOST_DECIMALS:
        # The last digit of the value stands where that of the error does.
        size = math.floor(math.log10(abs(value))) if value else 0
        digits = max(0, min(15, size - math.floor(math.log10(error)) + 1))
        return f"{value:.{digits}e} ± {error:.1e}"
    return f"{value:.{decimals}f} ± {error:.{decimals}f}"


def plain(value: float) -> str:
    """Return a number with five digits."""
    return f"{value:.5g}" if math.isfinite(value) else "-"


def share(value: float, error: float) -> str:
    """Return a share of a variance with its error."""
    if not math.isfinite(value):
        return "-"
    return f"{value:.2f} ± {error:.2f}" if math.isfinite(error) else f"{value:.2f}"
