"""Operators of a cloud layer at any thickness, interpolated between a logarithmic grid of thicknesses."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

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
        return tuple(np.minimum(np.min(each, axis=0), 0.0) for each in self.operators)

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
        for each, floor in zip(self.operators, self.floors, strict=True):
            count = each.shape[0]
            if count not in windows:
                windows[count] = _window(octaves if count < self.thickness_m.size else octaves * self.per_octave, count)
            rows, weights = windows[count]
            result.append(np.maximum(np.tensordot(weights.astype(each.dtype), each[rows], axes=1), floor))
        return tuple(result)


def _window(place: float, count: int) -> tuple[slice, Array]:
    """Return which of ``count`` nodes interpolate at ``place``, and their weights."""
    nodes = min(WINDOW, count)
    first = min(max(math.floor(place) - nodes // 2 + 1, 0), count - nodes)
    return slice(first, first + nodes), _lagrange(place - first, nodes)


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
