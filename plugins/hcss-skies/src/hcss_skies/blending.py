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
from hcss_twin.core.kernels import kernel

_SKEW = 2.0 / math.sqrt(3.0)

_SLOWEST = 0.4
"""Least denominator of a speed. With .06, waves of 64 to 96 km change as measured, but a second changes .017 K rms."""

CUT = 0.15
"""Weights below this limit are cut off, smoothly: three in ten samples are then not taken, and contrast is kept."""


@kernel(fastmath={"contract"})
def blend(
    out: Any, y: Any, x: Any, scores: Any, heights: Any, geometry: Any, flow: Any, bounds: Any, waves: Any, key: int,
    epoch: float,
) -> None:  # fmt: skip
    """Write p and x (rows, columns, 2), or p alone (rows, columns, 1), in m at positions in pixels of the example.

    Parameters
    ----------
    out : ndarray of float32 (rows, columns, fields)
        The result.
    y, x : ndarray of float64 (rows,), (columns,)
        Positions.
    scores, heights : ndarray
        Of a :class:`~hcss_skies.pyramid.Level`.
    geometry : ndarray (10,)
        Lattice spacing; smallest y and x and range along y and x of centres of patches; scale of the level; y and x
        of the lattice; scale of the displacement of a patch in its lifetime; part of the long waves in the score of x.
    flow : ndarray of float32 (octaves, node rows, node columns)
        Stream function at nodes; its slope per node distance is the displacement in pixels of the example.
    bounds : ndarray (octaves + 1, 3)
        Distance of nodes in pixels of the example, and index of the first row and column; the last are those of
        ``waves``.
    waves : ndarray of float32 (node rows, node columns)
        Waves longer than patches, in parts of the score of p.
    key : int
        Of the random numbers.
    epoch : float
        Time in lifetimes of a patch; NaN: patches do not change.
    """
    columns = x.size
    at_y, at_x = np.empty(columns), np.empty(columns)
    octaves = flow.shape[0]
    interval, past = np.empty((octaves + 1, columns), np.uint64), np.empty((octaves + 1, columns))
    for octave in range(octaves + 1):
        for j in range(columns):
            position = x[j] / bounds[octave, 0]
            whole = math.floor(position)
            interval[octave, j], past[octave, j] = np.uint64(whole - bounds[octave, 2] - 1.0), position - whole
    curves = np.empty((octaves, max(flow.shape[2] - 3, 1), 7))
    # Patches of all lattice points that positions can reach, two for each: displacement in samples, weight.
    moved = _farthest(flow)
    low_v = np.int64(math.floor((y[0] + geometry[6] - moved) / geometry[0] * _SKEW))
    high_v = np.int64(math.floor((y[-1] + geometry[6] + moved) / geometry[0] * _SKEW)) + 2
    left, right = (x[0] + geometry[7] - moved) / geometry[0], (x[-1] + geometry[7] + moved) / geometry[0]
    # In row v of the lattice, the first point is number low - v // 2.
    low = np.int64(math.floor(left)) - 1
    wide = np.int64(right - left + 5.0)
    places, fades = np.empty(((high_v - low_v) * wide, 2, 2)), np.empty(((high_v - low_v) * wide, 2), np.float32)
    for v in range(low_v, high_v):
        for n in range(wide):
            k = (v - low_v) * wide + n
            _choose(places[k], fades[k], low - (v >> 1) + n, v, geometry, key, epoch)
    corners, points = np.empty((3, columns), np.float32), np.empty((3, columns), np.int32)
    fields = out.shape[2]
    total, square = np.empty((fields, columns), np.float32), np.empty(columns, np.float32)
    long = np.empty(columns, np.float32)
    to_samples = 2.0 / geometry[5]
    for i in range(y.size):
        displaced(at_y, at_x, y[i], x, geometry[6], geometry[7], flow, bounds, interval, past, curves)
        _raised(long, y[i], waves, bounds[octaves], interval[octaves], past[octaves])
        _weights(corners, points, at_y, at_x, 1.0 / geometry[0], low_v, low, wide)
        _sample(total, square, scores, corners, points, at_y, at_x, fades, places, to_samples)
        for field in range(fields):
            part = np.float32(geometry[9] if field else 1.0)
            _look_up(out[i], field, heights, total[field], square, part, long)


