"""Inputs that the paper does not state, fitted to its numbers: one file has them all, one command fits them."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import dataclass

from hcss_twin.core.catalog import catalog_root
from hcss_twin.core.errors import CatalogError, choose_from
from hcss_twin.paper.item import TakenInput

COMMAND = "python -m hcss_twin.paper.fits --write"
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
    def taken(self) -> TakenInput:
        """What a reproduction says of it."""
        unit = "" if self.unit == "1" else f" {self.unit}"
        return TakenInput(f"{self.meaning}: {self.value:g}{unit}", self.name, self.value, self.unit)


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


def taken(names: Iterable[str]) -> tuple[TakenInput, ...]:
    """Return those of these names, for a reproduction."""
    known = fitted_inputs()
    return tuple(known[name].taken for name in names)


def origin(names: Iterable[str]) -> str:
    """Return how inputs were fitted, for the notes of a report."""
    known = fitted_inputs()
    ways: dict[str, None] = dict.fromkeys(known[name].how for name in names)
    return f"Inputs fitted: {'; '.join(ways)}. To fit them again: {COMMAND.removesuffix(' --write')}"
