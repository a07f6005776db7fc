"""Where a drawn mutation is in the present tree, which may have moved, merged or renamed what it is in.

A mutation that is no longer found by function and line gets an entry in relocated.json: its number, and what is new of
``function``, ``line``, ``mutated``, ``file`` or ``occurrence``. ``{"lost": "reason"}`` says that its code has gone.
``python place.py`` lists what is not found, each with the likeliest line as a ready entry.
"""

from __future__ import annotations

import difflib
import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from functions import Function, bare, functions

HERE = Path(__file__).parent
ROOT = HERE.parents[2]

LONG = 30
"""Letters of a line that is looked for whatever function it is in."""


@dataclass(frozen=True)
class Place:
    """The function and row of a mutation, or why there is none."""

    function: Function | None
    row: int = 0
    problem: str = ""


def mutations() -> list[dict[str, Any]]:
    """The drawn mutations, as they are called now."""
    drawn: list[dict[str, Any]] = json.loads((HERE / "mutations.json").read_text(encoding="utf-8"))
    moved = json.loads((HERE / "relocated.json").read_text(encoding="utf-8"))
    return [each | moved.get(str(each["id"]), {}) for each in drawn]


def find(mutation: dict[str, Any], tree: Sequence[Function]) -> Place:
    """Find the one place: the same qualified name, else the same name in another class, else the same line anywhere."""
    if "lost" in mutation:
        return Place(None, problem=f"lost: {mutation['lost']}")
    name = mutation["function"]
    last = name.rpartition(".")[2]
    for group in (
        [each for each in tree if each.name == name],
        [each for each in tree if each.node.name == last],
        tree if len(mutation["line"]) >= LONG else [],
    ):
        places = [
            Place(each, rows[mutation["occurrence"]])
            for each in group
            if len(rows := each.rows_of(mutation["line"])) > mutation["occurrence"]
        ]
        if len(places) > 1:
            places = [each for each in places if each.function and each.function.file == mutation["file"]]
            return places[0] if len(places) == 1 else Place(None, problem="ambiguous")
        if places:
            return places[0]
    return Place(None, problem="not found")


def mutated_text(mutation: dict[str, Any], place: Place) -> str:
    """The whole file with the mutation."""
    assert place.function is not None
    lines = list(place.function.lines)
    line = lines[place.row - 1]
    lines[place.row - 1] = line.replace(mutation["line"], mutation["mutated"], 1)
    return "\n".join(lines) + "\n"


def _likely(mutation: dict[str, Any], tree: Sequence[Function]) -> dict[str, str]:
    """The most similar line of functions of the same name (of any, if there is none), mutated alike if possible."""
    last = mutation["function"].rpartition(".")[2]
    group = [each for each in tree if each.node.name == last] or list(tree)
    lines = {bare(each.lines[row - 1]): each for each in group for row in each.rows}
    best = difflib.get_close_matches(mutation["line"], list(lines), n=1, cutoff=0.4)
    if not best:
        return {}
    old, new = mutation["line"], mutation["mutated"]
    start = _common(old, new)
    end = min(_common(old[::-1], new[::-1]), len(old) - start, len(new) - start)
    # The changed part, with a few letters around it that tell it from others.
    left, right = max(0, start - 6), max(0, end - 6)
    before, after = (text[left : len(text) - right] for text in (old, new))
    mutated = best[0].replace(before, after) if best[0].count(before) == 1 else "?"
    function = lines[best[0]]
    return {"function": function.name, "line": best[0], "mutated": mutated, "file": function.file}


def _common(a: str, b: str) -> int:
    """How many letters two texts begin with alike."""
    return next((n for n, (x, y) in enumerate(zip(a, b, strict=False)) if x != y), min(len(a), len(b)))


def main() -> None:
    tree = functions(ROOT)
    for each in mutations():
        place = find(each, tree)
        if place.problem:
            print(each["id"], place.problem, each["function"], "|", each["line"], "|", each["mutated"])
            if not place.problem.startswith("lost"):
                print("   ", json.dumps({str(each["id"]): _likely(each, tree)}))


if __name__ == "__main__":
    main()
