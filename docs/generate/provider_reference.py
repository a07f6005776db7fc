"""Reference of the provider contract, from the docstrings of ``hcss_twin.providers``."""

from __future__ import annotations

import ast
import inspect
import re
from collections.abc import Iterator
from types import ModuleType

from hcss_twin import providers
from hcss_twin.providers import (
    atmosphere,
    clouds,
    declarations,
    elements,
    optics,
    radiance,
    sea,
    sensor,
    surfaces,
    variables,
)

PAGE = "reference/provider-reference.md"

_INTRODUCTION = """# Provider reference

{GENERATED}

This page documents the provider interface, from the docstrings of `hcss_twin.providers`.
[Write a plugin](../how-to/write-a-plugin.md) explains how to use it, and [provider API](provider-api.md) what stays
stable. A provider must have all members of its Protocol; the members of Protocols called `...Options` are optional.
"""

_PARTS = (declarations, clouds, sea, optics, atmosphere, radiance, elements, surfaces, variables, sensor)


def lines(generated: str) -> Iterator[str]:
    """Yield the page."""
    yield _INTRODUCTION.replace("{GENERATED}", generated)
    yield _prose(inspect.cleandoc(providers.__doc__ or ""))
    for part in _PARTS:
        title, _, more = _prose(inspect.cleandoc(part.__doc__ or "")).partition("\n\n")
        yield "\n\n".join((f"\n## {title.rstrip('.')}", *([more] if more else [])))
        for node in ast.parse(inspect.getsource(part)).body:
            if isinstance(node, ast.ClassDef) and node.name in providers.__all__:
                yield from _class(part, node)


def _class(part: ModuleType, node: ast.ClassDef) -> Iterator[str]:
    bases = [_source(base) for base in node.bases]
    yield f"\n### `{node.name}`{' (Protocol)' if 'Protocol' in bases else ''}\n"
    yield _docstring(node)
    members = [line for each in node.body if (line := _member(each))]
    if members:
        yield "\n".join(("\n```python", *members, "```"))
    for each in node.body:
        if isinstance(each, ast.FunctionDef) and not each.name.startswith("_"):
            yield f"\n#### `{node.name}.{each.name}`\n"
            yield _docstring(each)


def _member(node: ast.stmt) -> str:
    if isinstance(node, ast.AnnAssign):
        if isinstance(node.value, ast.Call):  # the names that metadata allows are in the docstring
            node.value.keywords = [each for each in node.value.keywords if each.arg != "metadata"]
        return _source(node)
    if not isinstance(node, ast.FunctionDef) or node.name.startswith("_"):
        return ""
    decorators = "".join(f"@{_source(each)}\n" for each in node.decorator_list)
    returns = "" if node.returns is None else f" -> {_source(node.returns)}"
    return f"{decorators}def {node.name}({_source(node.args)}){returns}"


def _docstring(node: ast.ClassDef | ast.FunctionDef) -> str:
    """Convert a numpydoc docstring to Markdown; its sections become lists."""
    text = ast.get_docstring(node) or ""
    head, *sections = re.split(r"(?m)^(\w+)\n-{3,}\n", text)
    parts = [_prose(head.strip())]
    for title, body in zip(sections[::2], sections[1::2], strict=True):
        parts.append(f"{title}:\n\n{_items(body)}")
    return "\n\n".join(parts)


def _items(body: str) -> str:
    """Convert the items of a section, each a line followed by an indented description."""
    found: list[str] = []
    for each in re.split(r"(?m)\n(?=\S)", body.strip("\n")):
        first, *rest = each.splitlines()
        name, _, kind = first.partition(" : ")
        named = ", ".join(f"`{word}`" for word in name.split(", "))
        told = " ".join(line.strip() for line in rest)
        found.append(f"* {named}" + (f" ({_prose(kind)})" if kind else "") + (f": {_prose(told)}" if told else ""))
    return "\n".join(found)


def _source(node: ast.AST) -> str:
    """Return the source code in the style of this project, with double quotes."""
    return ast.unparse(node).replace("'", '"')


def _prose(text: str) -> str:
    """Convert reStructuredText markup to Markdown."""
    return re.sub(r":\w+:`~?([^`]*)`", r"`\1`", text).replace("``", "`")
