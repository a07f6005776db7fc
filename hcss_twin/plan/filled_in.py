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
    unmeasured : str
        Name of a cloud layer whose altitude it is, if nobody has measured what that makes the radiance err.
    """

    field: str
    value: str
    why: str
    errors: tuple[ModelError, ...] = ()
    unmeasured: str = ""

    def as_dict(self) -> dict[str, str]:
        """Return field, value and why, as JSON values; the rest is part of the budget."""
        return {"field": self.field, "value": self.value, "why": self.why}