@kernel(inner=True, fastmath={"contract"})
def _weights(
    corners: Any, points: Any, at_y: Any, at_x: Any, per_spacing: float, low_v: int, low: int, wide: int
) -> None:
    """Write the weights of the corners of each pixel's triangle (3, columns), and their numbers in the lattice."""
    one, cut, zero = np.float32(1.0), np.float32(CUT), np.float32(0.0)
    for j in range(at_y.size):
        v = at_y[j] * (per_spacing * _SKEW)
        u = at_x[j] * per_spacing - 0.5 * v
        floor_u, floor_v = math.floor(u), math.floor(v)
        fu, fv = np.float32(u - floor_u), np.float32(v - floor_v)
        high = fu + fv >= one
        own_u, own_v = np.int64(floor_u), np.int64(floor_v)
        nearest = (own_v - low_v) * wide + own_u - low + (own_v >> 1)
        above = nearest + wide + (own_v + 1 >> 1) - (own_v >> 1)
        points[0, j], points[1, j], points[2, j] = above + 1 if high else nearest, nearest + 1, above
        w0 = abs(one - fu - fv)
        w1, w2 = (one - fv, one - fu) if high else (fu, fv)
        w0, w1, w2 = max(w0 - cut, zero), max(w1 - cut, zero), max(w2 - cut, zero)
        corners[0, j], corners[1, j], corners[2, j] = w0 * w0, w1 * w1, w2 * w2


@kernel(inner=True, fastmath={"contract"})
def _sample(
    total: Any, square: Any, scores: Any, corners: Any, points: Any, at_y: Any, at_x: Any, fades: Any, places: Any,
    to_samples: float,
) -> None:  # fmt: skip
    """Write the sums of patches at pixels of a row, and of squared weights: bilinear in the level."""
    last_row, last_column = scores.shape[0] - 1.001, scores.shape[1] - 1.001
    zero, one, joint = np.float32(0.0), np.uint64(1), total.shape[0] == 2
    for j in range(square.size):
        opaque = excess = squares = zero
        y, x = to_samples * at_y[j], to_samples * at_x[j]
        for n in range(3):
            if corners[n, j] > zero:
                point = np.uint64(points[n, j])
                for turn in range(2):
                    share = corners[n, j] * fades[point, turn]
                    if share > zero:
                        row = min(max(y + places[point, turn, 0], 0.0), last_row)
                        column = min(max(x + places[point, turn, 1], 0.0), last_column)
                        whole_y, whole_x = np.int32(row), np.int32(column)
                        fy, fx = np.float32(row - whole_y), np.float32(column - whole_x)
                        # Unsigned indices need no test whether they count from the end.
                        k, m = np.uint64(whole_y), np.uint64(whole_x)
                        below, beside = k + one, m + one
                        squares += share * share
                        a = scores[k, m, 0] + fx * (scores[k, beside, 0] - scores[k, m, 0])
                        b = scores[below, m, 0] + fx * (scores[below, beside, 0] - scores[below, m, 0])
                        opaque += share * (a + fy * (b - a))
                        if joint:
                            a = scores[k, m, 1] + fx * (scores[k, beside, 1] - scores[k, m, 1])
                            b = scores[below, m, 1] + fx * (scores[below, beside, 1] - scores[below, m, 1])
                            excess += share * (a + fy * (b - a))
        total[0, j], square[j] = opaque, squares
        if joint:
            total[1, j] = excess


@kernel(inner=True)
def _farthest(flow: Any) -> float:
    """Return a displacement along an axis that no position exceeds: splines do not exceed the slopes of their nodes."""
    total = 0.0
    for octave in range(flow.shape[0]):
        steepest = 0.0
        for i in range(flow.shape[1]):
            for j in range(flow.shape[2]):
                if i:
                    steepest = max(steepest, abs(float(flow[octave, i, j]) - float(flow[octave, i - 1, j])))
                if j:
                    steepest = max(steepest, abs(float(flow[octave, i, j]) - float(flow[octave, i, j - 1])))
        total += steepest
    return total + 1e-3


