"""For pytest: writes down which tests run which of the mutated functions, and for how long.

``run.py`` loads it with ``-p reach_plugin`` and names two files: HCSS_REACH_FUNCTIONS, of numbers of mutations by file
and function, and HCSS_REACH_FOUND, to be written. Functions say so themselves: when a module is loaded, a call is put
in front of their bodies. The files stay as they are, so that what numba keeps of them stays valid.
"""

from __future__ import annotations

import ast
import builtins
import json
import os
import time
from collections import defaultdict
from collections.abc import Generator
from importlib.machinery import SourceFileLoader
from pathlib import Path
from typing import Any

import pytest

FUNCTIONS: dict[str, dict[str, list[int]]] = json.loads(
    Path(os.environ["HCSS_REACH_FUNCTIONS"]).read_text(encoding="utf-8")
)
tests: dict[str, dict[str, Any]] = defaultdict(lambda: {"seconds": 0.0, "failed": "", "reached": []})
reached: set[int] = set()
_load = SourceFileLoader.get_code


def _get_code(self: SourceFileLoader, fullname: str) -> Any:
    names = FUNCTIONS.get(self.path)
    if names is None:
        return _load(self, fullname)
    tree = ast.parse(Path(self.path).read_text(encoding="utf-8"))
    _instrument(tree, "", names)
    return compile(ast.fix_missing_locations(tree), self.path, "exec")


def _instrument(node: ast.AST, prefix: str, names: dict[str, list[int]]) -> None:
    for each in ast.iter_child_nodes(node):
        inner = prefix
        if isinstance(each, ast.FunctionDef | ast.ClassDef):
            inner = f"{prefix}{each.name}."
            numbers = names.get(inner[:-1])
            if isinstance(each, ast.FunctionDef) and numbers:
                call = ast.parse(f"_hcss_reached({numbers})").body[0]
                place = int(ast.get_docstring(each) is not None)
                each.body.insert(place, ast.copy_location(call, each.body[0]))
        _instrument(each, inner, names)


builtins._hcss_reached = reached.update  # type: ignore[attr-defined]
SourceFileLoader.get_code = _get_code  # type: ignore[method-assign, assignment]


@pytest.hookimpl(wrapper=True)  # type: ignore[untyped-decorator, unused-ignore]
def pytest_runtest_protocol(item: pytest.Item) -> Generator[None, object, object]:
    """Note what one test reaches, its fixtures included."""
    reached.clear()
    start = time.perf_counter()
    result = yield
    tests[item.nodeid] |= {"seconds": round(time.perf_counter() - start, 3), "reached": sorted(reached)}
    return result


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """Note failures."""
    if report.failed:
        tests[report.nodeid]["failed"] = str(report.longreprtext)[-300:]


def pytest_sessionfinish() -> None:
    """Write all."""
    Path(os.environ["HCSS_REACH_FOUND"]).write_text(json.dumps(tests), encoding="utf-8")
