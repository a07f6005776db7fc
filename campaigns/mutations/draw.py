"""Draw mutations of the package: round the operators, so that rare ones (a dropped square root, swapped arguments) are
tried as well as sums; at most one mutation of a function, in the shares of the packages.
"""

from __future__ import annotations

import ast
import random
import re
from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from functions import Function
from operators import edits

SHARES = {"physics": 0.25, "models": 0.45, "engine": 0.3}

TEXTS = re.compile(r"key|hash|digest|fingerprint|text|descri|message|label|repr|note|explain|said|provenance")
"""Names of functions that make texts or names of cache entries."""


@dataclass(frozen=True)
class Mutation:
    """A line of a function (``row`` of its file, counted from 1), and what stands there in its place."""

    package: str
    function: Function
    row: int
    line: str
    operator: str

    @property
    def text(self) -> str:
        """The whole file with the mutation."""
        lines = list(self.function.lines)
        lines[self.row - 1] = self.line
        return "\n".join(lines) + "\n"


def draw(
    tree: Sequence[Function], number: int, seed: int, other: Sequence[Function] | None = None
) -> list[tuple[Mutation, Mutation]]:
    """Return about as many mutations as asked for; the same ones for the same trees, number and seed.

    Parameters
    ----------
    other : sequence of Function, optional
        Of another version of the package: only lines are mutated that it has, too.

    Returns
    -------
    list of tuple of Mutation
        In the tree, and the same one in the other version.
    """
    signatures = _signatures(tree)
    others: dict[str, list[Function]] = defaultdict(list)
    for function in other or ():
        others[function.name].append(function)
    chosen = random.Random(seed)
    drawn: list[tuple[Mutation, Mutation]] = []
    for package, share in SHARES.items():
        pools: dict[str, list[tuple[Mutation, Mutation]]] = defaultdict(list)
        for function in tree:
            if function.file.startswith(f"hcss_twin/{package}/") and not _makes_text(function):
                for edit in edits(function.node, function.lines, signatures):
                    line = function.lines[edit.row - 1]
                    mutated = line[: edit.start] + edit.text + line[edit.end :]
                    mutation = Mutation(package, function, edit.row, mutated, edit.operator)
                    again = mutation if other is None else _again(mutation, others)
                    if again is not None:
                        pools[edit.operator].append((mutation, again))
        drawn += _round_robin(pools, round(share * number), chosen)
    return drawn


def _again(mutation: Mutation, others: Mapping[str, Sequence[Function]]) -> Mutation | None:
    """The mutation of the same line of a function of this name in another version, if there is one such function."""
    places = _places(mutation.function, mutation.function.lines[mutation.row - 1])
    found = []
    for function in others.get(mutation.function.name, ()):
        rows = _places(function, mutation.function.lines[mutation.row - 1])
        if len(rows) == len(places):
            row = rows[places.index(mutation.row)]
            text = function.lines[row - 1]
            indented = text[: len(text) - len(text.lstrip())] + mutation.line.lstrip()
            found.append(replace(mutation, function=function, row=row, line=indented))
    return found[0] if len(found) == 1 else None


def _places(function: Function, line: str) -> list[int]:
    """Rows of a function that have the text of a line."""
    rows = range(function.node.lineno, (function.node.end_lineno or 0) + 1)
    return [row for row in rows if function.lines[row - 1].strip() == line.strip()]


def _round_robin(
    pools: dict[str, list[tuple[Mutation, Mutation]]], count: int, chosen: random.Random
) -> list[tuple[Mutation, Mutation]]:
    """Draw from each pool in turn until there are enough, no function twice."""
    names = sorted(pools)
    for name in names:
        chosen.shuffle(pools[name])
    drawn: dict[tuple[str, str], tuple[Mutation, Mutation]] = {}
    while len(drawn) < count and any(pools.values()):
        for name in names:
            while pools[name] and len(drawn) < count:
                pair = pools[name].pop()
                function = pair[0].function
                if drawn.setdefault((function.file, function.name), pair) is pair:
                    break
    return list(drawn.values())


def _makes_text(function: Function) -> bool:
    returns = ast.unparse(function.node.returns) if function.node.returns else ""
    return bool(TEXTS.search(function.name)) or "str" in returns


def _signatures(tree: Sequence[Function]) -> dict[str, list[str]]:
    """Annotations of the positional parameters of functions whose name is unique."""
    names = Counter(each.node.name for each in tree)
    numpy = {"arctan2": ["y", "y"], "atan2": ["y", "y"], "where": ["", "value", "value"]}
    return numpy | {
        each.node.name: [
            ast.unparse(argument.annotation) if argument.annotation else ""
            for argument in each.node.args.args
            if argument.arg != "self"
        ]
        for each in tree
        if names[each.node.name] == 1
    }
