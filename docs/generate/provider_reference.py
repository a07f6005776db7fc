"""Reference of the provider contract, from the docstrings of ``hcss_twin.providers``."""

from __future__ import annotations

import ast
import inspect
import re
from collections.abc import Collection, Iterator
from importlib import import_module
from types import ModuleType

from hcss_twin import providers

PAGE = "reference/provider-reference.md"

_INTRODUCTION = """# Provider reference

{GENERATED}

This page documents all that a plugin can import from `hcss_twin.providers`, from the docstrings.
[Write a plugin](../how-to/write-a-plugin.md) explains how to use it, and [provider API](provider-api.md) what stays
stable. A provider must have all members of its Protocol; the members of Protocols called `...Options` are optional.
"""

_HELPERS = [name for name in providers.HOMES if not name.startswith("providers.")]
_HELPERS += ["providers.common", "providers.registry.specs"]


def lines(generated: str) -> Iterator[str]:
    """Yield the page."""
    yield _INTRODUCTION.replace("{GENERATED}", generated)
    yield _prose(inspect.cleandoc(providers.__doc__ or ""))
    for name in (name for name in providers.HOMES if name not in _HELPERS):
        part = import_module(f"hcss_twin.{name}")
        title, _, more = _prose(inspect.cleandoc(part.__doc__ or "")).partition("\n\n")
        yield "\n\n".join((f"\n## {title.rstrip('.')}", *([more] if more else [])))
        yield from _names(part, providers.HOMES[name])
    yield "\n## Hooks, errors, files and physics"
    for name in _HELPERS:
        yield from _names(import_module(f"hcss_twin.{name}"), providers.HOMES[name])


def _names(part: ModuleType, names: tuple[str, ...]) -> Iterator[str]:
    """Yield the documentation of public names of a module, in the order of their definitions."""
    body = ast.parse(inspect.getsource(part)).body
    for node, following in zip(body, [*body[1:], None], strict=True):
        if isinstance(node, ast.ClassDef) and node.name in names:
            yield from _class(node)
        elif isinstance(node, ast.FunctionDef) and node.name in names:
            yield f"\n### `{node.name}`\n"
            yield _docstring(node)
            yield f"\n```python\n{_member(node)}\n```"
        elif isinstance(node, ast.Assign | ast.AnnAssign):
            target = node.target if isinstance(node, ast.AnnAssign) else node.targets[0]
            if isinstance(target, ast.Name) and target.id in names:
                text = ast.literal_eval(following.value) if isinstance(following, ast.Expr) else ""
                yield f"\n### `{target.id}`\n"
                yield "\n\n".join((*([_prose(text)] if text else []), f"```python\n{_source(node)}\n```"))


def _class(node: ast.ClassDef) -> Iterator[str]:
    bases = [_source(base) for base in node.bases]
    yield f"\n### `{node.name}`{' (Protocol)' if 'Protocol' in bases else ''}\n"
    yield _docstring(node)
    told = _told(node)
    members = [line for each in node.body if (line := _member(each, told))]
    if members:
        yield "\n".join(("\n```python", *members, "```"))
    for each in node.body:
        if isinstance(each, ast.FunctionDef) and not each.name.startswith("_"):
            yield f"\n#### `{node.name}.{each.name}`\n"
            yield _docstring(each)


def _told(node: ast.ClassDef) -> set[str]:
    """Return the attributes without a default that the docstring lists with their type."""
    _, _, rest = (ast.get_docstring(node) or "").partition("Attributes\n----------\n")
    listed = re.findall(r"(?m)^(\w[\w, ]*) : ", rest.partition("\n\n")[0])
    return {name for names in listed for name in names.split(", ")}


def _member(node: ast.stmt, told: Collection[str] = ()) -> str:
    if isinstance(node, ast.AnnAssign):
        if node.value is None and isinstance(node.target, ast.Name) and node.target.id in told:
            return ""
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
