"""Which tests to try a mutation on: those that run its function, the most particular ones first."""

from __future__ import annotations

import ast
import hashlib
import json
import re
from collections import defaultdict
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

from bench import Bench
from functions import Function
from place import Place

UNRELATED = re.compile(
    r"report|figure|fit_|propagat|bench|wheel|browser|documentation|tutorial|reproduc|posterior|plugin_installed|"
    r"start_up|sweep|evaluat|cluster|matching|committed|peak_memory|random_scenarios"
)
"""Names of test files that are left out: they are about other packages, or take minutes."""

SCENES = 4
"""Whole scenes that each mutation is tried on that they reach, beside the nearest tests."""

CASES = 3
"""Cases of one test that are tried before its others."""

Tests = dict[str, dict[str, Any]]


def reach(bench: Bench, places: Mapping[int, Place], paths: Sequence[str]) -> Tests:
    """Run the tests without a mutation, file by folder; what a work folder has of the same tree is taken from there."""
    watched = {str(bench.tree / file): names for file, names in _watched(places, bench.functions).items()}
    tests: Tests = {}
    for folder, files in _folders(bench.tree, paths).items():
        key = hashlib.sha256(f"{bench.fingerprint}{files}{json.dumps(watched)}".encode()).hexdigest()[:8]
        kept = bench.work / f"reach-{folder.replace('/', '-')}-{key}.json"
        if not kept.exists():
            print(f"{folder}: {len(files)} files without a mutation", flush=True)
            bench.watch(files, watched, kept)
        tests |= json.loads(kept.read_text(encoding="utf-8"))
    return tests


def nearest(tests: Tests, number: int, allowed: Collection[str], budget_s: float) -> list[str]:
    """Names of tests that take at most ``budget_s`` together, the nearest first."""
    files = {_file(name) for name, each in tests.items() if number in each["reached"]}
    cases: dict[str, int] = defaultdict(int)
    ranked = []
    for name, each in tests.items():
        if name in allowed and _file(name) in files:
            case = name.partition("[")[0]
            cases[case] += 1
            # A test may use what another one of its file has left in memory, without running the function again.
            direct = number in each["reached"]
            scene = "/end_to_end/" in name
            rank = (not direct, cases[case] > CASES, scene, len(each["reached"]), each["seconds"])
            ranked.append((rank, name))
    order = [name for _, name in sorted(ranked)]
    scenes = [each for each in order if "/end_to_end/" in each and number in tests[each]["reached"]][:SCENES]
    chosen, seconds = [], sum(tests[each]["seconds"] for each in scenes)
    for name in order:
        if name not in scenes and seconds + tests[name]["seconds"] <= budget_s:
            chosen.append(name)
            seconds += tests[name]["seconds"]
    return chosen + scenes


def _file(name: str) -> str:
    return name.partition("::")[0]


def _folders(tree: Path, paths: Sequence[str]) -> dict[str, list[str]]:
    files = sorted(
        {
            each
            for path in paths
            for each in [tree / path, *(tree / path).rglob("test_*.py")]
            if each.is_file()
        }
    )
    folders: dict[str, list[str]] = defaultdict(list)
    for each in files:
        if not UNRELATED.search(each.name) and "campaign" not in each.parts:
            name = each.relative_to(tree)
            folders["/".join(name.parts[:2])].append(name.as_posix())
    return folders


def _watched(places: Mapping[int, Place], tree: Sequence[Function]) -> dict[str, dict[str, list[int]]]:
    """Numbers of mutations by file and function; of a compiled function, those that call it."""
    found: dict[str, dict[str, list[int]]] = defaultdict(lambda: defaultdict(list))
    for number, where in places.items():
        todo = [where.function] if where.function else []
        seen = set()
        while todo:
            function = todo.pop()
            seen.add((function.file, function.name))
            cached = "cache" in " ".join(ast.unparse(each) for each in function.node.decorator_list)
            if not function.compiled:
                found[function.file][function.name].append(number)
            if function.compiled or cached:
                todo += [
                    each for each in tree if (each.file, each.name) not in seen and _calls(each, function)
                ]
    return {file: dict(names) for file, names in found.items()}


def _calls(caller: Function, function: Function) -> bool:
    name = function.node.name
    near = caller.file == function.file or not name.startswith("_")
    return near and any(
        name in (getattr(node, "id", None), getattr(node, "attr", None)) for node in ast.walk(caller.node)
    )
