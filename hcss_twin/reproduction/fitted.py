"""Inputs that the paper does not state, fitted to its numbers: one file has them all, one command fits them."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import dataclass

from hcss_twin.catalog import catalog_root
from hcss_twin.errors import CatalogError, choose_from

COMMAND = "python -m hcss_twin.reproduction.fits --write"
"""What fits them anew and writes the file."""


@dataclass(frozen=True)
class FittedInput:
    """One input.

    Attributes
    ----------
    name : str
        Key in the file.
    value : float
    unit : str
        ``"1"`` for pure numbers.
    meaning : str
    how : str
        To which numbers it was fitted, and what was held.
    """

    name: str
    value: float
    unit: str
    meaning: str
    how: str

    @property
    def told(self) -> str:
        """One line for a report."""
        unit = "" if self.unit == "1" else f" {self.unit}"
        return f"{self.meaning}: {self.value:g}{unit}"


def fitted_inputs() -> dict[str, FittedInput]:
    """Return all of them by name (catalogs/paper/hcss-fitted-inputs.json)."""
    path = catalog_root() / "paper" / "hcss-fitted-inputs.json"
    entries = json.loads(path.read_text(encoding="utf-8"))["inputs"]
    return {name: FittedInput(name, **entry) for name, entry in entries.items()}


def fitted(name: str) -> float:
    """Return the value of one.

    Raises
    ------
    CatalogError
        If there is none of that name.
    """
    known = fitted_inputs()
    if name not in known:
        raise CatalogError(f"no fitted input '{name}'; {choose_from(name, known)}")
    return known[name].value


def told(names: Iterable[str]) -> tuple[str, ...]:
    """Return one line for each name, for a report."""
    known = fitted_inputs()
    return tuple(known[name].told for name in names)


def entry(line: str) -> dict[str, str | float | None]:
    """Return a line of a report as ``text``, and ``name``, ``value`` and ``unit`` where it is a fitted number."""
    for each in fitted_inputs().values():
        if each.told == line:
            return {"text": line, "name": each.name, "value": each.value, "unit": each.unit}
    return {"text": line, "name": None, "value": None, "unit": None}


def origin(names: Iterable[str]) -> str:
    """Return how inputs were fitted, for the notes of a report."""
    known = fitted_inputs()
    ways: dict[str, None] = dict.fromkeys(known[name].how for name in names)
    return f"Inputs fitted: {'; '.join(ways)}. To fit them again: {COMMAND.removesuffix(' --write')}"
