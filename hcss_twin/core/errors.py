"""Exceptions of the package, and common wording for their messages."""

from __future__ import annotations

import difflib
import json
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from datetime import date, time

__all__ = ["CertificateWarning", "OptionError"]


class HcssError(Exception):
    """Base of all errors that this package raises deliberately.

    Attributes
    ----------
    provider : str
        Label of the provider that raised it, if any: no other provider is at fault.
    """

    provider: str = ""


class CatalogError(HcssError):
    """A catalog file or user file is missing or malformed."""


class ProviderError(HcssError):
    """A provider (plugin) is unknown, broken, or violates its contract."""


class ProviderDefect(ProviderError):
    """A provider failed by accident or broke its contract: no key of the scenario is at fault."""


class CubeError(HcssError):
    """A cube file cannot be written or read."""


class ImageError(HcssError):
    """An image cannot be evaluated because of its shape, type or values."""


class OptionError(HcssError):
    """An argument or option is not allowed."""


class ProviderNameError(OptionError, ProviderError):
    """No provider has this name."""


class CacheWarning(UserWarning):
    """A cache is not used because other users could have written to it."""


class CertificateWarning(UserWarning):
    """A cube misses the requested accuracy; its certificate says by how much and where."""


LONGEST = 80
"""Characters of a value in a message."""


@dataclass(frozen=True)
class Problem:
    """One problem of a scenario.

    Attributes
    ----------
    field : str
        Dotted path of the key, for example ``view.zenith``.
    message : str
        Given value, allowed values, and closest valid choice.
    """

    field: str
    message: str

    def __str__(self) -> str:
        return f"{self.field}: {self.message}"

    @staticmethod
    def shown(value: object) -> str:
        """Write a value as in a scenario file, cut to 80 characters."""
        if isinstance(value, bool):
            text = str(value).lower()
        elif isinstance(value, date | time):
            text = value.isoformat()
        else:
            try:
                text = repr(value)
            except ValueError:  # integer beyond Python's limit for conversion to text
                text = "a number of thousands of digits"
        return text if len(text) <= LONGEST else f"{text[: LONGEST - 3]}..."

    @staticmethod
    def closest(name: str, choices: Iterable[str]) -> str | None:
        """Return the choice that ``name`` probably misspells or abbreviates, or a synonym of it; None if there is none.

        Names are compared word by word, so that ``sensor_zenith`` is not taken for a misspelt ``solar_zenith``. Of
        choices that differ in their numbers alone, the one with the nearest numbers is closest: ``table-10`` to
        ``table-12``.
        """
        known = list(choices)
        best = max(known, key=lambda choice: _similarity(name, choice), default=None)
        if best is None or _similarity(name, best) <= 0.0:
            same = {other for names in SYNONYMS if name.casefold() in names for other in names}
            return next((choice for choice in known if choice.casefold() in same), None)
        alike = [choice for choice in known if _without_numbers(choice) == _without_numbers(best)]
        numbers = _numbers(name)
        if len(alike) == 1 or [each is None for each in numbers] != [each is None for each in _numbers(best)]:
            return best
        return min(alike, key=lambda choice: [abs(one - other) for one, other in _pairs(numbers, _numbers(choice))])


class ScenarioError(HcssError):
    """A scenario is invalid; lists every problem, not only the first."""

    def __init__(self, problems: Iterable[Problem], origin: str = "scenario") -> None:
        self.problems = tuple(problems)
        self.origin = origin
        count = len(self.problems)
        noun = "problem" if count == 1 else "problems"
        lines = [f"{origin}: {count} {noun}", *(f"  {problem}" for problem in self.problems)]
        super().__init__("\n".join(lines))


SPELLING_CUTOFF = 0.65
"""Minimum similarity (2 x equal letters / all letters) of two spellings of a word; zenith and azimuth have 0.62."""


SYNONYMS = frozenset({"normal", "gaussian", "gauss"}), frozenset({"uniform", "flat", "rectangular"})
"""Names of one thing that are spelt differently: distributions."""


def _numbers(name: str) -> list[int | None]:
    """Return each word that is a number; None for other words."""
    return [int(word) if word.isdecimal() else None for word in _words(name)]


def _without_numbers(name: str) -> list[str | None]:
    """Return each word that is no number; None for numbers."""
    return [None if word.isdecimal() else word for word in _words(name)]


def _pairs(some: Iterable[int | None], others: Iterable[int | None]) -> Iterator[tuple[int, int]]:
    for one, other in zip(some, others, strict=True):
        if one is not None and other is not None:
            yield one, other


def _similarity(name: str, choice: str) -> float:
    """Return the similarity of two names, 0 to 1; 0 if their words differ in meaning."""
    one, other = _words(name), _words(choice)
    whole = _ratio("".join(one), "".join(other))
    if len(one) == len(other):
        return whole if all(map(_is_spelling, one, other)) else 0.0
    if one and len(one) < len(other) and set(one) <= set(other):
        return 0.9 + 0.1 * whole  # swir is nearer to swir-2.7-3.0 than to mwir
    shorter, longer = sorted((one, other), key=len)
    contained = bool(shorter) and all(
        any(_is_spelling(word, longer_word) for longer_word in longer) for word in shorter
    )
    return whole if contained or whole > 0.8 else 0.0  # 0.8: only the separators between words are missing


def _words(name: str) -> list[str]:
    return [word for word in re.split(r"[\W_]+", name.casefold()) if word]


def _is_spelling(one: str, other: str) -> bool:
    """Whether a word is the other, misspelt or abbreviated; numbers may differ, as in lwir-10.3 and lwir-10.8."""
    if one.isdigit() and other.isdigit():
        return True
    shorter, longer = sorted((one, other), key=len)
    return _ratio(one, other) >= SPELLING_CUTOFF or (len(shorter) > 2 and longer.startswith(shorter))


def _ratio(one: str, other: str) -> float:
    return difflib.SequenceMatcher(None, one, other).ratio()


def choose_from(name: str, choices: Iterable[str]) -> str:
    """Return text with the allowed choices and the one closest to ``name``."""
    known = sorted(choices)
    guess = Problem.closest(name, known)
    hint = f"; closest is '{guess}'" if guess else ""
    return f"allowed: {', '.join(known) if known else 'none'}{hint}"


def listed(value: object) -> str | None:
    """Write ``value`` as the only entry of a list; None if it cannot be an entry."""
    return json.dumps([value]) if isinstance(value, str) and len(value) < LONGEST else None
