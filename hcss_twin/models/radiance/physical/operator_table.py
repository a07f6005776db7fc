"""Operators of a cloud layer at any thickness and wavenumber, interpolated between those that are solved.

Thicknesses: a logarithmic grid. Wavenumbers: optical properties of particles change little between neighbours of a
dense spectrum, and solving clouds takes most of its time; the gas is always computed at every wavenumber.

Operators of a layer are functions of optical thickness, albedo, similarity parameter and, where the sun shines, phase
function. Between two wavenumbers an operator is off by what the logarithms of these deviate from a straight line there
and, as it is a curved function of them, by about an eighth of the square of their change.

The wavenumbers are those of a lattice between the ends of the bands, whatever grid is asked for: a grid and its
refinement share solved clouds.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array

WINDOW = 10
"""Nodes of the interpolating polynomial; its error is 1e-6 of full reflection with three nodes per doubling of
thickness, as with 6 nodes at 6 per doubling, and 6e-5 with two."""

COARSE_PER_OCTAVE = 2
"""Nodes per doubling for the difference that many streams make: with one, errors reach 3e-4 at grazing angles."""

COARSE_BELOW, COARSE_ABOVE = 2, 1
"""Such nodes beyond the grid; nodes on one side only would err by 1e-3 where light leaves thin clouds."""


def thickness_grid(least_m: float, most_m: float, per_octave: int) -> Array:
    """Return ascending thicknesses most 2^(n / per_octave) that extend beyond both ends by half a window.

    Parameters
    ----------
    least_m, most_m : float
        Range of thickness, above 0.
    per_octave : int
        Nodes per doubling of thickness; each costs a chain of doublings.
    """
    count = math.ceil(math.log2(most_m / least_m) * per_octave)
    steps = np.arange(-count - WINDOW // 2, WINDOW // 2 + 1)
    return np.asarray(most_m * 2.0 ** (steps / per_octave), dtype=np.float64)


@dataclass(frozen=True)
class OperatorTable:
    """Table of operators with thickness as first axis.

    Attributes
    ----------
    thickness_m : ndarray (G,)
        From :func:`thickness_grid`.
    operators : tuple of ndarray (G, ...)
        Those that matter little have one row per octave.
    per_octave : int
        Rows per octave of all others.
    """

    thickness_m: Array
    operators: tuple[Array, ...]
    per_octave: int

    @cached_property
    def floors(self) -> tuple[Array, ...]:
        """Minimum of each operator, at most 0: polynomials undershoot where a cloud becomes opaque."""
        return tuple(np.minimum(np.min(operator, axis=0), 0.0) for operator in self.operators)

    @property
    def least_m(self) -> float:
        """Smallest thickness with a full window around it."""
        return float(self.thickness_m[WINDOW // 2 - 1])

    @property
    def most_m(self) -> float:
        """Largest thickness with a full window around it."""
        return float(self.thickness_m[-WINDOW // 2])

    def at(self, thickness_m: float) -> tuple[Array, ...]:
        """Return the operators of one thickness (...), by Lagrange's polynomial in ln(thickness)."""
        octaves = math.log2(thickness_m / float(self.thickness_m[0]))
        windows, result = {}, []
        for operator, floor in zip(self.operators, self.floors, strict=True):
            count = operator.shape[0]
            if count not in windows:
                windows[count] = _window(octaves if count < self.thickness_m.size else octaves * self.per_octave, count)
            rows, weights = windows[count]
            result.append(np.maximum(np.tensordot(weights.astype(operator.dtype), operator[rows], axes=1), floor))
        return tuple(result)


def _window(position: float, count: int) -> tuple[slice, Array]:
    """Return which of ``count`` nodes interpolate at ``position``, and their weights."""
    nodes = min(WINDOW, count)
    first = min(max(math.floor(position) - nodes // 2 + 1, 0), count - nodes)
    return slice(first, first + nodes), _lagrange(position - first, nodes)


def coarse_thickness(depth: Array, per_octave: int) -> Array:
    """Return thicknesses (S, V) at steps of half an octave around a grid (T, V), for what is small and smooth."""
    octaves = (depth.shape[0] - 1) / per_octave
    steps = np.arange(-COARSE_BELOW, math.ceil(octaves * COARSE_PER_OCTAVE) + COARSE_ABOVE + 1)
    nodes: Array = depth[0] * 2.0 ** (steps / COARSE_PER_OCTAVE)[:, None]
    return nodes


def from_coarse(count: int, per_octave: int) -> Array:
    """Return the weights (T, S) that interpolate T thicknesses of a grid from :func:`coarse_thickness`."""
    known = COARSE_BELOW + math.ceil((count - 1) / per_octave * COARSE_PER_OCTAVE) + COARSE_ABOVE + 1
    weights = np.zeros((count, known))
    for row in range(count):
        columns, weights_of_row = _window(COARSE_BELOW + row * COARSE_PER_OCTAVE / per_octave, known)
        weights[row, columns] = weights_of_row
    return weights


def _lagrange(position: float, nodes: int) -> Array:
    """Return the weights of the nodes 0, 1, ... at a position; they sum to one."""
    weights = np.ones(nodes)
    for i in range(nodes):
        for j in range(nodes):
            if i != j:
                weights[i] *= (position - j) / (i - j)
    result: Array = weights / weights.sum()
    return result


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
    x, operators = wavenumber_cm1[first : last + 1], values[:, first : last + 1]
    share = (x - x[0]) / (x[-1] - x[0])
    bent = np.max(np.abs(operators - operators[:, :1] * (1.0 - share) - operators[:, -1:] * share))
    change = np.max(np.ptp(operators, axis=1))
    return float(bent + change**2 / 8.0)
