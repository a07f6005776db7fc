"""Finding where radiance jumps as a cloud grows: at suspected thicknesses, and where the curve bends most."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array

NODES = 33
"""Thicknesses, evenly spaced in the logarithm, among which the bends are looked for."""

BENDS = 2
"""Intervals between them that are followed."""

HALVINGS = 24
"""After which an interval is some 1e-8 of its thickness wide, and what changes within it has jumped."""

HAIR = 1e-9
"""Relative distance from a suspected thickness at which is looked on either side."""


@dataclass(frozen=True)
class Jump:
    """A sudden change.

    Attributes
    ----------
    term : int
        Which of the terms.
    thickness_m : float
        Where.
    share : float
        How much, as a share of the sum of all terms there.
    """

    term: int
    thickness_m: float
    share: float


def largest_jump(columns: Callable[[Array], Array], low_m: float, high_m: float, suspected_m: Array) -> Jump:
    """Return the largest change of a term within a hair of thickness.

    A jump shows as second differences that are large at both ends of one interval. The intervals where they are largest
    are halved again and again, and of the two halves that with the larger change is kept: what is smooth vanishes, a
    jump stays. One that is smaller than the bends of the curve itself can be missed where it is not suspected.

    Parameters
    ----------
    columns : callable
        Maps thicknesses (N,) to terms (N, K, V).
    low_m, high_m : float
        Range of thickness.
    suspected_m : ndarray (S,)
        Thicknesses within the range, on either side of which is looked in any case.
    """
    nodes = np.geomspace(low_m, high_m, NODES)
    nodes[0], nodes[-1] = low_m, high_m
    around = np.outer(suspected_m, (1.0 - HAIR, 1.0, 1.0 + HAIR)).ravel()
    found = columns(np.concatenate((nodes, around)))
    values, beside = found[:NODES], found[NODES:].reshape(-1, 3, *found.shape[1:])
    jumps = [
        _jump(at, one, other)
        for at, each in zip(suspected_m.tolist(), beside, strict=True)
        for one, other in ((each[0], each[1]), (each[1], each[2]))
    ]
    bend = np.max(np.abs(np.diff(values, n=2, axis=0)) / _sum(values)[1:-1, None], axis=2)  # (NODES - 2, K)
    bend = np.concatenate((bend[:1], np.minimum(bend[:-1], bend[1:]), bend[-1:]))
    most = np.argsort(np.max(bend, axis=1))[-BENDS:]
    term = np.argmax(bend[most], axis=1)
    left, right, at_left, at_right = nodes[most], nodes[most + 1], values[most], values[most + 1]
    for _ in range(HALVINGS):
        middle = 0.5 * (left + right)
        at_middle = columns(middle)
        lower = _change(at_left, at_middle, term) >= _change(at_middle, at_right, term)
        left, right = np.where(lower, left, middle), np.where(lower, middle, right)
        at_left = np.where(lower[:, None, None], at_left, at_middle)
        at_right = np.where(lower[:, None, None], at_middle, at_right)
    jumps += [_jump(*each) for each in zip(right.tolist(), at_left, at_right, strict=True)]
    return max(jumps, key=lambda jump: jump.share)


def _jump(thickness_m: float, one: Array, other: Array) -> Jump:
    """Largest difference between the terms (K, V) of two columns."""
    changes = [float(_change(one[None], other[None], np.array([term]))[0]) for term in range(one.shape[0])]
    share = max(changes)
    return Jump(changes.index(share), thickness_m, share)


def _change(one: Array, other: Array, term: NDArray[np.intp]) -> Array:
    """Largest difference (I,) over wavenumbers of one term of each column (I, K, V), as a share of the sum."""
    each = np.arange(term.size), term
    change: Array = np.max(np.abs(one[each] - other[each]) / np.maximum(_sum(one), _sum(other)), axis=1)
    return change


def _sum(terms: Array) -> Array:
    """Sum over terms: (N, K, V) to (N, V); not 0, so that one can divide by it."""
    total: Array = np.maximum(np.sum(terms, axis=1), np.finfo(float).tiny)
    return total
