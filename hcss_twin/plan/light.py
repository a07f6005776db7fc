"""Light between columns of cloud, as a plan has it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class PlannedLight:
    """Light transport of a scene: value of ``radiance.light``, package, class, and the error that it states.

    The error is that of each band, rms over pixels relative to the mean radiance; None: not stated.
    """

    name: str
    provider: str
    transport: Any
    expected_rms: dict[str, float] | None = None

    def as_dict(self) -> dict[str, Any]:
        """Plain values for plan and cube."""
        return {"name": self.name, "provider": self.provider, "expected_rms": self.expected_rms}
