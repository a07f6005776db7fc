"""Composite paths through the atmosphere, and sums over their legs.

Absorber amounts of legs are added. Transmittances of legs are never multiplied, because those of a spectral interval
with many lines do not multiply: light that passed the first leg lacks the wavelengths that the second would absorb.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from hcss_twin.core.arrays import Array

SPACE = math.inf
"""Altitude of the upper end of a leg that leaves the atmosphere, m."""


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


Compute = Callable[[Iterable[Leg], dict[Leg, Array]], None]
"""Computes the values (K,) of some legs and stores them in the dictionary."""

_MAX_LEGS = 20_000
"""Number of legs with cached values, about 1 kB each: columns with many cloud-top heights share the legs between
levels, and data sets meet new altitudes in each frame."""


class LegSums:
    """Sums over the legs of paths, for values (K,) of single legs that are computed once.

    Parameters
    ----------
    size : int
        K.
    compute : callable
        Stores the values of new legs; see :data:`Compute`.
    """

    def __init__(self, size: int, compute: Compute) -> None:
        self._size = size
        self._compute = compute
        self._known: dict[Leg, Array] = {}

    def of(self, paths: Sequence[Path]) -> Array:
        """Return the sums of composite paths, (P, K)."""
        known = self._known
        if len(known) > _MAX_LEGS:
            known = self._known = {}  # other threads may still read the old one
        legs = [leg for path in paths for leg in path.legs]
        # One look-up for each leg: hashing hundreds of legs takes as long as following their rays.
        stored = [known.get(leg) for leg in legs]
        new = [leg for leg, values in zip(legs, stored, strict=True) if values is None]
        if new:
            self._compute(dict.fromkeys(new), known)
        amounts = [known[leg] if values is None else values for leg, values in zip(legs, stored, strict=True)]
        if all(len(path.legs) == 1 for path in paths):
            return np.concatenate(amounts).reshape(len(paths), self._size) if amounts else np.zeros((0, self._size))
        result = np.zeros((len(paths), self._size))
        first = np.cumsum([0, *(len(path.legs) for path in paths)])
        for number in range(int(np.max(np.diff(first), initial=0))):
            chosen = np.flatnonzero(np.diff(first) > number)
            result[chosen] += [amounts[start + number] for start in first[chosen].tolist()]
        return result