@kernel(inner=True, fastmath={"contract"})
def displaced(
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


@kernel(inner=True, fastmath={"contract"})
def _raised(out: Any, y: float, nodes: Any, bounds: Any, interval: Any, past: Any) -> None:
    """Write a cubic B-spline surface along a row."""
    spline, line = np.empty(8), np.empty(nodes.shape[1])
    position = y / bounds[0]
    row = np.int64(math.floor(position) - bounds[1]) - 1
    _spline(position - math.floor(position), spline)
    for k in range(line.size):
        line[k] = 0.0
        for n in range(4):
            line[k] += spline[n] * nodes[row + n, k]
    last, one, two, three = np.uint64(line.size), np.uint64(1), np.uint64(2), np.uint64(3)
    c0 = c1 = c2 = c3 = 0.0
    for j in range(out.size):
        k, f = interval[j], past[j]
        if k != last:
            last = k
            c0 = (line[k] + 4.0 * line[k + one] + line[k + two]) / 6.0
            c1 = 0.5 * (line[k + two] - line[k])
            c2 = 0.5 * (line[k] + line[k + two]) - line[k + one]
            c3 = (line[k + three] - line[k]) / 6.0 + 0.5 * (line[k + one] - line[k + two])
        out[j] = c0 + f * (c1 + f * (c2 + f * c3))


@kernel(inner=True, fastmath={"contract"})
def _spline(f: float, out: Any) -> None:
    """Write the weights (0 to 3) of a cubic B-spline and those of its slope (4 to 7), a fraction past the second."""
    g = 1.0 - f
    out[0], out[3] = g * g * g / 6.0, f * f * f / 6.0
    out[1], out[2] = 2.0 / 3.0 - f * f + 0.5 * f * f * f, 2.0 / 3.0 - g * g + 0.5 * g * g * g
    out[4], out[7] = -0.5 * g * g, 0.5 * f * f
    out[5], out[6] = 1.5 * f * f - 2.0 * f, 2.0 * g - 1.5 * g * g


@kernel(inner=True)
def _choose(patch_position: Any, fade: Any, u: int, v: int, geometry: Any, key: int, epoch: float) -> None:
    """Write the displacement in samples (turn, y and x) and the weight (turn,) of the patches of a lattice point."""
    spacing, to_samples = geometry[0], 2.0 / geometry[5]
    first = hashed(hashed(np.uint64(key), u), v)
    number, age, share = np.int64(0), 0.0, 0.0
    if not math.isnan(epoch):
        age = epoch + uniform(first)
        number = np.int64(math.floor(age))
        # A patch is alone for three quarters of the time and fades in the rest.
        phase = min(max(4.0 * (age - number) - 1.5, 0.0), 1.0)
        share = phase * phase * (3.0 - 2.0 * phase)
    for turn in range(2):
        fade[turn] = 0.0
        if share == 1.0 - turn:
            continue
        random = hashed(first, number + turn)
        # The squares of the weights of the old and the new patch sum to 1.
        fade[turn] = math.sin(0.5 * math.pi * share) if turn else math.cos(0.5 * math.pi * share)
        drift = 0.0
        if not math.isnan(epoch):  # from the middle of the life; a ratio of normal numbers
            slow = abs(normal(hashed(random, np.int64(2))))
            drift = geometry[8] * (age - number - turn) / max(slow, _SLOWEST)
        towards_y, towards_x = normal(hashed(random, np.int64(3))), normal(hashed(random, np.int64(4)))
        centre_y = geometry[3] * uniform(random) + drift * towards_y
        centre_x = geometry[4] * uniform(hashed(random, np.int64(1))) + drift * towards_x
        patch_position[turn, 0] = (
            to_samples * (geometry[1] + _within(centre_y, geometry[3]) - v * spacing / _SKEW) - 0.5
        )
        patch_position[turn, 1] = (
            to_samples * (geometry[2] + _within(centre_x, geometry[4]) - (u + 0.5 * v) * spacing) - 0.5
        )


@kernel(inner=True)
def _within(position: float, span: float) -> float:
    """Return a place between 0 and the span: what leaves on one side is mirrored."""
    turn = position - 2.0 * span * math.floor(position / (2.0 * span))
    return min(turn, 2.0 * span - turn)


@kernel(inner=True, fastmath={"contract"})
def _look_up(out: Any, field: int, heights: Any, total: Any, square: Any, part: Any, long: Any) -> None:
    """Write heights (columns, fields) of the sums of scores with the variance 1, and part of the long waves."""
    last = heights.shape[0] - 1
    lowest, scale = np.float32(MAX_SCORE), np.float32(last / (2.0 * MAX_SCORE))
    zero, end, one = np.float32(0.0), np.float32(last - 1e-3), np.uint64(1)
    for j in range(square.size):
        score = total[j] / np.sqrt(square[j]) + part * long[j]
        total[j] = min(max((score + lowest) * scale, zero), end)
    for j in range(square.size):
        whole = np.int32(total[j])
        k = np.uint64(whole)
        low = heights[k, field]
        out[j, field] = low + (total[j] - np.float32(whole)) * (heights[k + one, field] - low)


@kernel()
def put_in_layer(thickness: Any, least: Any, most: Any) -> None:
    """Replace thickness (rows, columns) below the least one of the layer by it or by 0, and limit it to the largest."""
    half = np.float32(0.5) * least
    for i in range(thickness.shape[0]):
        for j in range(thickness.shape[1]):
            cloud_m = thickness[i, j]
            thickness[i, j] = (
                np.float32(0.0) if cloud_m < half else min(max(cloud_m, least if cloud_m > 0.0 else cloud_m), most)
            )
