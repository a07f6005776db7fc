"""One swept key and its values: a list, a range, a distribution or an ensemble of seeds."""

from __future__ import annotations

import hashlib
import math
import re
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.providers import Problem, choose_from

__all__ = ["DIGITS", "DISTRIBUTIONS", "axis_of"]

DIGITS = 12
"""Significant digits of computed values, so that 0.1 to 0.9 in steps of 0.2 contains 0.3, not 0.30000000000000004."""

_WITH_UNIT = re.compile(r"\s*([-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?)\s*(\S+)\s*")


@dataclass(frozen=True)
class Span:
    """Two or more given values as plain numbers; ``value`` converts a number to a scenario value.

    A scenario value is a number, text with a unit, or a date and time.
    """

    numbers: tuple[float, ...]
    value: Callable[[float], Any]
    is_time: bool = False


def span_of(*given: Any) -> Span:
    """Parse related values: all numbers, all with the same unit, or all dates and times with a zone.

    Raises ValueError with the reason if they are none of these.
    """
    instants = tuple(map(_read_instant, given))
    if all(isinstance(instant, datetime) for instant in instants):
        return _instants(instants)
    if all(isinstance(value, int | float) and not isinstance(value, bool) for value in given):
        whole = all(isinstance(value, int) for value in given)
        return Span(tuple(map(float, given)), lambda number: _plain(number, whole))
    matches = [_WITH_UNIT.fullmatch(value) if isinstance(value, str) else None for value in given]
    units = {match.group(2) for match in matches if match is not None}
    if None in matches or len(units) != 1:
        listed = ", ".join(map(Problem.shown, given))
        raise ValueError(
            f"{listed}: allowed: numbers, texts with one and the same unit, or dates and times with a zone"
        )
    (unit,) = units
    numbers = tuple(float(match.group(1)) for match in matches if match is not None)
    return Span(numbers, lambda number: f"{_plain(number, False):.{DIGITS}g} {unit}")


def _read_instant(value: Any) -> Any:
    """Parse ISO 8601 text (from JSON); return everything else unchanged."""
    if isinstance(value, str) and "T" in value:
        with suppress(ValueError):
            return datetime.fromisoformat(value)
    return value


def _plain(number: float, whole: bool) -> float | int:
    rounded = float(f"{number:.{DIGITS}g}")
    return int(rounded) if whole and rounded.is_integer() else rounded


def _instants(given: tuple[Any, ...]) -> Span:
    first: datetime = given[0]
    for moment in given:
        if moment.utcoffset() is None:
            closest = f"{moment.isoformat()}+00:00"
            raise ValueError(f"{moment.isoformat()} has no zone; closest valid choice is {closest}")

    def instant(number: float) -> datetime:
        return first + timedelta(seconds=round(number, 6))

    return Span(tuple((moment - first).total_seconds() for moment in given), instant, True)


MAX_VALUES = 100_000
"""Maximum number of values of one key."""

FORMS = (
    "a list of values, {from, to, steps} with scale = 'linear' or 'log', "
    "{distribution = 'uniform', 'log-uniform' or 'normal', ..., samples, seed}, {choice, samples, seed} for random "
    "values of a list, or {count, first} for seeds"
)

_RANGE = ("from", "to", "steps", "scale")
_ENSEMBLE = ("count", "first")
_CHOICE = ("choice", "samples", "seed")
_SCALES = ("linear", "log")
DISTRIBUTIONS = {
    "uniform": ("from", "to"),
    "log-uniform": ("from", "to"),
    "normal": ("mean", "standard_deviation", "from", "to"),
}
_OPTIONAL = ("scale", "first", "seed")


@dataclass(frozen=True)
class SweptAxis:
    """A scenario key and its values, as written in a scenario file."""

    key: str
    values: tuple[Any, ...]


def axis_of(key: str, given: Any) -> SweptAxis:
    """Parse the value of a key in ``[sweep]``.

    Raises ValueError with the reason, the allowed values and the closest choice.
    """
    if isinstance(given, list | tuple):
        values = tuple(given)
    elif isinstance(given, Mapping) and "distribution" in given:
        values = _drawn(key, given)
    elif isinstance(given, Mapping) and "choice" in given:
        _check_names(given, _CHOICE)
        listed = given["choice"]
        if not isinstance(listed, list | tuple) or not listed:
            raise ValueError(f"choice = {Problem.shown(listed)}; allowed: a list of at least one value")
        shares = _shares(key, given)
        values = tuple(listed[int(share * len(listed))] for share in shares)
    elif isinstance(given, Mapping) and "count" in given:
        _check_names(given, _ENSEMBLE)
        first = _whole(given, "first", 0, 2**63 - 1, 0)
        values = tuple(range(first, first + _whole(given, "count", 1, MAX_VALUES)))
    elif isinstance(given, Mapping):
        _check_names(given, _RANGE)
        values = _range(given)
    else:
        raise ValueError(f"{Problem.shown(given)} is not a set of values; allowed: {FORMS}")
    if not values:
        raise ValueError("the list is empty; allowed: at least one value")
    if len(values) > MAX_VALUES:
        raise ValueError(f"{len(values)} values; allowed: at most {MAX_VALUES}")
    return SweptAxis(key, values)


