"""The public provider API as lines of text, to compare with the committed ones.

Every line stands for itself, so that a changed type, default, order or signature shows as a line that went and one
that came. ``python tests/contract/provider_api_text.py`` writes the snapshot; it refuses what the version promises not
to do.
"""

import dataclasses
import inspect
import sys
import typing
from pathlib import Path

import hcss_author
import numpy as np

from hcss_twin import providers
from hcss_twin.providers.registry import specs as hookspecs

SNAPSHOT = Path(__file__).parents[1] / "data" / f"provider-api-{providers.API_VERSION}.txt"

COMMAND = "python tests/contract/provider_api_text.py"

GIVEN = ("hcss_twin.providers.BrightnessInversion",)
"""Protocols of objects that plugins receive: these may have more members, because no plugin makes them."""


def api():
    """Return all lines, in the order of modules and names; fields and members in the order of their definition."""
    lines = []
    for name in providers.__all__:
        lines += described(f"hcss_twin.providers.{name}", getattr(providers, name))
    for kind in providers.Kind:
        lines.append(f"hook {kind.hook}{signature(getattr(hookspecs, kind.hook))} brings {kind.protocol} as '{kind}'")
    lines.append(f"hook hcss_commands{signature(hookspecs.hcss_commands)}")
    for name in hcss_author.__all__:
        lines += kit(f"hcss_author.{name}", getattr(hcss_author, name))
    return lines


def described(name, value):
    """Return the lines of one public name."""
    if inspect.isfunction(value):
        return [f"function {name}{signature(value)}"]
    if not isinstance(value, type):
        return constant(name, value)
    bases = ", ".join(base.__name__ for base in value.__bases__ if base is not object)
    lines = [f"class {name}({bases}){' frozen' if frozen(value) else ''}"]
    fields = dataclasses.fields(value) if dataclasses.is_dataclass(value) else ()
    lines += [f"field {name} {place}. {field_text(field)}" for place, field in enumerate(fields)]
    word = "member"
    if getattr(value, "_is_protocol", False):
        word = "option member" if name.endswith("Options") else "required member"
    annotations = inspect.get_annotations(value)
    for member in [each for each in annotations if each not in {field.name for field in fields}]:
        lines.append(f"{word} {name}.{member}: {annotation_text(annotations[member])}")
    for member, content in vars(value).items():
        text = member_text(content)
        if text is not None and is_public(member, content, made_by_dataclass=bool(fields)):
            lines.append(f"{word} {name}.{member}{text}")
    return lines


def is_public(member, content, made_by_dataclass):
    if member == "__init__":
        # typing puts one of its own into every Protocol
        return not made_by_dataclass and content.__module__ != "typing"
    return member in ("__call__", "__add__") or not member.startswith("_")


def constant(name, value):
    """Return a line for a constant, or one for each name it holds, so that names may come."""
    if isinstance(value, tuple):
        return [f"constant {name} holds {each!r}" for each in value]
    return [f"constant {name} = {plain(value)}"]


def kit(name, value):
    """Return the lines of one name of the conformance kit: of a contract what plugin authors set or override."""
    if not name.endswith("Contract"):
        return described(name, value) if not isinstance(value, type) else [f"class {name}{signature(value)}"]
    lines = [f"class {name}"]
    members = {name: each for base in reversed(value.__mro__[:-1]) for name, each in vars(base).items()}
    for member, content in members.items():
        if member.startswith(("_", "test_")):
            continue
        if type(content).__name__ == "FixtureFunctionDefinition" or hasattr(content, "_pytestfixturefunction"):
            lines.append(f"kit fixture {name}.{member}")
        elif inspect.isfunction(content):
            lines.append(f"kit method {name}.{member}{signature(content)}")
        else:
            lines.append(f"kit attribute {name}.{member} = {plain(content)}")
    return lines


def frozen(value):
    return dataclasses.is_dataclass(value) and value.__dataclass_params__.frozen


def field_text(field):
    default = ""
    if field.default is not dataclasses.MISSING:
        default = f" = {plain(field.default)}"
    elif field.default_factory is not dataclasses.MISSING:
        default = f" = {plain(field.default_factory())}"
    return f"{field.name}: {annotation_text(field.type)}{default}"


def member_text(content):
    if isinstance(content, property):
        return f" -> {annotation_text(content.fget.__annotations__['return'])} (property)"
    if isinstance(content, staticmethod):
        return f"{signature(content.__func__)} (static)"
    if isinstance(content, classmethod):
        return f"{signature(content.__func__)} (class)"
    return signature(content) if inspect.isfunction(content) else None


def signature(function):
    found = inspect.signature(function)
    parts, star = [], False
    for each in found.parameters.values():
        if each.kind is each.KEYWORD_ONLY and not star:
            parts.append("*")
            star = True
        prefix = {each.VAR_POSITIONAL: "*", each.VAR_KEYWORD: "**"}.get(each.kind, "")
        star = star or prefix == "*"
        text = prefix + each.name
        if each.annotation is not each.empty:
            text += f": {annotation_text(each.annotation)}"
        if each.default is not each.empty:
            text += f" = {plain(each.default)}"
        parts.append(text)
    back = "" if found.return_annotation is found.empty else f" -> {annotation_text(found.return_annotation)}"
    return f"({', '.join(parts)}){back}"


def annotation_text(annotation):
    if isinstance(annotation, str):
        return annotation
    return annotation.__name__ if isinstance(annotation, type) and not typing.get_args(annotation) else str(annotation)


def plain(value):
    """Return a value's text, the same in every run and with every release of numpy."""
    if isinstance(value, frozenset | set):
        return f"{{{', '.join(sorted(map(repr, value)))}}}" if value else f"{type(value).__name__}()"
    if value == providers.Array:
        return f"ndarray of {typing.get_args(typing.get_args(value)[1])[0].__name__}"
    if isinstance(value, np.ndarray):
        return f"array of {value.dtype} {value.tolist()}"
    if callable(value):
        return f"<{type(value).__name__}>"
    return repr(value)


def broken_promises(before, now):
    """Return why lines may not replace others within one version: none where they only add what may be left out.

    A class that is new may demand what it likes.
    """
    gone = [f"gone or changed: {line}" for line in before if line not in now]
    new = [line for line in now if line not in before]
    known = {line.split()[1].partition("(")[0] for line in before if line.startswith("class ")}
    added = [line for line in new if any(f" {name}." in line or f" {name} " in line for name in known)]
    demanded = [f"new, and demanded of everyone: {line}" for line in added if demands(line)]
    bare = [f"new field without a default: {line}" for line in added if line.startswith("field") and " = " not in line]
    return gone + demanded + bare


def demands(line):
    return line.startswith("required") and not any(f" {name}." in line for name in GIVEN)


def write(path=SNAPSHOT):
    """Write the snapshot.

    Raises
    ------
    SystemExit
        If it would break a promise of the version it is of.
    """
    lines = api()
    if path.exists():
        broken = broken_promises(path.read_text(encoding="utf-8").splitlines(), lines)
        if broken:
            raise SystemExit(
                "\n".join(broken) + f"\nnot written: version {providers.API_VERSION} promises that this stays "
                "(docs/reference/provider-api.md). Undo it, or raise API_VERSION in "
                "hcss_twin/providers/registry/specs.py and run this again: every version has a snapshot of its own."
            )
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    write()
    sys.stdout.write(f"{SNAPSHOT}\n")
