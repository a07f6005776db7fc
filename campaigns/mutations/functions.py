"""The functions of the package, wherever they are: by qualified name, with their lines."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

PACKAGE = "hcss_twin"


@dataclass(frozen=True)
class Function:
    """A function or method: ``name`` is qualified within its file, ``file`` relative to the repository."""

    name: str
    file: str
    node: ast.FunctionDef
    lines: tuple[str, ...]
    compiled: bool
    """Whether numba compiles it."""


def functions(root: Path) -> list[Function]:
    """All functions of the package below ``root``."""
    texts = {path: path.read_text(encoding="utf-8") for path in sorted((root / PACKAGE).rglob("*.py"))}
    # Decorators: those of core/kernels.py, and names that stand for them with options.
    named = (re.findall(r"^(\w+) = (?:kernel|inner)\(", text, re.M) for text in texts.values())
    compilers = {"kernel", "inner", *(name for names in named for name in names)}
    found = []
    for path, text in texts.items():
        file, lines = path.relative_to(root).as_posix(), tuple(text.splitlines())
        for name, node in _nested(ast.parse(text), ""):
            compiled = any(ast.unparse(each).partition("(")[0] in compilers for each in node.decorator_list)
            found.append(Function(name, file, node, lines, compiled))
    return found


def _nested(node: ast.AST, prefix: str) -> Iterator[tuple[str, ast.FunctionDef]]:
    for each in ast.iter_child_nodes(node):
        if isinstance(each, ast.FunctionDef | ast.ClassDef):
            if isinstance(each, ast.FunctionDef):
                yield prefix + each.name, each
            yield from _nested(each, f"{prefix}{each.name}.")
        else:
            yield from _nested(each, prefix)
