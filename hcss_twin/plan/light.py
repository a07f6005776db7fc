"""Light between columns of cloud, as a plan has it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class PlannedLight:
    """Light transport of a scene: value of ``radiance.light``, package, class, and the error that it states.

    The error is that of each band, rms over pixels relative to the mean radiance.
    """

    name: str
    provider: str
    transport: Any
    expected_rms: Mapping[str, float] = field(default_factory=dict)

    def as_dict(self) -> dict[str, Any]:
        """Plain values for plan and cube."""
        return {"name": self.name, "provider": self.provider, "expected_rms": dict(self.expected_rms)}

    def check(self, *of_frame: Any) -> dict[str, Any]:
        """Return what the transport finds about a plan, its tables and a frame for the certificate, if it does."""
        return dict(self.transport.check(*of_frame)) if hasattr(self.transport, "check") else {}
