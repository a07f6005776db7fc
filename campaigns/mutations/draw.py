"""Draw mutations of the package: round the operators, so that rare ones (a dropped square root, swapped arguments) are
tried as well as sums; at most one mutation of a function, in the shares of the packages.
"""

from __future__ import annotations

import ast
import random
import re
from collections import Counter, defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

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


def draw(tree: Sequence[Function], number: int, seed: int) -> list[Mutation]:
    """Return about as many mutations as asked for; the same ones for the same tree, number and seed."""
    signatures = _signatures(tree)
    chosen = random.Random(seed)
    drawn: list[Mutation] = []
    for package, share in SHARES.items():
        pools: dict[str, list[Mutation]] = defaultdict(list)
        for function in tree:
            if function.file.startswith(f"hcss_twin/{package}/") and not _makes_text(function):
                for edit in edits(function.node, function.lines, signatures):
                    line = function.lines[edit.row - 1]
                    mutated = line[: edit.start] + edit.text + line[edit.end :]
                    pools[edit.operator].append(Mutation(package, function, edit.row, mutated, edit.operator))
        drawn += _round_robin(pools, round(share * number), chosen)
    return drawn


def _round_robin(pools: dict[str, list[Mutation]], count: int, chosen: random.Random) -> list[Mutation]:
    """Draw from each pool in turn until there are enough, no function twice."""
    names = sorted(pools)
    for name in names:
        chosen.shuffle(pools[name])
    drawn: dict[tuple[str, str], Mutation] = {}
    while len(drawn) < count and any(pools.values()):
        for name in names:
            while pools[name] and len(drawn) < count:
                mutation = pools[name].pop()
                if drawn.setdefault((mutation.function.file, mutation.function.name), mutation) is mutation:
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
