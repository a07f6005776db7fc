"""Blending of patches of an example on a triangular lattice, bent and changed by random flows.

Each lattice point takes a patch from a random place of the example. A pixel is the sum of the scores of the three
patches around it, with weights w^2 / sqrt(sum w^4), which keep the variance 1 (E. Heitz and F. Neyret,
"High-performance by-example noise using a histogram-preserving blending operator", Proc. ACM Comput. Graph. Interact.
Tech. 1(2), 31, 2018, eq 3 with exponent 2). Random numbers are hashes of lattice indices, so that a pixel does not
depend on the window. A patch moves through the example at a speed of its own, as long as it lives, and fades into
another one. Speeds have a Cauchy distribution up to a limit: what moves v t keeps the part cos(k v t) of waves with
wavenumber k, the mean of which is exp(-k s t) for speeds of scale s. Structures live in proportion to their size, as
measured.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from hcss_skies.example import MAX_SCORE
from hcss_skies.hashing import hashed, normal, uniform
from hcss_twin.core.kernels import inner, kernel

_SKEW = 2.0 / math.sqrt(3.0)

_SLOWEST = 0.4
"""Least denominator of a speed. With .06, waves of 64 to 96 km change as measured, but a second changes .017 K rms."""

CUT = 0.15
"""Weights below this limit are cut off, smoothly: three in ten samples are then not taken, and contrast is kept."""


@kernel(fastmath={"contract"})
def blend(
    out: Any, y: Any, x: Any, scores: Any, heights: Any, geometry: Any, flow: Any, bounds: Any, key: int, epoch: float
) -> None:
    """Write p and x (rows, columns, 2), or p alone (rows, columns, 1), in m at positions in pixels of the example.

    Parameters
    ----------
    out : ndarray of float32 (rows, columns, fields)
        The result.
    y, x : ndarray of float64 (rows,), (columns,)
        Positions.
    scores, heights : ndarray
        Of a :class:`~hcss_skies.pyramid.Level`.
    geometry : ndarray (9,)
        Lattice spacing; smallest y and x and range along y and x of centres of patches; scale of the level; y and x
        of the lattice; scale of the displacement of a patch in its lifetime.
    flow : ndarray of float32 (octaves, node rows, node columns)
        Stream function at nodes; its slope per node distance is the displacement in pixels of the example.
    bounds : ndarray (octaves, 3)
        Distance of nodes in pixels of the example, and index of the first row and column.
    key : int
        Of the random numbers.
    epoch : float
        Time in lifetimes of a patch; NaN: patches do not change.
    """
    joint = out.shape[2] == 2
    at_y, at_x = np.empty(x.size), np.empty(x.size)
    interval, past = np.empty((flow.shape[0], x.size), np.int64), np.empty((flow.shape[0], x.size))
    for octave in range(flow.shape[0]):
        for j in range(x.size):
            position = x[j] / bounds[octave, 0]
            whole = math.floor(position)
            interval[octave, j], past[octave, j] = np.int64(whole - bounds[octave, 2]) - 1, position - whole
    curves = np.empty((flow.shape[0], max(flow.shape[2] - 3, 1), 7))
    # patches of a triangle: corner, displacement along y and x in samples, weight
    corner, place, fade = np.empty(6, np.int64), np.empty((6, 2)), np.empty(6, np.float32)
    weight = np.empty(3, np.float32)
    to_samples = 2.0 / geometry[5]
    limits = scores.shape[0] - 1.001, scores.shape[1] - 1.001
    for i in range(y.size):
        _displaced(at_y, at_x, y[i], x, geometry[6], geometry[7], flow, bounds, interval, past, curves)
        last_u, last_v, last_upper, count = np.int64(0), np.int64(0), -1, 0
        for j in range(x.size):
            v = at_y[j] / geometry[0] * _SKEW
            u = at_x[j] / geometry[0] - 0.5 * v
            cell_u, cell_v = np.int64(math.floor(u)), np.int64(math.floor(v))
            fu, fv = np.float32(u - cell_u), np.float32(v - cell_v)
            upper = 1 if fu + fv >= np.float32(1.0) else 0
            if cell_u != last_u or cell_v != last_v or upper != last_upper:
                last_u, last_v, last_upper = cell_u, cell_v, upper
                count = _choose(corner, place, fade, cell_u, cell_v, upper, geometry, key, epoch)
            if upper:
                w0, w1, w2 = fu + fv - np.float32(1.0), np.float32(1.0) - fv, np.float32(1.0) - fu
            else:
                w0, w1, w2 = np.float32(1.0) - fu - fv, fu, fv
            cut, zero = np.float32(CUT), np.float32(0.0)
            w0, w1, w2 = max(w0 - cut, zero), max(w1 - cut, zero), max(w2 - cut, zero)
            weight[0], weight[1], weight[2] = w0 * w0, w1 * w1, w2 * w2
            opaque = excess = square = zero
            own_y, own_x = at_y[j] * to_samples - 0.5, at_x[j] * to_samples - 0.5
            for n in range(count):
                share = weight[corner[n]] * fade[n]
                if share > zero:
                    # bilinear between quarters of pixels of the level
                    row = min(max(own_y + place[n, 0], 0.0), limits[0])
                    column = min(max(own_x + place[n, 1], 0.0), limits[1])
                    k, m = int(row), int(column)
                    fy, fx = np.float32(row - k), np.float32(column - m)
                    a = scores[k, m, 0] + fx * (scores[k, m + 1, 0] - scores[k, m, 0])
                    b = scores[k + 1, m, 0] + fx * (scores[k + 1, m + 1, 0] - scores[k + 1, m, 0])
                    opaque += share * (a + fy * (b - a))
                    if joint:
                        a = scores[k, m, 1] + fx * (scores[k, m + 1, 1] - scores[k, m, 1])
                        b = scores[k + 1, m, 1] + fx * (scores[k + 1, m + 1, 1] - scores[k + 1, m, 1])
                        excess += share * (a + fy * (b - a))
                    square += share * share
            norm = np.float32(1.0) / np.sqrt(square)
            out[i, j, 0] = _look_up(heights, opaque * norm, 0)
            if joint:
                out[i, j, 1] = _look_up(heights, excess * norm, 1)


@inner(fastmath={"contract"})
def _displaced(
    at_y: Any,
    at_x: Any,
    y: float,
    x: Any,
    shift_y: float,
    shift_x: float,
    flow: Any,
    bounds: Any,
    interval: Any,
    past: Any,
    curves: Any,
) -> None:
    """Write positions (columns,) of a row, shifted, moved by (d psi / dy, - d psi / dx) of the stream function psi.

    Along a row, the spline is a cubic between two nodes: its coefficients are computed once for all pixels there.
    """
    for j in range(x.size):
        at_y[j], at_x[j] = y + shift_y, x[j] + shift_x
    spline = np.empty(8)
    for octave in range(flow.shape[0]):
        position = y / bounds[octave, 0]
        row = np.int64(math.floor(position) - bounds[octave, 1]) - 1
        _spline(position - math.floor(position), spline)
        nodes = flow.shape[2]
        a0 = a1 = a2 = b0 = b1 = b2 = 0.0
        for k in range(nodes):
            along = across = 0.0
            for n in range(4):
                along += spline[n] * flow[octave, row + n, k]
                across += spline[n + 4] * flow[octave, row + n, k]
            if k >= 3:
                curve = curves[octave, k - 3]
                # of a cubic B-spline through b0, b1, b2, across, and of the slope of that through a0, a1, a2, along
                curve[0] = (b0 + 4.0 * b1 + b2) / 6.0
                curve[1] = 0.5 * (b2 - b0)
                curve[2] = 0.5 * (b0 - 2.0 * b1 + b2)
                curve[3] = (across - b0) / 6.0 + 0.5 * (b1 - b2)
                curve[4] = 0.5 * (a2 - a0)
                curve[5] = a0 - 2.0 * a1 + a2
                curve[6] = 0.5 * (along - a0) + 1.5 * (a1 - a2)
            a0, a1, a2 = a1, a2, along
            b0, b1, b2 = b1, b2, across
        for j in range(x.size):
            k, f = interval[octave, j], past[octave, j]
            slope = curves[octave, k, 1] + f * (curves[octave, k, 2] + f * curves[octave, k, 3])
            at_x[j] += curves[octave, k, 0] + f * slope
            at_y[j] -= curves[octave, k, 4] + f * (curves[octave, k, 5] + f * curves[octave, k, 6])


@inner(fastmath={"contract"})
def _spline(f: float, out: Any) -> None:
    """Write the weights (0 to 3) of a cubic B-spline and those of its slope (4 to 7), a fraction past the second."""
    g = 1.0 - f
    out[0], out[3] = g * g * g / 6.0, f * f * f / 6.0
    out[1], out[2] = 2.0 / 3.0 - f * f + 0.5 * f * f * f, 2.0 / 3.0 - g * g + 0.5 * g * g * g
    out[4], out[7] = -0.5 * g * g, 0.5 * f * f
    out[5], out[6] = 1.5 * f * f - 2.0 * f, 2.0 * g - 1.5 * g * g


@inner()
def _choose(
    corners: Any, place: Any, fade: Any, cell_u: int, cell_v: int, upper: int, geometry: Any, key: int, epoch: float
) -> int:
    """Write the corner, displacement in samples (y, x) and weight of each patch of a triangle; return their number."""
    spacing, to_samples = geometry[0], 2.0 / geometry[5]
    count = 0
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
            # A patch is alone for three quarters of the time and fades in the rest.
            phase = min(max(4.0 * (age - number) - 1.5, 0.0), 1.0)
            share = phase * phase * (3.0 - 2.0 * phase)
        for turn in range(2):
            if share == 1.0 - turn:
                continue
            random = hashed(first, number + turn)
            again = hashed(random, np.int64(1))
            corners[count] = corner
            # The squares of the weights of the old and the new patch sum to 1.
            fade[count] = math.sin(0.5 * math.pi * share) if turn else math.cos(0.5 * math.pi * share)
            drift = 0.0
            if not math.isnan(epoch):  # from the middle of the life; a ratio of normal numbers
                slow = abs(normal(hashed(random, np.int64(2))))
                drift = geometry[8] * (age - number - turn) / max(slow, _SLOWEST)
            towards_y, towards_x = normal(hashed(random, np.int64(3))), normal(hashed(random, np.int64(4)))
            centre_y = geometry[1] + _within(geometry[3] * uniform(random) + drift * towards_y, geometry[3])
            centre_x = geometry[2] + _within(geometry[4] * uniform(again) + drift * towards_x, geometry[4])
            place[count, 0] = to_samples * (centre_y - v * spacing / _SKEW)
            place[count, 1] = to_samples * (centre_x - (u + 0.5 * v) * spacing)
            count += 1
    return count


@inner()
def _within(place: float, span: float) -> float:
    """Return a place between 0 and the span: what leaves on one side is mirrored."""
    turn = place - 2.0 * span * math.floor(place / (2.0 * span))
    return min(turn, 2.0 * span - turn)


@inner(fastmath={"contract"})
def _look_up(heights: Any, score: Any, column: int) -> Any:
    last = heights.shape[0] - 1
    scaled = (score + np.float32(MAX_SCORE)) * np.float32(last / (2.0 * MAX_SCORE))
    position = min(max(scaled, np.float32(0.0)), np.float32(last - 1e-3))
    k = int(position)
    low = heights[k, column]
    return low + (position - np.float32(k)) * (heights[k + 1, column] - low)
