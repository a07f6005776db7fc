"""Operators of a cloud layer against its thickness, interpolated between thicknesses that double."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

PER_OCTAVE = 3
"""Nodes in each doubling of thickness, each of which costs a chain of doublings of its own."""

_WINDOW = 10
"""Nodes of the polynomial: with 3 in each doubling it errs by 1e-6 of full reflection, as 6 with a window of 6 do."""


def thickness_grid(least_m: float, most_m: float) -> Array:
    """Return thicknesses most 2^(n / 3), ascending, that reach beyond both ends by half a window.

    Parameters
    ----------
    least_m, most_m : float
        Range of thickness, above 0.
    """
    count = math.ceil(math.log2(most_m / least_m) * PER_OCTAVE)
    steps = np.arange(-count - _WINDOW // 2, _WINDOW // 2 + 1)
    return np.asarray(most_m * 2.0 ** (steps / PER_OCTAVE), dtype=np.float64)


@dataclass(frozen=True)
class OperatorTable:
    """Arrays whose first axis is the thickness.

    Attributes
    ----------
    thickness_m : ndarray (G,)
        From :func:`thickness_grid`.
    operators : tuple of ndarray (G, ...)
    """

    thickness_m: Array
    operators: tuple[Array, ...]

    @cached_property
    def floors(self) -> tuple[Array, ...]:
        """The least of each operator, at most 0: polynomials swing below where a cloud turns opaque."""
        return tuple(np.minimum(np.min(each, axis=0), 0.0) for each in self.operators)

    @property
    def least_m(self) -> float:
        """Smallest thickness with a full window around it."""
        return float(self.thickness_m[_WINDOW // 2 - 1])

    @property
    def most_m(self) -> float:
        """Greatest thickness with a full window around it."""
        return float(self.thickness_m[-_WINDOW // 2])

    def at(self, thickness_m: float) -> tuple[Array, ...]:
        """Return the operators of one thickness (...), by Lagrange's polynomial in ln(thickness)."""
        place = math.log2(thickness_m / float(self.thickness_m[0])) * PER_OCTAVE
        first = min(max(math.floor(place) - _WINDOW // 2 + 1, 0), self.thickness_m.size - _WINDOW)
        weights = _lagrange(place - first)
        return tuple(
            np.maximum(np.tensordot(weights, each[first : first + _WINDOW], axes=1), floor)
            for each, floor in zip(self.operators, self.floors, strict=True)
        )


def _lagrange(position: float) -> Array:
    """Weights of the nodes 0, 1, ... 9 at a position; they sum to one."""
    weights = np.ones(_WINDOW)
    for i in range(_WINDOW):
        for j in range(_WINDOW):
            if i != j:
                weights[i] *= (position - j) / (i - j)
    result: Array = weights / weights.sum()
    return result
