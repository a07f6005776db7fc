"""Flows that bend the blended field without divergence: stream functions from random nodes in space and time."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_skies.hashing import hashed, normal
from hcss_twin.core.kernels import kernel
from hcss_twin.providers import Array

# rms of one component of the gradient of a cubic B-spline surface whose nodes have variance 1, in node distances:
# mean over a cell of sum B'(x)^2 is 2/3, of sum B(y)^2 is 151/315.
_GRADIENT = math.sqrt(2.0 / 3.0 * 151.0 / 315.0)
_VALUE = 151.0 / 315.0  # rms of the surface itself


@dataclass(frozen=True)
class Octave:
    """Displacements of one scale.

    Attributes
    ----------
    wavelength_m : float
        Of the largest swirls; nodes are a third of it apart.
    rms_m : float
        Displacement along one axis.
    time_s : float
        In which a displacement becomes another one.
    """

    wavelength_m: float
    rms_m: float
    time_s: float


OCTAVES = Octave(144e3, 2800.0, 3200.0), Octave(72e3, 1350.0, 1800.0)
"""Displacements that, with the speeds of patches, give measured lifetimes of structures.

Larger ones bend clouds so much that a classifier sees it (twice as large: AUC .69 instead of .665).
"""

LONG_S = 200_000.0
"""Time in which waves longer than patches become other ones: their measured coherence after 45 min is .96 and more."""

# Displacements far below a pixel are left out.
_LEAST_PIXELS = 0.15


def flow_nodes(
    octaves: tuple[Octave, ...], y: Array, x: Array, example_pixel_m: float, pixel: float, seed: int, time_s: float
) -> tuple[NDArray[np.float32], Array]:
    """Return nodes (octaves, rows, columns) around positions in pixels of the example, and distance and first indices.

    Parameters
    ----------
    octaves : tuple of Octave
        Scales.
    y, x : ndarray
        Positions, ascending.
    example_pixel_m : float
        Side of a pixel of the example.
    pixel : float
        Side of a pixel of the image in pixels of the example.
    seed : int
        Of the random nodes.
    time_s : float
        Time; NaN: the first one, at which nothing changes.
    """
    used = [octave for octave in octaves if octave.rms_m >= _LEAST_PIXELS * pixel * example_pixel_m]
    windows = []
    for octave in used:
        distance = octave.wavelength_m / 3.0 / example_pixel_m
        ends = [(math.floor(axis[0] / distance) - 1, math.floor(axis[-1] / distance) + 3) for axis in (y, x)]
        windows.append((distance, ends))
    rows, columns = (max((w[1][n][1] - w[1][n][0] + 1 for w in windows), default=1) for n in range(2))
    nodes = np.zeros((len(used), rows, columns), np.float32)
    bounds = np.zeros((len(used), 3))
    for n, (octave, (distance, ends)) in enumerate(zip(used, windows, strict=True)):
        at = 0.0 if math.isnan(time_s) else time_s / octave.time_s
        knot = math.floor(at)
        weights = _spline(at - knot)
        weights *= octave.rms_m / example_pixel_m / _GRADIENT / math.sqrt(float(weights @ weights))
        _fill(nodes[n], ends[0][0], ends[1][0], knot - 1, weights, np.uint64(seed), n)
        bounds[n] = distance, ends[0][0], ends[1][0]
    return nodes, bounds


def long_waves(
    y: Array, x: Array, distance: float, deviation: float, seed: int, time_s: float
) -> tuple[NDArray[np.float32], Array]:
    """Return nodes (rows, columns) of a normal field of a standard deviation, and their distance and first indices."""
    ends = [(math.floor(axis[0] / distance) - 1, math.floor(axis[-1] / distance) + 3) for axis in (y, x)]
    nodes = np.empty((ends[0][1] - ends[0][0] + 1, ends[1][1] - ends[1][0] + 1), np.float32)
    at = 0.0 if math.isnan(time_s) else time_s / LONG_S
    knot = math.floor(at)
    weights = _spline(at - knot)
    weights *= deviation / _VALUE / math.sqrt(float(weights @ weights))
    _fill(nodes, ends[0][0], ends[1][0], knot - 1, weights, np.uint64(seed), 99)
    return nodes, np.array([distance, ends[0][0], ends[1][0]])


def _spline(f: float) -> Array:
    """Return the weights (4,) of a cubic B-spline."""
    g = 1.0 - f
    return np.array([g**3, 4.0 - 6.0 * f**2 + 3.0 * f**3, 4.0 - 6.0 * g**2 + 3.0 * g**3, f**3]) / 6.0


@kernel()
def _fill(nodes: Any, first_row: int, first_column: int, first_knot: int, weights: Any, seed: Any, octave: int) -> None:
    """Write nodes of one octave: normal numbers in space, a spline in time."""
    state = hashed(hashed(seed, 7001), octave)
    for i in range(nodes.shape[0]):
        row = hashed(state, first_row + i)
        for j in range(nodes.shape[1]):
            node = hashed(row, first_column + j)
            total = 0.0
            for k in range(4):
                total += weights[k] * normal(hashed(node, first_knot + k))
            nodes[i, j] = total
