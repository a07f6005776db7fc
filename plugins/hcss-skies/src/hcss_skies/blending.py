"""Blending of patches of an example on a triangular lattice, bent and changed by random flows.

Each lattice point takes a patch from a random place of the example. A pixel is the sum of the scores of the three
patches around it, with weights w^2 / sqrt(sum w^4), which keep the variance 1 (E. Heitz and F. Neyret,
"High-performance by-example noise using a histogram-preserving blending operator", Proc. ACM Comput. Graph. Interact.
Tech. 1(2), 31, 2018, eq 3 with exponent 2). Random numbers are hashes of lattice indices, so that a pixel does not
depend on the window. A patch fades into another one of the same example in time.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from hcss_skies.example import MAX_SCORE
from hcss_skies.hashing import hashed, uniform
from hcss_twin.core.kernels import inner, kernel

_SKEW = 2.0 / math.sqrt(3.0)

# Weights below this limit are cut off, smoothly: a fifth of the samples are then not taken.
_CUT = 0.03


@kernel(fastmath={"contract"})
def blend(
    out: Any, y: Any, x: Any, scores: Any, heights: Any, geometry: Any, flow: Any, bounds: Any, key: int, epoch: float
) -> None:
    """Write p and x (rows, columns, 2) in m at positions ``y`` (rows,), ``x`` (columns,) in pixels of the example.

    Parameters
    ----------
    out : ndarray of float32 (rows, columns, 2)
        The result.
    y, x : ndarray of float64
        Positions.
    scores, heights : ndarray
        Of a :class:`~hcss_skies.pyramid.Level`.
    geometry : ndarray (6,)
        Lattice spacing; smallest y and x and range along y and x of centres of patches; scale of the level.
    flow : ndarray of float32 (octaves, node rows, node columns)
        Stream function at nodes; its slope per node distance is the displacement in pixels of the example.
    bounds : ndarray (octaves, 3)
        Distance of nodes in pixels of the example, and index of the first row and column.
    key : int
        Of the random numbers.
    epoch : float
        Time in lifetimes of a patch; NaN: patches do not change.
    """
    spacing = geometry[0]
    octaves = flow.shape[0]
    nodes = flow.shape[2]
    along = np.empty((octaves, nodes))
    across = np.empty((octaves, nodes))
    node = np.empty((octaves, x.size), np.int64)
    spline = np.empty((octaves, x.size, 8))
    for octave in range(octaves):
        for j in range(x.size):
            position = x[j] / bounds[octave, 0] - bounds[octave, 2]
            node[octave, j] = math.floor(position) - 1
            _spline(position - math.floor(position), spline[octave, j])
    at_row = np.empty(8)
    # of the three lattice points: weights and positions of two patches each
    place = np.empty((3, 2, 2))
    fade = np.empty((3, 2))
    for i in range(y.size):
        for octave in range(octaves):
            position = y[i] / bounds[octave, 0] - bounds[octave, 1]
            row = math.floor(position) - 1
            _spline(position - math.floor(position), at_row)
            for k in range(nodes):
                along[octave, k] = across[octave, k] = 0.0
                for n in range(4):
                    along[octave, k] += at_row[n] * flow[octave, row + n, k]
                    across[octave, k] += at_row[n + 4] * flow[octave, row + n, k]
        last_u, last_v, last_upper = np.int64(0), np.int64(0), -1
        for j in range(x.size):
            at_y, at_x = y[i], x[j]
            for octave in range(octaves):
                k = node[octave, j]
                # velocity (d psi / dy, - d psi / dx) of a stream function
                for n in range(4):
                    at_x += spline[octave, j, n] * across[octave, k + n]
                    at_y -= spline[octave, j, n + 4] * along[octave, k + n]
            v = at_y / spacing * _SKEW
            u = at_x / spacing - 0.5 * v
            cell_u, cell_v = np.int64(math.floor(u)), np.int64(math.floor(v))
            fu, fv = u - cell_u, v - cell_v
            upper = 1 if fu + fv >= 1.0 else 0
            if cell_u != last_u or cell_v != last_v or upper != last_upper:
                last_u, last_v, last_upper = cell_u, cell_v, upper
                _choose(place, fade, cell_u, cell_v, upper, geometry, key, epoch)
            if upper:
                w0, w1, w2 = fu + fv - 1.0, 1.0 - fv, 1.0 - fu
            else:
                w0, w1, w2 = 1.0 - fu - fv, fu, fv
            w0, w1, w2 = max(w0 - _CUT, 0.0), max(w1 - _CUT, 0.0), max(w2 - _CUT, 0.0)
            w0, w1, w2 = w0 * w0, w1 * w1, w2 * w2
            opaque = excess = 0.0
            square = 0.0
            for corner in range(3):
                weight = w0 if corner == 0 else (w1 if corner == 1 else w2)
                if weight > 0.0:
                    for turn in range(2):
                        share = weight * fade[corner, turn]
                        if share > 0.0:
                            one, other = _sample(
                                scores, at_y + place[corner, turn, 0], at_x + place[corner, turn, 1]
                                , geometry[5]
                            )  # fmt: skip
                            opaque += share * one
                            excess += share * other
                            square += share * share
            norm = 1.0 / math.sqrt(square)
            out[i, j, 0] = _look_up(heights, opaque * norm, 0)
            out[i, j, 1] = _look_up(heights, excess * norm, 1)


@inner(fastmath={"contract"})
def _spline(f: float, out: Any) -> None:
    """Write the weights (0 to 3) of a cubic B-spline and those of its slope (4 to 7), a fraction past the second."""
    g = 1.0 - f
    out[0], out[3] = g * g * g / 6.0, f * f * f / 6.0
    out[1], out[2] = 2.0 / 3.0 - f * f + 0.5 * f * f * f, 2.0 / 3.0 - g * g + 0.5 * g * g * g
    out[4], out[7] = -0.5 * g * g, 0.5 * f * f
    out[5], out[6] = 1.5 * f * f - 2.0 * f, 2.0 * g - 1.5 * g * g


@inner()
def _choose(place: Any, fade: Any, cell_u: int, cell_v: int, upper: int, geometry: Any, key: int, epoch: float) -> None:
    """Write displacements (3, 2, 2) and weights (3, 2) of the old and the new patch of each point of a triangle."""
    spacing = geometry[0]
    for corner in range(3):
        if upper:
            u, v = cell_u + (corner != 2), cell_v + (corner != 1)
        else:
            u, v = cell_u + (corner == 1), cell_v + (corner == 2)
        first = hashed(hashed(np.uint64(key), u), v)
        number, share = np.int64(0), 0.0
        if not math.isnan(epoch):
            age = epoch + uniform(first)
            number = np.int64(math.floor(age))
            # A patch lasts for half of the time and fades in the other half.
            phase = min(max(2.0 * (age - number) - 0.5, 0.0), 1.0)
            share = phase * phase * (3.0 - 2.0 * phase)
        # weights of old and new patch whose squares sum to 1
        fade[corner, 0], fade[corner, 1] = math.cos(0.5 * math.pi * share), math.sin(0.5 * math.pi * share)
        if share == 0.0:
            fade[corner, 1] = 0.0
        elif share == 1.0:
            fade[corner, 0] = 0.0
        for turn in range(2):
            random = hashed(first, number + turn)
            again = hashed(random, np.int64(1))
            place[corner, turn, 0] = geometry[1] + geometry[3] * uniform(random) - v * spacing / _SKEW
            place[corner, turn, 1] = geometry[2] + geometry[4] * uniform(again) - (u + 0.5 * v) * spacing


@inner(fastmath={"contract"})
def _sample(scores: Any, y: float, x: float, scale: float) -> tuple[float, float]:
    """Return both scores at a position in pixels of the example, bilinear between quarters of pixels of the level."""
    rows, columns = scores.shape[0], scores.shape[1]
    at_y = min(max(2.0 * y / scale - 0.5, 0.0), rows - 1.001)
    at_x = min(max(2.0 * x / scale - 0.5, 0.0), columns - 1.001)
    i, j = int(at_y), int(at_x)
    fy, fx = np.float32(at_y - i), np.float32(at_x - j)
    a = scores[i, j, 0] + fx * (scores[i, j + 1, 0] - scores[i, j, 0])
    b = scores[i + 1, j, 0] + fx * (scores[i + 1, j + 1, 0] - scores[i + 1, j, 0])
    c = scores[i, j, 1] + fx * (scores[i, j + 1, 1] - scores[i, j, 1])
    d = scores[i + 1, j, 1] + fx * (scores[i + 1, j + 1, 1] - scores[i + 1, j, 1])
    return a + fy * (b - a), c + fy * (d - c)


@inner(fastmath={"contract"})
def _look_up(heights: Any, score: float, column: int) -> Any:
    last = heights.shape[0] - 1
    position = min(max((score + MAX_SCORE) * (last / (2.0 * MAX_SCORE)), 0.0), last - 1e-6)
    k = int(position)
    low = float(heights[k, column])
    return low + (position - k) * (float(heights[k + 1, column]) - low)
