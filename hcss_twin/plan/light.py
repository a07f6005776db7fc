"""Light between columns of cloud, as a plan has it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from hcss_twin.core.plugins import Origin


@dataclass(frozen=True)
class PlannedLight:
    """Light transport of a scene.

    Attributes
    ----------
    name : str
        Value of ``radiance.light``.
    origin : Origin
        Distribution that provides it.
    transport : type
        Its class.
    expected : dict of str to float or None
        Error (rms over pixels, relative to the mean radiance) that it states for each band of the scene; None if it
        states none.
    """

    name: str
    origin: Origin
    transport: Any
    expected: dict[str, float] | None = None

    @property
    def note(self) -> str:
        """What cube and plan say of it."""
        size = "its error is not stated"
        if self.expected is not None:
            each = ", ".join(f"{name} {100.0 * error:.2g} %" for name, error in self.expected.items())
            size = f"expected error of this effect, rms over pixels: {each}"
        return (
            f"clouds have sides (radiance.light = '{self.name}' of {self.origin}); {size}. The certificate checks the "
            "radiance of independent columns, to which the effect of sides is added, and not this effect"
        )

    def as_dict(self) -> dict[str, Any]:
        """Plain values for plan and cube."""
        return {"name": self.name, "provider": str(self.origin), "expected_rms": self.expected}
