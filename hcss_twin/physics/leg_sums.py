"""Sums over the legs of composite paths, of something that is known of each leg by itself."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from hcss_twin.physics.paths import Leg, Path

Array = NDArray[np.float64]
Compute = Callable[[Iterable[Leg], dict[Leg, Array]], None]
"""Adds what some legs have, (K,) each, to those known."""

_KEPT_LEGS = 100_000
"""Legs that are kept: columns with cloud tops at many heights share those between levels."""


class LegSums:
    """Sums over legs, each of which is computed once.

    Parameters
    ----------
    size : int
        K of what each leg has, (K,).
    compute : callable
        Maps legs and those known to nothing; the former are added to the latter.
    """

    def __init__(self, size: int, compute: Compute) -> None:
        self._size = size
        self._compute = compute
        self._known: dict[Leg, Array] = {}

    def of(self, paths: Sequence[Path]) -> Array:
        """Return the sums of composite paths, (P, K)."""
        known = self._known
        if len(known) > _KEPT_LEGS:
            known = self._known = {}  # other threads may still read the old one
        legs = [leg for path in paths for leg in path.legs]
        # Looked up once: hashing hundreds of legs takes as long as following their rays.
        found = [known.get(leg) for leg in legs]
        new = [leg for leg, each in zip(legs, found, strict=True) if each is None]
        if new:
            self._compute(dict.fromkeys(new), known)
        each = [known[leg] if own is None else own for leg, own in zip(legs, found, strict=True)]
        if all(len(path.legs) == 1 for path in paths):
            return np.concatenate(each).reshape(len(paths), self._size) if each else np.zeros((0, self._size))
        result = np.zeros((len(paths), self._size))
        first = np.cumsum([0, *(len(path.legs) for path in paths)])
        for place in range(int(np.max(np.diff(first), initial=0))):
            chosen = np.flatnonzero(np.diff(first) > place)
            result[chosen] += [each[start + place] for start in first[chosen].tolist()]
        return result
