"""Results of ``hcss check`` in the user's cache, for the cubes made with a provider."""

from __future__ import annotations

import json
from contextlib import suppress
from typing import Any

from hcss_twin.core.cache import Store, result_key
from hcss_twin.core.result_cache import ResultCache
from hcss_twin.providers.registry.discovery import Entry

CHECKS = ("checks", ".json")
"""Cache folder and file suffix."""


def keep_check(entry: Entry, parameters: Any, count: dict[str, int]) -> None:
    """Keep the number of laws of each outcome for this version and parameters of a provider and of this package."""
    Store(*CHECKS).keep(_key(entry, parameters, ResultCache()), lambda path: _write(path, count))


def kept_check(entry: Entry, parameters: Any, shelf: ResultCache) -> dict[str, int] | None:
    """Return the number of laws of each outcome of the last check; None if there was none."""
    path = Store(*CHECKS).find(_key(entry, parameters, shelf))
    if path is None:
        return None
    with suppress(OSError, ValueError):
        count: dict[str, int] = json.loads(path.read_text(encoding="utf-8"))
        return count
    return None


def _write(path: Any, count: dict[str, int]) -> None:
    path.write_text(json.dumps(count), encoding="utf-8")


def _key(entry: Entry, parameters: Any, shelf: ResultCache) -> str:
    return result_key({"check": [entry.kind, *entry.code(shelf), str(parameters)]}, shelf)
