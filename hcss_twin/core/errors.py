"""Exceptions of the package and the wording they share.

How values are written in messages: as the user would type them, and never a screenful.
"""

from __future__ import annotations

import difflib
import json
from collections.abc import Iterable
from dataclasses import dataclass
from datetime import date, time


class HcssError(Exception):
    """Base of every error this package raises on purpose."""


class CatalogError(HcssError):
    """A named or given data file is missing or malformed."""


class ProviderError(HcssError):
    """A provider (plugin) is unknown, broken, or broke its contract."""


class CubeError(HcssError):
    """A cube file cannot be written or read."""


class SweepError(HcssError):
    """A sweep cannot be written where it should, or not by those who should compute it."""


class ImageError(HcssError):
    """An image cannot be judged: its shape, its type or its values do not allow it."""


class PosteriorError(HcssError):
    """A posterior cannot be sampled, written or read."""


class PropagationError(HcssError):
    """Uncertainty cannot be propagated as asked, or its file cannot be written or read."""


class OptionError(HcssError):
    """An argument or option is not allowed, whatever the files hold."""


class ProviderNameError(OptionError, ProviderError):
    """No provider has the name asked for."""


class ImageOptionError(OptionError, ImageError):
    """A choice of how to look at images is not allowed."""


class PosteriorOptionError(OptionError, PosteriorError):
    """A choice of how to fit is not allowed."""


class PropagationOptionError(OptionError, PropagationError):
    """A choice of how to propagate is not allowed."""


class CertificateWarning(UserWarning):
    """A cube misses the accuracy asked for; its certificate says by how much and where."""


@dataclass(frozen=True)
class Problem:
    """One thing that is wrong with a scenario.

    Attributes
    ----------
    field : str
        Dotted path of the key, for example ``view.zenith``.
    message : str
        What was given, what is allowed, and the closest valid choice.
    """

    field: str
    message: str

    def __str__(self) -> str:
        return f"{self.field}: {self.message}"


class ScenarioError(HcssError):
    """A scenario is not valid; carries every problem found, not only the first."""

    def __init__(self, problems: Iterable[Problem], origin: str = "scenario") -> None:
        self.problems = tuple(problems)
        self.origin = origin
        count = len(self.problems)
        noun = "problem" if count == 1 else "problems"
        lines = [f"{origin}: {count} {noun}", *(f"  {problem}" for problem in self.problems)]
        super().__init__("\n".join(lines))


def closest(name: str, choices: Iterable[str]) -> str | None:
    """Return the choice most like ``name``, or None where nothing is alike."""
    folded = {choice.casefold(): choice for choice in choices}
    found = difflib.get_close_matches(name.casefold(), folded, n=1, cutoff=0.5)
    return folded[found[0]] if found else None


def choose_from(name: str, choices: Iterable[str]) -> str:
    """Phrase the allowed choices and the one closest to ``name``."""
    known = sorted(choices)
    guess = closest(name, known)
    hint = f"; closest is '{guess}'" if guess else ""
    return f"allowed: {', '.join(known) if known else 'none'}{hint}"


LONGEST = 80


def shown(value: object) -> str:
    """Write a value as it stands in a scenario file, cut to 80 characters."""
    if isinstance(value, bool):
        text = str(value).lower()
    elif isinstance(value, date | time):
        text = value.isoformat()
    else:
        try:
            text = repr(value)
        except ValueError:  # integers beyond Python's limit for conversion to text
            text = "a number of thousands of digits"
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 3]}..."


def listed(value: object) -> str | None:
    """Write ``value`` as the only entry of a list; None for what cannot be an entry."""
    return json.dumps([value]) if isinstance(value, str) and len(value) < LONGEST else None


def ordinal(number: int) -> str:
    """Return ``1st``, ``2nd``, ``3rd``, ``4th``, ``11th``, ``21st`` and so on."""
    teens = number % 100 in (11, 12, 13)
    return f"{number}{'th' if teens else {1: 'st', 2: 'nd', 3: 'rd'}.get(number % 10, 'th')}"


def count(number: int, noun: str, plural: str) -> str:
    """Write a number of things: ``1 entry``, ``2 entries``."""
    return f"{number} {noun if number == 1 else plural}"
