"""How the accuracy of a scene is shared out among what the engine does approximately, and what each found."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields

SHARES: Mapping[str, float] = {
    "wavenumbers": 0.25,
    "thickness": 0.1,
    "two_layers": 0.1,
    "waves": 0.1,
    "views": 0.07,
    "shadows": 0.05,
    "time": 0.1,
    "other_instants": 0.02,
    "faint_sunlight": 0.1,
}
"""Of the accuracy. A pixel has cloud in one layer or in both, or waves: the largest of the three counts."""

MEANING: Mapping[str, str] = {
    "wavenumbers": "few weighted wavenumbers stand for the whole grid",
    "thickness": "columns with cloud in one layer, between computed ones",
    "two_layers": "columns with cloud in two layers, between computed ones",
    "waves": "clear columns over waves, between computed slopes",
    "views": "between computed views, where pixels have views of their own",
    "shadows": "sunlight through clouds, between computed paths",
    "time": "between instants",
    "faint_sunlight": "computing without sunlight by day, where there is so little",
    "other_instants": "columns at further instants, from those at the first",
}


@dataclass(frozen=True)
class Budget:
    """Relative errors of the total radiance, one for each approximation: allowed ones, or those found.

    A found error is 0 where nothing was approximated.
    """

    wavenumbers: float = 0.0
    thickness: float = 0.0
    two_layers: float = 0.0
    waves: float = 0.0
    views: float = 0.0
    shadows: float = 0.0
    time: float = 0.0
    other_instants: float = 0.0
    faint_sunlight: float = 0.0

    @property
    def total(self) -> float:
        """What a pixel can have of them together."""
        somewhere = max(self.thickness, self.two_layers, self.waves)
        return (
            self.wavenumbers
            + somewhere
            + self.views
            + self.shadows
            + self.time
            + self.other_instants
            + self.faint_sunlight
        )

    def as_dict(self) -> dict[str, float]:
        """Plain values by name."""
        return {field.name: getattr(self, field.name) for field in fields(self)}


def share_out(accuracy: float) -> Budget:
    """Return what each approximation may err by."""
    return Budget(**{name: share * accuracy for name, share in SHARES.items()})
