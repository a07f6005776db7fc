"""What all laws use: how they fail, and comparisons that tell the numbers."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any
from unittest import SkipTest

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.providers import Declaration

Law = Callable[..., None]
"""A law; its parameters are among ``provider``, ``make`` (maps inputs to a provider), ``inputs``, ``wavenumber_cm1``,
``cloud`` and tolerances, which have defaults."""


class LawBroken(AssertionError):
    """A provider breaks a law; the message tells the numbers."""


class Inapplicable(SkipTest):
    """A law does not apply to a provider; the message tells why. Test runners skip the law."""


def law_name(law: Law) -> str:
    """Return the law in a few words."""
    return law.__name__.replace("_", " ")


def meaning(law: Any) -> str:
    """Return the law in one sentence, the first of its docstring."""
    return " ".join((law.__doc__ or "").strip().partition("\n\n")[0].split())


def require(kept: Any, numbers: str) -> None:
    """Raise ``LawBroken`` with the numbers unless all elements of ``kept`` are true."""
    if not np.all(kept):
        raise LawBroken(numbers)


def near(what: str, got: Any, expected: Any, *, rtol: float = 0.0, atol: float = 0.0) -> None:
    """Raise ``LawBroken`` with the value that is farthest beyond the tolerances of the expected one, or not finite."""
    got, expected = np.broadcast_arrays(np.asarray(got, np.float64), np.asarray(expected, np.float64))
    beyond = np.abs(got - expected) - (atol + rtol * np.abs(expected))
    wrong = ~(beyond <= 0.0)
    if np.any(wrong):
        worst = int(np.argmax(np.where(np.isnan(beyond), np.inf, beyond)))
        allowed = " and ".join([*([f"{100 * rtol:g} %"] if rtol else []), *([f"{atol:g}"] if atol or not rtol else [])])
        value, other = float(got.ravel()[worst]), float(expected.ravel()[worst])
        raise LawBroken(
            f"{what} is {value:.6g}; expected {other:.6g} within {allowed} ({int(wrong.sum())} of {wrong.size} differ)"
        )


def at_most(what: str, got: Any, most: Any) -> None:
    """Raise ``LawBroken`` with the value that exceeds its limit most, or is not finite."""
    _within(what, got, most, 1.0)


def at_least(what: str, got: Any, least: Any) -> None:
    """Raise ``LawBroken`` with the value that is farthest below its limit, or not finite."""
    _within(what, got, least, -1.0)


def _within(what: str, got: Any, limit: Any, sign: float) -> None:
    got, limit = np.broadcast_arrays(np.asarray(got, np.float64), np.asarray(limit, np.float64))
    beyond = sign * (got - limit)
    wrong = ~(beyond <= 0.0)
    if np.any(wrong):
        worst = int(np.argmax(np.where(np.isnan(beyond), np.inf, beyond)))
        word, value, other = "most" if sign > 0 else "least", float(got.ravel()[worst]), float(limit.ravel()[worst])
        raise LawBroken(f"{what} is {value:.6g}; expected at {word} {other:.6g} ({int(wrong.sum())} of {wrong.size})")


def range_ends(declares: Declaration) -> Array:
    """Return the lowest and highest wavenumber that a provider declares.

    Raises
    ------
    Inapplicable
        If it declares no range.
    """
    low, high = getattr(declares, "valid", {}).get("wavenumber_cm1", (0.0, 0.0))
    if low <= 0.0 or not math.isfinite(high):
        raise Inapplicable("the provider declares no range of wavenumbers")
    grid = getattr(declares, "native_grid_cm1", None)
    if grid is None:
        return np.array([low, high])
    inside = grid[(grid >= low) & (grid <= high)]
    return np.array([inside[0], inside[-1]])
