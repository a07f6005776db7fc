"""Composite paths through the atmosphere: legs are summed, never multiplied."""

from __future__ import annotations

import math
from dataclasses import dataclass

SPACE = math.inf


@dataclass(frozen=True)
class Leg:
    """A straight piece of path between two altitudes.

    Attributes
    ----------
    lower_m, upper_m : float
        Altitudes of its ends; ``upper_m`` is ``SPACE`` (infinity) for a leg that leaves the atmosphere.
    zenith_deg : float
        Zenith angle at the surface point from which the altitudes count, 0 to below 90.
    """

    lower_m: float
    upper_m: float
    zenith_deg: float

    def __post_init__(self) -> None:
        if not 0.0 <= self.lower_m <= self.upper_m:
            raise ValueError(f"leg from {self.lower_m} m to {self.upper_m} m: needs 0 <= lower_m <= upper_m")
        if not 0.0 <= self.zenith_deg < 90.0:
            raise ValueError(f"zenith_deg {self.zenith_deg}: allowed 0 <= zenith_deg < 90")


@dataclass(frozen=True)
class Path:
    """A composite path: the light crosses each leg in turn, so the absorber amounts add."""

    legs: tuple[Leg, ...] = ()

    def __add__(self, other: Path) -> Path:
        return Path(self.legs + other.legs)


def to_space(lower_m: float, zenith_deg: float) -> Path:
    """Return the path from an altitude to space at a zenith angle (at the surface point)."""
    return Path((Leg(lower_m, SPACE, zenith_deg),))
