"""``--set key=value``: replacement of single keys of a scenario."""

from __future__ import annotations

import copy
import tomllib
from collections.abc import Mapping
from typing import Any

from pydantic import BaseModel

from hcss_twin.core.errors import Problem
from hcss_twin.scenario.key_paths import model_at
from hcss_twin.scenario.models import ScenarioModel


def parse_assignment(text: str) -> tuple[str, Any]:
    """Split ``key=value``; the value is TOML if it parses as such, otherwise text.

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
        parsed = tomllib.loads(f"value = {value}")
    except (ValueError, RecursionError):
        return key, value.strip()
    return key, parsed["value"] if len(parsed) == 1 else value.strip()


def key_parts(key: str) -> list[str]:
    """Split a dotted key; ``clouds.KEY`` refers to the single layer."""
    parts = key.split(".")
    if parts[0] == "clouds" and len(parts) > 1 and parts[1] != "layers":
        parts[1:1] = ["layers", "0"]
    return parts


PROVIDER_KEYS = frozenset({"provider", "model", "generator"})


def apply_overrides(
    raw: Mapping[str, Any], overrides: Mapping[str, Any]
) -> tuple[dict[str, Any], list[Problem], list[str]]:
    """Return a copy of ``raw`` with dotted keys replaced, the keys that could not be set, and notes for the user.

    ``clouds.KEY`` refers to the single cloud layer; a number selects a list element (``bands.0``), of the default
    list if the scenario has none. Selecting another provider removes the ``parameters`` of the previous one, because
    few of them mean the same to the other; a note names them.
    """
    data = copy.deepcopy(dict(raw))
    problems, notes = list[Problem](), list[str]()
    for key, value in overrides.items():
        parts = key.split(".") if isinstance(key, str) else []
        if not all(parts) or not parts:
            example = "allowed: keys joined by dots, for example view.zenith"
            problems.append(Problem(Problem.shown(key), f"is not a key; {example}"))
            continue
        if parts[0] == "clouds" and len(parts) > 1 and parts[1] != "layers":
            why = _open_single_layer(data)
            if why:
                problems.append(Problem(key, why))
                continue
            parts[1:1] = ["layers", "0"]
        if parts[0] == "instrument" and len(parts) > 1 and isinstance(data.get("instrument"), str):
            data["instrument"] = {"name": data["instrument"]}
        dropped = _drop_parameters_of_replaced(data, parts, value)
        if dropped:
            notes.append(f"{key} = {Problem.shown(value)} removes the parameters of the one it replaces: {dropped}")
        why = _place(data, parts, copy.deepcopy(value))
        if why:
            problems.append(Problem(key, why))
    return data, problems, notes


def _drop_parameters_of_replaced(data: dict[str, Any], parts: list[str], value: Any) -> str:
    """Remove ``parameters`` of a section before its provider changes; return their names."""
    *path, key = parts
    section: Any = data
    for part in path:
        if isinstance(section, list) and _index(part, len(section)) is not None:
            section = section[int(part)]
        else:
            section = section.get(part) if isinstance(section, dict) else None
    if key not in PROVIDER_KEYS or not isinstance(section, dict):
        return ""
    owner = model_at(ScenarioModel, tuple(int(part) if _is_index(part) else part for part in path), key)
    field = None if owner is None else owner.model_fields.get(key)
    if value == section.get(key, None if field is None else field.default):
        return ""
    removed = section.pop("parameters", None)
    return ", ".join(map(str, removed)) if isinstance(removed, dict) else ""


def _open_single_layer(data: dict[str, Any]) -> str | None:
    """Ensure that there is one cloud layer; return the reason if that is impossible."""
    clouds = data.setdefault("clouds", {})
    if not isinstance(clouds, dict):
        return f"clouds is {Problem.shown(clouds)}, not a table"
    layers = clouds.setdefault("layers", [])
    if isinstance(layers, list) and not layers:
        layers.append({})
    if not isinstance(layers, list) or len(layers) != 1:
        return "needs exactly one cloud layer; name it as clouds.layers.0.KEY"
    return None


def _place(data: dict[str, Any], parts: list[str], value: Any) -> str | None:
    """Set the value at the path ``parts`` through tables and lists; return the reason if that is impossible."""
    target: Any = data
    for position, part in enumerate(parts):
        path = ".".join(parts[:position])
        index: Any = part
        if isinstance(target, list):
            index = _index(part, len(target))
            if index is None:
                last = len(target) - 1
                allowed = "none, the list is empty" if last < 0 else f"0 to {last}"
                return f"{path} has no element {part}; allowed: {allowed}"
        elif not isinstance(target, dict):
            return f"{path} is {Problem.shown(target)}, not a table"
        if position == len(parts) - 1:
            target[index] = value
        elif isinstance(target, dict) and index not in target:
            following = parts[position + 1]
            target[index] = _default_list(parts[: position + 1]) if _is_index(following) else {}
        target = target[index]
    return None


def _index(part: str, size: int) -> int | None:
    return int(part) if _is_index(part) and int(part) < size else None


def _is_index(part: str) -> bool:
    return part.isascii() and part.isdecimal() and len(part) < 10


def _default_list(path: list[str]) -> Any:
    """Default of a list that the scenario omits; an empty table if there is none."""
    model: type[BaseModel] = ScenarioModel
    for part in path:
        field = model.model_fields.get(part)
        if field is None:
            return {}
        if isinstance(field.annotation, type) and issubclass(field.annotation, BaseModel):
            model = field.annotation
        elif isinstance(field.default, tuple):
            return list(field.default)
    return {}
