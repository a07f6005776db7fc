"""Values that a scenario omits."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class FilledIn:
    """A default for a value that the scenario omits."""

    field: str
    value: str
    why: str
