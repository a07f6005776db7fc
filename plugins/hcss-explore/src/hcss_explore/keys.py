"""Keys of a scenario that is not validated yet: reading, changing, and writing them as TOML."""

from __future__ import annotations

import copy
import datetime
import json
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from hcss_twin.providers import HcssError

Raw = dict[str, Any]
"""Nested tables of keys, as TOML gives them."""

_PART = re.compile(r"([A-Za-z0-9_-]+)((?:\[[0-9]{1,4}\])*)")
_BARE = re.compile(r"[A-Za-z0-9_-]+")


class KeyPathError(HcssError):
    """A key cannot be set in these tables."""


def value_of(raw: Mapping[str, Any], key: str) -> Any:
    """Return the value of a dotted key such as ``clouds.layers[0].coverage``; None if it is not given."""
    found: Any = raw
    for step in _steps(key):
        try:
            found = found[step]
        except (KeyError, IndexError, TypeError):
            return None
    return found


def with_changes(raw: Mapping[str, Any], changes: Mapping[str, Any]) -> Raw:
    """Return a copy of the tables with other values; None removes a key, and tables that this empties.

    Raises
    ------
    KeyPathError
        If a key does not lead into tables.
    """
    result = copy.deepcopy(dict(raw))
    for key, value in changes.items():
        if value is None:
            _remove(result, list(_steps(key)))
        else:
            _assign(result, list(_steps(key)), key, value)
    return result


def as_toml(raw: Mapping[str, Any]) -> str:
    """Return tables as the text of a TOML file: plain keys first, then a section for each table."""
    plain = {key: value for key, value in raw.items() if not isinstance(value, Mapping)}
    lines = [f"{_key(key)} = {_value(value)}" for key, value in plain.items()]
    for name, table in raw.items():
        if isinstance(table, Mapping):
            lines += ["", f"[{_key(name)}]", *(f"{_key(key)} = {_value(value)}" for key, value in table.items())]
    return "\n".join(lines) + "\n"


def with_absolute_paths(value: Any, base: Path) -> Any:
    """Return tables in which names of files in ``base`` are absolute, so that the scenario can be read from elsewhere.

    A text counts as one if it has a suffix and such a file exists.
    """
    if isinstance(value, Mapping):
        return {key: with_absolute_paths(item, base) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [with_absolute_paths(item, base) for item in value]
    if isinstance(value, str) and 0 < len(value) < 1000 and "\0" not in value and Path(value).suffix:
        path = base / value
        return str(path.resolve()) if path.is_file() else value
    return value


def _steps(key: str) -> Iterator[str | int]:
    for part in key.split("."):
        match = _PART.fullmatch(part)
        if match is None:
            raise KeyPathError(f"'{key[:80]}' is not a key; allowed: such as view.zenith or clouds.layers[0].coverage")
        yield match[1]
        yield from (int(number) for number in re.findall(r"[0-9]+", match[2]))


def _assign(raw: Any, steps: list[str | int], key: str, value: Any) -> None:
    for step in steps[:-1]:
        is_key = isinstance(raw, dict) and isinstance(step, str)
        raw = raw.setdefault(step, {}) if is_key else _item(raw, step, key)
    if isinstance(raw, dict) and isinstance(steps[-1], str):
        raw[steps[-1]] = value
    else:
        _item(raw, steps[-1], key)
        raw[steps[-1]] = value


def _item(raw: Any, step: str | int, key: str) -> Any:
    if isinstance(raw, list) and isinstance(step, int) and step < len(raw):
        return raw[step]
    raise KeyPathError(f"{key}: there is no table or list entry '{step}' to set it in")


def _remove(raw: Any, steps: list[str | int]) -> None:
    try:
        if len(steps) > 1:
            inner = raw[steps[0]]
            _remove(inner, steps[1:])
            if inner == {} and isinstance(raw, dict):
                del raw[steps[0]]
        else:
            del raw[steps[0]]
    except (KeyError, IndexError, TypeError):
        return  # it is not there


def _key(key: str) -> str:
    return key if _BARE.fullmatch(key) else _value(key)


def _value(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        # JSON escapes as TOML does, apart from the character DEL
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, datetime.date | datetime.time):
        return value.isoformat()
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{_key(key)} = {_value(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list | tuple):
        if value and all(isinstance(item, Mapping) for item in value):
            return "[\n" + "".join(f"  {_value(item)},\n" for item in value) + "]"
        return "[" + ", ".join(map(_value, value)) + "]"
    return repr(value)
