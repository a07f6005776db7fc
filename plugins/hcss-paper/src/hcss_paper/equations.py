"""The equations of the paper and of the engine as they are computed, with the functions that compute them."""

from __future__ import annotations

import inspect
import tomllib
from dataclasses import dataclass
from importlib import import_module
from typing import Any

from hcss_paper.inputs import DATA

TITLE = 'W. Sun et al., "Complex Cloud-Sea Background Simulation for Space-Based Infrared Payload Digital Twin"'


@dataclass(frozen=True)
class Equation:
    """An equation as it is computed.

    Attributes
    ----------
    name : str
        What it gives.
    formula : str
        LaTeX, on one line.
    functions : tuple of str
        Where it is computed, ``package.module.function`` or ``package.module.Class.method``, all below ``hcss_twin``.
    source : str
        Book, article or "eq N" of the paper.
    paper : int or None
        Its number in the HCSS paper.
    note : str
        Symbols, and in what the code differs from the source.
    """

    name: str
    formula: str
    functions: tuple[str, ...]
    source: str = ""
    paper: int | None = None
    note: str = ""


def find(dotted: str) -> Any:
    """The function, class or method of a dotted name below ``hcss_twin``.

    Raises
    ------
    LookupError
        If there is none.
    """
    words = dotted.split(".")
    for split in range(len(words), 0, -1):
        try:
            found: Any = import_module(".".join(("hcss_twin", *words[:split])))
        except ModuleNotFoundError:
            continue
        for word in words[split:]:
            if not hasattr(found, word):
                raise LookupError(f"{dotted}: there is no '{word}'")
            found = getattr(found, word)
        return found
    raise LookupError(f"{dotted}: no such module")


def summary(dotted: str) -> str:
    """First line of the docstring of what a dotted name stands for."""
    return (inspect.getdoc(find(dotted)) or "").splitlines()[0]


def equations() -> tuple[tuple[Equation, ...], dict[str, tuple[Equation, ...]]]:
    """Return the numbered equations of the paper, and those of the default models and the engine by part."""
    tables = tomllib.loads((DATA / "equations.toml").read_text(encoding="utf-8"))
    paper = tuple(_equation(table) for table in tables["paper"])
    engine: dict[str, list[Equation]] = {}
    for table in tables["engine"]:
        engine.setdefault(table.pop("part"), []).append(_equation(table))
    return paper, {part: tuple(entries) for part, entries in engine.items()}


def _equation(table: dict[str, Any]) -> Equation:
    return Equation(**{**table, "functions": tuple(table["functions"])})


PAPER, ENGINE = equations()
