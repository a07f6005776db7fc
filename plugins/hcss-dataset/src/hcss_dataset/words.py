"""What a key may be drawn from: the words of sweeps, distributions of scipy.stats, and weighted choices.

A table with ``distribution`` or ``choice``, and a list, describe a draw; all other values are those of a scenario. The
chosen value may hold further draws: ``{choice = [{type = "stratus", coverage = {distribution = ...}}]}``.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from hcss_sweep.axis import DIGITS, DISTRIBUTIONS, axis_of

from hcss_twin.providers import Problem, choose_from

DISTRIBUTION, CHOICE, WEIGHTS = "distribution", "choice", "weights"
_LARGEST_SEED = 2**63
_OF_SCIPY = ("from", "to", "unit", DISTRIBUTION)
FORMS = (
    "allowed: a list or {choice, weights} of equally or unequally likely values, {distribution = 'uniform', "
    "'log-uniform' or 'normal', ...} as in sweeps, {distribution = NAME, ...} of scipy.stats with its parameters and "
    "optionally from, to and unit, or one value"
)


def is_draw(given: Any) -> bool:
    """Whether a value describes what is drawn."""
    return isinstance(given, list | tuple) or (isinstance(given, Mapping) and bool({DISTRIBUTION, CHOICE} & set(given)))


def drawn(key: str, given: Any, random: np.random.Generator) -> Any:
    """Return a value, drawn if the given one describes a draw.

    Raises
    ------
    ValueError
        With the reason and what is allowed.
    """
    if isinstance(given, list | tuple):
        return drawn_inside(key, _chosen(given, None, random), random)
    if not isinstance(given, Mapping):
        return given
    if CHOICE in given:
        _only(given, (CHOICE, WEIGHTS))
        return drawn_inside(key, _chosen(given[CHOICE], given.get(WEIGHTS), random), random)
    if DISTRIBUTION in given:
        return _number(key, given, random)
    return drawn_inside(key, given, random)


def drawn_inside(key: str, value: Any, random: np.random.Generator) -> Any:
    """Return a table with the draws in it replaced by values; its lists are lists of a scenario."""
    if not isinstance(value, Mapping):
        return value
    if {DISTRIBUTION, CHOICE} & set(value):
        return drawn(key, value, random)
    return {name: drawn_inside(f"{key}.{name}", content, random) for name, content in value.items()}


def _chosen(values: Any, weights: Any, random: np.random.Generator) -> Any:
    if not isinstance(values, list | tuple) or not values:
        raise ValueError(f"choice = {Problem.shown(values)}; allowed: a list with at least one value")
    if weights is None:
        return values[int(random.integers(len(values)))]
    is_list = isinstance(weights, Sequence) and len(weights) == len(values)
    if not is_list or not all(_is_number(each) and each >= 0.0 for each in weights) or not sum(weights) > 0.0:
        raise ValueError(
            f"weights = {Problem.shown(weights)}; allowed: {len(values)} numbers from 0, not all of them 0"
        )
    share = np.cumsum(np.asarray(weights, dtype=np.float64)) / float(sum(weights))
    return values[int(np.searchsorted(share, random.random(), side="right"))]


def _number(key: str, given: Mapping[str, Any], random: np.random.Generator) -> Any:
    name = given[DISTRIBUTION]
    if name in DISTRIBUTIONS:
        # As a sweep with one sample, whose seed is drawn.
        seed = int(random.integers(_LARGEST_SEED))
        return axis_of(key, {**given, "samples": 1, "seed": seed}).values[0]
    from scipy import stats

    found = getattr(stats, name, None) if isinstance(name, str) else None
    is_whole = isinstance(found, stats.rv_discrete)
    if found is None or not (is_whole or isinstance(found, stats.rv_continuous)):
        names = (*DISTRIBUTIONS, *_names_of(stats))
        raise ValueError(f"distribution = {Problem.shown(name)}; {_closest(str(name), names)}")
    parameters = {word: value for word, value in given.items() if word not in _OF_SCIPY}
    shapes = [word.strip() for word in (found.shapes or "").split(",") if word.strip()]
    allowed = (*shapes, "loc") if is_whole else (*shapes, "loc", "scale")
    wrong = [word for word in parameters if word not in allowed] + [word for word in shapes if word not in parameters]
    if wrong:
        what = "unknown" if wrong[0] in parameters else "missing"
        listed = ", ".join((*allowed, "from", "to", "unit"))
        raise ValueError(f"the parameters of scipy.stats.{name}: '{wrong[0]}' is {what}; allowed: {listed}")
    low, high = (given.get(word, default) for word, default in (("from", -math.inf), ("to", math.inf)))
    for word, value in {**parameters, "from": low, "to": high}.items():
        if not _is_number(value):
            raise ValueError(f"{word} = {Problem.shown(value)}; allowed: a number; units are given by unit = 'km'")
    # Of whole numbers, the lower end belongs to the range.
    under = math.ceil(low) - 1 if is_whole and math.isfinite(low) else low
    below, above = _cumulative(found, tuple(parameters.items()), under, high)
    value = float(found.ppf(below + random.random() * (above - below), **parameters))
    if math.isnan(below) or math.isnan(above):
        shown = ", ".join(f"{word} = {Problem.shown(content)}" for word, content in parameters.items())
        raise ValueError(f"{shown or 'no parameters'}: scipy.stats.{name} has no such distribution")
    if not below < above:
        raise ValueError(f"from {low:g} to {high:g} contains no probability of scipy.stats.{name}")
    if not math.isfinite(value):
        raise ValueError(f"scipy.stats.{name} gave {value}; allowed: finite ends from and to")
    number: float | int = int(value) if is_whole else float(f"{value:.{DIGITS}g}")
    return f"{number} {given['unit']}" if "unit" in given else number


@lru_cache(maxsize=256)
def _cumulative(found: Any, parameters: tuple[tuple[str, float], ...], *at: float) -> tuple[float, ...]:
    """Return the distribution function of scipy.stats at numbers: kept, as it takes longer than a draw."""
    return tuple(float(found.cdf(each, **dict(parameters))) for each in at)


def _closest(name: str, names: Sequence[str]) -> str:
    guess = Problem.closest(name, names)
    known = f"allowed: {', '.join(map(repr, DISTRIBUTIONS))}, or the name of a distribution of scipy.stats"
    return f"{known}; closest is '{guess}'" if guess else known


def _names_of(stats: Any) -> Iterator[str]:
    kinds = stats.rv_continuous, stats.rv_discrete
    return (name for name, found in vars(stats).items() if isinstance(found, kinds))


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and not math.isnan(value)


def _only(given: Mapping[str, Any], allowed: tuple[str, ...]) -> None:
    for name in given:
        if name not in allowed:
            raise ValueError(f"unknown '{name}' in {Problem.shown(dict(given))}; {choose_from(str(name), allowed)}")
