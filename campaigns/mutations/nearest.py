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

UNRELATED = re.compile(
    r"report|figure|fit_|propagat|bench|wheel|browser|documentation|tutorial|reproduc|posterior|plugin_installed|"
    r"start_up|sweep|evaluat|cluster|matching|committed|peak_memory"
)
"""Names of test files that are left out of folders: they are about other packages, or take minutes."""

SCENES = 4
"""Whole scenes that each mutation is tried on that they reach, beside the nearest tests."""

FILES = 8
"""Test files, the nearest ones, that a mutation is tried on."""

TESTS = 200
"""Tests of them, at most."""

CASES = 3
"""Cases of one test that are tried before its others."""

Tests = dict[str, dict[str, Any]]


def reach(bench: Bench, mutated: Mapping[int, Function], paths: Sequence[str]) -> Tests:
    """Run the tests without a mutation, file by folder; what a work folder has of the same tree is taken from there."""
    watched = {str(bench.tree / file): names for file, names in _watched(mutated, bench.functions).items()}
    tests: Tests = {}
    for folder, files in _folders(bench.tree, paths).items():
        key = hashlib.sha256(f"{bench.fingerprint}{files}{json.dumps(watched)}".encode()).hexdigest()[:8]
        kept = bench.work / f"reach-{folder.replace('/', '-')}-{key}.json"
        found = _watch(bench, files, watched, kept)
        # On a busy machine a time limit of a test may have passed.
        failed = [name for name, each in found.items() if each["failed"]]
        again = _watch(bench, failed, watched, kept.with_suffix(".again.json")) if failed else {}
        tests |= found | again
    return tests


def _watch(bench: Bench, names: Sequence[str], watched: Mapping[str, object], kept: Path) -> Tests:
    if not kept.exists():
        print(f"{names[0]} ...: {len(names)} files or tests without a mutation", flush=True)
        bench.watch(names, watched, kept)
    tests: Tests = json.loads(kept.read_text(encoding="utf-8"))
    return tests


def nearest(tests: Tests, number: int, allowed: Collection[str], budget_s: float) -> list[str]:
    """Names of tests that take at most ``budget_s`` together, the nearest first, and then a few whole scenes."""
    files = {_file(name) for name, each in tests.items() if number in each["reached"]}
    cases: dict[str, int] = defaultdict(int)
    ranked = []
    for name, each in tests.items():
        if name in allowed and _file(name) in files:
            case = name.partition("[")[0]
            cases[case] += 1
            # A test may use what another one of its file has left in memory, without running the function again.
            direct = number in each["reached"]
            ranked.append((not direct, cases[case] > CASES, len(each["reached"]), each["seconds"], name))
    order = [each[-1] for each in sorted(ranked)]
    parts = [each for each in order if "/end_to_end/" not in each]
    near = list(dict.fromkeys(_file(each) for each in parts))[:FILES]
    scenes = [each for each in order if "/end_to_end/" in each and number in tests[each]["reached"]]
    # Particular ones, and ones that compute much.
    wide = sorted(scenes, key=lambda name: (-len(tests[name]["reached"]), tests[name]["seconds"]))
    scenes = list(dict.fromkeys(each for pair in zip(scenes, wide, strict=True) for each in pair))
    seconds = 0.0
    chosen: list[str] = []
    for names, most, budget in (
        ([each for each in parts if _file(each) in near], TESTS, 0.7 * budget_s if scenes else budget_s),
        (scenes, SCENES if parts else TESTS, budget_s),
    ):
        for name in names[:most]:
            if seconds + tests[name]["seconds"] <= budget:
                chosen.append(name)
                seconds += tests[name]["seconds"]
    return chosen


def _file(name: str) -> str:
    return name.partition("::")[0]


def _folders(tree: Path, paths: Sequence[str]) -> dict[str, list[str]]:
    named = {tree / path for path in paths if (tree / path).is_file()}
    found = {file for path in paths for file in (tree / path).rglob("test_*.py") if not UNRELATED.search(file.name)}
    folders: dict[str, list[str]] = defaultdict(list)
    for file in sorted(named | found):
        name = file.relative_to(tree)
        folders["/".join(name.parts[:2])].append(name.as_posix())
    return folders


def _watched(mutated: Mapping[int, Function], tree: Sequence[Function]) -> dict[str, dict[str, list[int]]]:
    """Numbers of mutations by file and function; of a compiled function, those that call it."""
    found: dict[str, dict[str, list[int]]] = defaultdict(lambda: defaultdict(list))
    for number, own in mutated.items():
        todo = [own]
        seen = set()
        while todo:
            function = todo.pop()
            seen.add((function.file, function.name))
            cached = "cache" in " ".join(ast.unparse(each) for each in function.node.decorator_list)
            if not function.compiled:
                found[function.file][function.name].append(number)
            if function.compiled or cached:
                todo += [each for each in tree if (each.file, each.name) not in seen and _calls(each, function)]
    return {file: dict(names) for file, names in found.items()}


def _calls(caller: Function, function: Function) -> bool:
    name = function.node.name
    near = caller.file == function.file or not name.startswith("_")
    return near and any(
        name in (getattr(node, "id", None), getattr(node, "attr", None)) for node in ast.walk(caller.node)
    )
