"""Table of the equations of the paper and of the engine, with the functions that compute them."""

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
    """An equation in the form in which it is computed.

    Attributes
    ----------
    name : str
        Quantity or law.
    formula : str
        LaTeX, on one line.
    functions : tuple of str
        Functions that compute it, ``package.module.function`` or ``package.module.Class.method``; a name that does not
        begin with another package, such as ``hcss_evaluate``, is in ``hcss_twin``.
    source : str
        Book, article or "eq N" of the paper.
    paper : int or None
        Number in the HCSS paper.
    note : str
        Symbols, and differences between code and source.
    """

    name: str
    formula: str
    functions: tuple[str, ...]
    source: str = ""
    paper: int | None = None
    note: str = ""


def qualified(dotted: str) -> str:
    """Return the dotted name of a function with its package."""
    return dotted if dotted.startswith("hcss_") else f"hcss_twin.{dotted}"


def find(dotted: str) -> Any:
    """Return the function, class or method with a dotted name.

    Raises
    ------
    LookupError
        If there is no such object.
    """
    words = qualified(dotted).split(".")
    for split in range(len(words), 1, -1):
        try:
            found: Any = import_module(".".join(words[:split]))
        except ModuleNotFoundError:
            continue
        for word in words[split:]:
            if not hasattr(found, word):
                raise LookupError(f"{dotted}: there is no '{word}'")
            found = getattr(found, word)
        return found
    raise LookupError(f"{dotted}: no such module")


def summary(dotted: str) -> str:
    """Return the first line of the docstring of the object with a dotted name."""
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
