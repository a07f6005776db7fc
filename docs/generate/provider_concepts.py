"""How much an author of a provider must know, counted in the snapshots of the provider API."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from hcss_twin import providers
from hcss_twin.providers.registry import Kind

PAGE = "development/provider-concepts.md"

_SNAPSHOTS = Path(__file__).parents[2] / "tests" / "data"

_INTRODUCTION = """# Concepts of a provider

{GENERATED}

What an author must know to write a provider of one kind: the required members of its Protocol, the fields of its
inputs, and the fields of its declaration, as listed in the [provider reference](../reference/provider-reference.md).
Optional members are not counted.

| kind | members | inputs | declaration | version {now} | version 1 |
|---|---|---|---|---|---|"""


def lines(generated: str) -> Iterator[str]:
    """Yield the page."""
    yield _INTRODUCTION.replace("{GENERATED}", generated).replace("{now}", str(providers.API_VERSION))
    for kind in Kind:
        members, inputs, declared = concepts(kind, providers.API_VERSION)
        before = concepts(kind, 1)
        then = sum(map(len, before)) if before[0] else "-"
        total = len(members) + len(inputs) + len(declared)
        yield f"| `{kind}` | {len(members)} | {len(inputs)} | {len(declared)} | {total} | {then} |"


def concepts(kind: Kind, version: int) -> tuple[list[str], list[str], list[str]]:
    """Return the names of required members, inputs and declared fields of a kind in a version of the API."""
    text = (_SNAPSHOTS / f"provider-api-{version}.txt").read_text(encoding="utf-8")
    members = re.findall(rf"(?m)^required member hcss_twin\.providers\.{kind.protocol}\.(\w+)", text)
    declares = re.search(rf"(?m)^required member hcss_twin\.providers\.{kind.protocol}\.declares: (\w+)$", text)
    plural, singular = f"{str(kind).capitalize()}Inputs", f"{str(kind).capitalize().removesuffix('s')}Inputs"
    return (
        members,
        _fields(plural, text) or _fields(singular, text),
        [] if declares is None else _fields(declares[1], text),
    )


def _fields(name: str, text: str) -> list[str]:
    return re.findall(rf"(?m)^field hcss_twin\.providers\.{name} \d+\. (\w+)", text)