def _range(given: Mapping[str, Any]) -> tuple[Any, ...]:
    steps = _whole(given, "steps", 2, MAX_VALUES)
    scale = _chosen(given, "scale", _SCALES, "linear")
    span = span_of(given["from"], given["to"])
    low, high = span.numbers
    share = np.arange(steps) / (steps - 1)
    if scale == "log":
        _require_logarithms(span, "scale = 'log'")
        numbers = np.exp(math.log(low) + share * (math.log(high) - math.log(low)))
    else:
        numbers = low + share * (high - low)
    # The end values stay as given.
    inner = [span.value(float(number)) for number in numbers[1:-1]]
    return (given["from"], *inner, given["to"])


def _drawn(key: str, given: Mapping[str, Any]) -> tuple[Any, ...]:
    name = _chosen(given, "distribution", tuple(DISTRIBUTIONS))
    parameters = DISTRIBUTIONS[name]
    optional = ("from", "to") if name == "normal" else ()
    _check_names(given, ("distribution", *parameters, "samples", "seed"), optional)
    share = _shares(key, given)
    present = [parameter for parameter in parameters if parameter in given]
    span = span_of(*(given[parameter] for parameter in present))
    numbers = _quantiles(name, dict(zip(present, span.numbers, strict=True)), share, span)
    return tuple(span.value(float(number)) for number in numbers)


def _shares(key: str, given: Mapping[str, Any]) -> NDArray[np.float64]:
    """Return random numbers (``samples``,) from 0 to 1 of a key; axes with the same seed are not correlated."""
    samples = _whole(given, "samples", 1, MAX_VALUES)
    key_of_axis = int.from_bytes(hashlib.sha256(key.encode()).digest()[:8], "big")
    seed = np.random.SeedSequence(_whole(given, "seed", 0, 2**63 - 1, 0), spawn_key=(key_of_axis,))
    return np.random.default_rng(seed).random(samples)


def _quantiles(name: str, of: Mapping[str, float], share: NDArray[np.float64], span: Span) -> NDArray[np.float64]:
    """Quantiles (N,) of a distribution for probabilities (N,)."""
    low, high = of.get("from", -math.inf), of.get("to", math.inf)
    if not low < high:
        raise ValueError(f"from {low:g} to {high:g}: allowed: from < to")
    if name == "uniform":
        return low + share * (high - low)
    if name == "log-uniform":
        _require_logarithms(span, "distribution = 'log-uniform'")
        return np.asarray(np.exp(math.log(low) + share * (math.log(high) - math.log(low))))
    if span.is_time:
        raise ValueError("distribution = 'normal' of dates and times; allowed: 'uniform', or a list")
    from scipy.special import ndtr, ndtri

    mean, spread = of["mean"], of["standard_deviation"]
    if not 0.0 < spread < math.inf:
        raise ValueError(f"standard_deviation = {spread:g}; allowed: > 0")
    below, above = ndtr((low - mean) / spread), ndtr((high - mean) / spread)
    if not below < above:
        raise ValueError(f"from {low:g} to {high:g} contains no probability of the normal distribution around {mean:g}")
    drawn: NDArray[np.float64] = mean + spread * ndtri(below + share * (above - below))
    return drawn


def _require_logarithms(span: Span, what: str) -> None:
    if span.is_time or min(span.numbers) <= 0.0:
        raise ValueError(f"{what} needs numbers > 0 on both sides")


def _check_names(given: Mapping[str, Any], allowed: tuple[str, ...], optional: tuple[str, ...] = ()) -> None:
    for name in given:
        if name not in allowed:
            raise ValueError(f"unknown '{name}' in {Problem.shown(dict(given))}; {choose_from(str(name), allowed)}")
    missing = [name for name in allowed if name not in given and name not in (*_OPTIONAL, *optional)]
    if missing:
        raise ValueError(f"{Problem.shown(dict(given))} lacks {', '.join(missing)}; allowed: {FORMS}")


def _whole(given: Mapping[str, Any], name: str, low: int, high: int, default: int | None = None) -> int:
    value = given.get(name, default)
    if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
        raise ValueError(f"{name} = {Problem.shown(value)}; allowed: a whole number from {low} to {high}")
    return value


def _chosen(given: Mapping[str, Any], name: str, choices: tuple[str, ...], default: str | None = None) -> str:
    value = given.get(name, default)
    if value not in choices:
        raise ValueError(f"{name} = {Problem.shown(value)}; {choose_from(str(value), choices)}")
    return str(value)
