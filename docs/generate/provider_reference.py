"""Reference of the provider contract, from the docstrings of ``hcss_twin.providers``: a line for each member."""

from __future__ import annotations

import ast
import inspect
import re
from collections.abc import Iterator
from importlib import import_module
from types import ModuleType

from hcss_twin import providers

PAGE = "reference/provider-reference.md"

_INTRODUCTION = """# Provider reference

{GENERATED}

All that a plugin can import from `hcss_twin.providers`: the contract between providers and the engine, and what they
can build on. [Write a plugin](../how-to/write-a-plugin.md) explains how to use it, [provider API](provider-api.md) what
stays stable. Docstrings have the range of every attribute, and what follows without an optional member:

```sh
python -c "from hcss_twin import providers; help(providers.SeaModel)"
```

The first line lists attributes; those without a type are floats, `(N,)` is an array of floats. A provider has all
members of its Protocol; those of `...Options` are optional. Each `...Declaration` also has `notes` and `own_errors`.
"""

_HELPERS = [name for name in providers.HOMES if not name.startswith("providers.")]
_HELPERS += ["providers.common", "providers.registry.specs"]

_SENTENCE = re.compile(r"(?<=[^.\d][.])\s+(?=[A-Z\"`])|(?<=\d[.])\s+(?=[A-Z])")


def lines(generated: str) -> Iterator[str]:
    """Yield the page."""
    yield _INTRODUCTION.replace("{GENERATED}", generated)
    yield _prose(inspect.cleandoc(providers.__doc__ or "")).partition("\n\n")[2]
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
            yield f"\n### `{node.name}({', '.join(_arguments(node))})`\n\n{_first(ast.get_docstring(node) or '')}"
        elif isinstance(node, ast.Assign | ast.AnnAssign):
            target = node.target if isinstance(node, ast.AnnAssign) else node.targets[0]
            if isinstance(target, ast.Name) and target.id in names:
                text = ast.literal_eval(following.value) if isinstance(following, ast.Expr) else ""
                source = "" if node.value is None else f" (`{_source(node.value)}`)"
                yield f"\n### `{target.id}`\n\n{_first(text) or 'A type'}{source}"


def _class(node: ast.ClassDef) -> Iterator[str]:
    bases = [_source(base) for base in node.bases]
    text, _, listed = (ast.get_docstring(node) or "").partition("Attributes\n----------\n")
    about = _first(text)
    yield f"\n### `{node.name}`{' (Protocol)' if 'Protocol' in bases else ''}\n"
    if not _NAMED.match(about):
        yield f"{about}\n"
    fields = [each for each in node.body if isinstance(each, ast.AnnAssign) and isinstance(each.target, ast.Name)]
    by_name = {_source(each.target): each for each in fields}
    kinds = {
        name: kind
        for names, kind in re.findall(r"(?m)^(\w[\w, ]*) : (.*)$", listed.partition("\n\n")[0])
        for name in names.split(", ")
    }
    public = {name: each for name, each in by_name.items() if not name.startswith("_")}
    kinds |= {name: _source(each.annotation) for name, each in public.items() if name not in kinds}
    if kinds:
        shown = [f"`{name}`{_kind(kind, by_name.get(name))}" for name, kind in kinds.items()]
        yield f"{', '.join(shown)}."
        yield ""
    for each in node.body:
        if isinstance(each, ast.FunctionDef) and not each.name.startswith("_") and each.name not in kinds:
            is_property = any(_source(mark) == "property" for mark in each.decorator_list)
            call = each.name if is_property else f"{each.name}({', '.join(_arguments(each))})"
            yield f"* `{call}`: {_first(ast.get_docstring(each) or '').removeprefix('Return ')}"


_NAMED = re.compile(r"Optional members of a|What an? [\w ]+ declares, besides|Inputs of an? [\w ]+\.$")
"""Descriptions that say what the name says."""

_TYPES = (
    (r"tuple\[(\w+)(?:\[\w+\])?, \.\.\.\]|tuple of (\S+)", r"tuple[\1\2, ...]"),
    (r"mapping of (\S+) to (?:ndarray of )?(.*)", r"mapping[\1, \2]"),
    (r"(set|sequence|collection) of (.*)", r"\1[\2]"),
    (r"ndarray of int ", "int "),
    (r"ndarray ", ""),
    (r" or None$", " | None"),
    (r" of integers", " int"),
)
"""Types in docstrings, and how the page writes them."""


def _kind(kind: str, field: ast.AnnAssign | None) -> str:
    """Return in brackets the type, unless it is float, and the default if the field has one that can be written."""
    value = None if field is None else field.value
    default = "" if value is None or isinstance(value, ast.Call) else _source(value)
    for pattern, short in _TYPES:
        kind = re.sub(pattern, short, kind)
    shown = [] if kind == "float" else [_prose(kind)]
    shown += [f"`{default}`"] if default and default not in ("None", '""', "()") else []
    return f" ({' = '.join(shown)})" if shown else ""


def _arguments(node: ast.FunctionDef) -> list[str]:
    """Return the names of the arguments, with defaults."""
    for each in (*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs):
        each.annotation = None
    return [text for text in _source(node.args).split(", ") if text not in ("self", "cls", "/")]


def _source(node: ast.AST) -> str:
    """Return the source code in the style of this project, with double quotes."""
    return ast.unparse(node).replace("'", '"')


def _first(text: str) -> str:
    """Return the first sentence of a docstring or description."""
    return _prose(_SENTENCE.split(" ".join(text.split("\n\n")[0].split()))[0])


def _prose(text: str) -> str:
    """Convert reStructuredText markup to Markdown."""
    return re.sub(r":\w+:`~?([^`]*)`", r"`\1`", text).replace("``", "`")
