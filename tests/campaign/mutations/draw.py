"""Draw the mutations, once: ``python draw.py`` writes mutations.json from a checkout of version 0.1.0.

They are kept by function and line, not by file, so that they are found again wherever the function goes. The draw goes
round the operators, so that rare ones (a dropped square root, swapped arguments) are tried as well as sums; at most
one mutation of a function.
"""

from __future__ import annotations

import ast
import json
import random
import re
from collections import Counter, defaultdict
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from functions import Function, bare, functions
from operators import edits

HERE = Path(__file__).parent
ROOT = HERE.parents[2]
SEED = 16
SHARES = {"physics": 25, "models": 45, "engine": 30}

OLD_PLACES = {
    "physics": r"physics/|viewing/|multiple_scattering/",
    "models": r"clouds/|sea/|optics/|atmosphere/|radiance/|sensor/|climatology\.py|refractive_index\.py",
    "engine": r"scene/(?!(plan|findings|probes|accuracy|budget)\.py|building/|ledger/|.*_choice\.py)",
}
"""Files of version 0.1.0 that become the three packages."""

LEAVING = re.compile(r"hcss_twin/(multiple_scattering/choice|scene/mean_wavelength|clouds/occupancy)\.py")
"""Code that only tests use: it leaves the package."""

TEXTS = re.compile(r"key|hash|digest|fingerprint|text|descri|message|label|repr|note|explain|said|provenance")
"""Names of functions that make texts or names of cache entries."""


def main() -> None:
    tree = functions(ROOT)
    signatures = _signatures(tree)
    lines = Counter((each.name, line) for each in tree for line in {bare(x) for x in each.lines})
    chosen = random.Random(SEED)
    drawn: list[dict[str, Any]] = []
    for package, share in SHARES.items():
        place = re.compile(f"hcss_twin/({OLD_PLACES[package]})")
        pools: dict[str, list[dict[str, Any]]] = defaultdict(list)
        for function in tree:
            if place.match(function.file) and not LEAVING.match(function.file) and not _makes_text(function):
                for each in _mutations(function, signatures):
                    if lines[function.name, each["line"]] == 1:
                        pools[each["operator"]].append({"package": package, **each})
        drawn += _round_robin(pools, share, chosen)
    for number, each in enumerate(drawn, 1):
        each["id"] = number
    (HERE / "mutations.json").write_text(json.dumps(drawn, indent=1) + "\n", encoding="utf-8")
    print(Counter((each["package"], each["operator"]) for each in drawn))


def _mutations(function: Function, signatures: dict[str, list[str]]) -> list[dict[str, Any]]:
    found = []
    for edit in edits(function.node, function.lines, signatures):
        line = function.lines[edit.row - 1]
        mutated = bare(line[: edit.start] + edit.text + line[edit.end :])
        found.append(
            {
                "function": function.name,
                "line": bare(line),
                "occurrence": function.rows_of(bare(line)).index(edit.row),
                "mutated": mutated,
                "operator": edit.operator,
                "file": function.file,
            }
        )
    return found


def _round_robin(pools: dict[str, list[dict[str, Any]]], count: int, chosen: random.Random) -> list[dict[str, Any]]:
    """Draw from each pool in turn until there are enough, no function twice."""
    names = sorted(pools)
    for name in names:
        chosen.shuffle(pools[name])
    drawn: dict[tuple[str, str], dict[str, Any]] = {}
    while len(drawn) < count and any(pools.values()):
        for name in names:
            while pools[name] and len(drawn) < count:
                each = pools[name].pop()
                where = (each["file"], each["function"])
                if where not in drawn:
                    drawn[where] = each
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


if __name__ == "__main__":
    main()
