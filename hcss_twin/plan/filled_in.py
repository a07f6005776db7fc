"""Values that a scenario omits."""

from __future__ import annotations

from dataclasses import dataclass

from hcss_twin.providers import ModelError


@dataclass(frozen=True)
class FilledIn:
    """A default for a value that the scenario omits.

    Attributes
    ----------
    errors : tuple of ModelError
        What it makes the radiance err, where that was measured.
    """

    field: str
    value: str
    why: str
    errors: tuple[ModelError, ...] = ()
