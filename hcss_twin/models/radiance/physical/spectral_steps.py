"""Wavenumbers at which the clouds of a dense spectrum are solved; between them, operators are linear in wavenumber.

Optical properties of particles change little between neighbours of a dense grid, and solving clouds takes most of the
time of a spectrum. The gas is always computed at every wavenumber.

Operators of a layer are functions of optical thickness, albedo, similarity parameter and, where the sun shines, phase
function. Between two wavenumbers an operator is off by what the logarithms of these deviate from a straight line there
and, as it is a curved function of them, by about an eighth of the square of their change.

The wavenumbers are those of a lattice between the ends of the bands, whatever grid is asked for: a grid and its
refinement share solved clouds.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array

DENSE = 64
"""Grids with fewer wavenumbers are solved at each of them."""

LONGEST_CM1, SHORTEST_CM1 = 80.0, 2.5
"""Distances of solved neighbours: the larger one is halved until the operators are accurate, but not further than to
the smaller one."""


@dataclass(frozen=True)
class SpectralSteps:
    """Solved wavenumbers, and how those of a grid lie between them.

    Attributes
    ----------
    wavenumber_cm1 : ndarray (S,)
        Solved, ascending.
    below : ndarray of int (V,), optional
        Which of the solved ones is the next one below; None if the grid itself is solved.
    share : ndarray (V,), optional
        Of the way from there to the next solved one, 0 to 1.
    """

    wavenumber_cm1: Array
    below: NDArray[np.intp] | None = None
    share: Array | None = None

    def spread(self, solved: Array) -> Array:
        """Return an operator (..., V) from its values (..., S)."""
        if self.below is None or self.share is None:
            return solved
        share = self.share.astype(solved.dtype)
        result: Array = solved[..., self.below] * (1 - share) + solved[..., self.below + 1] * share
        return result


def spectral_steps(wavenumber_cm1: Array, properties: Callable[[Array], Array], tolerance: float) -> SpectralSteps:
    """Choose the wavenumbers at which a layer is solved.

    Parameters
    ----------
    wavenumber_cm1 : ndarray (V,)
        Ascending.
    properties : callable
        Returns (K, S) of wavenumbers (S,): operators are smooth functions of their values.
    tolerance : float
        Error of an operator, relative to its value; with 0, every wavenumber of the grid is solved.
    """
    if tolerance <= 0.0 or wavenumber_cm1.size < DENSE:
        return SpectralSteps(wavenumber_cm1)
    runs = np.split(wavenumber_cm1, np.flatnonzero(np.diff(wavenumber_cm1) > LONGEST_CM1) + 1)
    solved = np.concatenate([_solved(float(run[0]), float(run[-1]), properties, tolerance) for run in runs])
    if solved.size >= wavenumber_cm1.size:
        return SpectralSteps(wavenumber_cm1)
    below = np.clip(np.searchsorted(solved, wavenumber_cm1, side="right") - 1, 0, solved.size - 2)
    return SpectralSteps(solved, below, (wavenumber_cm1 - solved[below]) / (solved[below + 1] - solved[below]))


def _solved(low: float, high: float, properties: Callable[[Array], Array], tolerance: float) -> Array:
    """Return the solved wavenumbers (S,) of a run, its ends included."""
    inside = np.arange(np.floor(low / SHORTEST_CM1) + 1.0, np.ceil(high / SHORTEST_CM1)) * SHORTEST_CM1
    lattice = np.unique(np.concatenate(([low], inside, [high])))
    values = properties(lattice)
    ends = sorted({0, *np.flatnonzero(lattice % LONGEST_CM1 == 0.0).tolist(), lattice.size - 1})
    waiting, chosen = list(pairwise(ends)), set(ends)
    while waiting:
        first, last = waiting.pop()
        if last - first < 2 or _error(lattice, values, first, last) <= tolerance:
            continue
        middle = (first + last) // 2
        chosen.add(middle)
        waiting += [(first, middle), (middle, last)]
    return lattice[sorted(chosen)]


def _error(wavenumber_cm1: Array, values: Array, first: int, last: int) -> float:
    """Return how far operators between two wavenumbers are from a straight line."""
    x, own = wavenumber_cm1[first : last + 1], values[:, first : last + 1]
    share = (x - x[0]) / (x[-1] - x[0])
    bent = np.max(np.abs(own - own[:, :1] * (1.0 - share) - own[:, -1:] * share))
    change = np.max(np.ptp(own, axis=1))
    return float(bent + change**2 / 8.0)
