"""``--set key=value``: replace single keys of a scenario."""

from __future__ import annotations

import copy
import tomllib
from collections.abc import Mapping
from typing import Any

from hcss_twin.errors import Problem


def parse_assignment(text: str) -> tuple[str, Any]:
    """Split ``key=value``; the value is TOML where it parses as such, text otherwise.

    Raises
    ------
    ValueError
        If there is no ``=`` or no key.
    """
    key, equals, value = text.partition("=")
    key = key.strip()
    if not equals or not key:
        raise ValueError(f"'{text}': allowed: key=value, for example view.zenith=40")
    try:
        return key, tomllib.loads(f"value = {value}")["value"]
    except tomllib.TOMLDecodeError:
        return key, value.strip()


def apply_overrides(
    raw: Mapping[str, Any], overrides: Mapping[str, Any]
) -> tuple[dict[str, Any], list[Problem]]:
    """Return a copy of ``raw`` with dotted keys replaced, and the keys that could not be placed.

    ``clouds.KEY`` reaches into the single cloud layer; a number selects a list element
    (``bands.0``).
    """
    data = copy.deepcopy(dict(raw))
    problems: list[Problem] = []
    for key, value in overrides.items():
        parts = key.split(".")
        if parts[0] == "clouds" and len(parts) > 1 and parts[1] != "layers":
            layers = data.setdefault("clouds", {}).setdefault("layers", [{}])
            if not isinstance(layers, list) or len(layers) != 1:
                problems.append(Problem(key, "needs exactly one cloud layer; name it as clouds.layers.0.KEY"))
                continue
            parts[1:1] = ["layers", "0"]
        if not _place(data, parts, value):
            problems.append(Problem(key, "leads into something that is not a table"))
    return data, problems


def _place(target: Any, parts: list[str], value: Any) -> bool:
    """Walk ``parts`` through tables and lists and set the last; say whether that was possible."""
    for part, following in zip(parts, [*parts[1:], None], strict=True):
        if isinstance(target, list):
            if not part.isdigit() or int(part) >= len(target):
                return False
            index: Any = int(part)
        elif isinstance(target, dict):
            index = part
        else:
            return False
        if following is None:
            target[index] = value
            return True
        target = target.setdefault(index, {}) if isinstance(target, dict) else target[index]
    return False
