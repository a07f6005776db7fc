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
    at_y, at_x = np.empty(x.size), np.empty(x.size)
    octaves = flow.shape[0]
    interval, past = np.empty((octaves + 1, x.size), np.uint64), np.empty((octaves + 1, x.size))
    for octave in range(octaves + 1):
        for j in range(x.size):
            position = x[j] / bounds[octave, 0]
            whole = math.floor(position)
            interval[octave, j], past[octave, j] = np.uint64(whole - bounds[octave, 2] - 1.0), position - whole
    curves = np.empty((octaves, max(flow.shape[2] - 3, 1), 7))
    # Patches of all lattice points that positions can reach, two for each: displacement in samples, weight.
    moved = _farthest(flow)
    low_v = np.int64(math.floor((y[0] + geometry[6] - moved) / geometry[0] * _SKEW))
    high_v = np.int64(math.floor((y[-1] + geometry[6] + moved) / geometry[0] * _SKEW)) + 2
    left, right = (x[0] + geometry[7] - moved) / geometry[0], (x[-1] + geometry[7] + moved) / geometry[0]
    places = np.empty((high_v - low_v, np.int64(right - left + 4.0), 2, 2))
    fades = np.empty((high_v - low_v, places.shape[1], 2), np.float32)
    for v in range(low_v, high_v):
        low_u = np.int64(math.floor(left - 0.5 * (v + 1)))
        for u in range(low_u, low_u + places.shape[1]):
            _choose(places[v - low_v, u - low_u], fades[v - low_v, u - low_u], u, v, geometry, key, epoch)
    corners = np.empty((3, x.size), np.float32)
    cell = np.empty((2, x.size), np.int64)
    upper = np.empty(x.size, np.bool_)
    total, square = np.empty((2, x.size), np.float32), np.empty(x.size, np.float32)
    joint = out.shape[2] == 2
    long = np.empty(x.size, np.float32)
    to_samples = 2.0 / geometry[5]
    for i in range(y.size):
        _displaced(at_y, at_x, y[i], x, geometry[6], geometry[7], flow, bounds, interval, past, curves)
        _raised(long, y[i], waves, bounds[octaves], interval[octaves], past[octaves])
        _weights(corners, cell, upper, at_y, at_x, 1.0 / geometry[0])
        total[:] = np.float32(0.0)
        square[:] = np.float32(0.0)
        begin = 0
        while begin < x.size:  # the pixels of one triangle
            u, v, high = cell[0, begin], cell[1, begin], upper[begin]
            end = begin + 1
            while end < x.size and cell[0, end] == u and cell[1, end] == v and upper[end] == high:
                end += 1
            # Positions are counted from the triangle, where single precision has room for fractions of samples.
            from_y, from_x = v * geometry[0] / _SKEW, (u + 0.5 * v) * geometry[0]
            for n in range(3):
                own_u, own_v = u + (n == 1), v + (n == 2)
                if high:
                    own_u, own_v = u + (n != 2), v + (n != 1)
                row = own_v - low_v
                column = own_u - np.int64(math.floor(left - 0.5 * (own_v + 1)))
                for turn in range(2):
                    if fades[row, column, turn] > 0.0:
                        _sample(
                            total[0, begin:end], total[1, begin:end], square[begin:end], joint, scores,
                            at_y[begin:end], at_x[begin:end], corners[n, begin:end], fades[row, column, turn],
                            from_y, from_x, to_samples, places[row, column, turn, 0] + to_samples * from_y - 0.5,
                            places[row, column, turn, 1] + to_samples * from_x - 0.5,
                        )  # fmt: skip
            begin = end
        for field in range(out.shape[2]):
            part = np.float32(geometry[9] if field else 1.0)
            for j in range(x.size):
                out[i, j, field] = _look_up(heights, total[field, j] / np.sqrt(square[j]) + part * long[j], field)


@inner(fastmath={"contract"})
def _weights(corners: Any, cell: Any, upper: Any, at_y: Any, at_x: Any, per_spacing: float) -> None:
    """Write the weights of the corners of each pixel's triangle (3, columns), and which triangle it is."""
    one, cut, zero = np.float32(1.0), np.float32(CUT), np.float32(0.0)
    for j in range(at_y.size):
        v = at_y[j] * (per_spacing * _SKEW)
        u = at_x[j] * per_spacing - 0.5 * v
        floor_u, floor_v = math.floor(u), math.floor(v)
        cell[0, j], cell[1, j] = np.int64(floor_u), np.int64(floor_v)
        fu, fv = np.float32(u - floor_u), np.float32(v - floor_v)
        high = fu + fv >= one
        upper[j] = high
        w0, w1, w2 = one - fu - fv, fu, fv
        if high:
            w0, w1, w2 = -w0, one - fv, one - fu
        w0, w1, w2 = max(w0 - cut, zero), max(w1 - cut, zero), max(w2 - cut, zero)
        corners[0, j], corners[1, j], corners[2, j] = w0 * w0, w1 * w1, w2 * w2


@inner(fastmath={"contract"})
def _sample(
    opaque: Any,
    excess: Any,
    square: Any,
    joint: bool,
    scores: Any,
    at_y: Any,
    at_x: Any,
    weight: Any,
    fade: Any,
    from_y: float,
    from_x: float,
    to_samples: float,
    place_y: float,
    place_x: float,
) -> None:
    """Add a patch to pixels of a row: bilinear between quarters of pixels of the level."""
    last_row, last_column = np.float32(scores.shape[0] - 1.001), np.float32(scores.shape[1] - 1.001)
    first_y, first_x, zero = np.float32(place_y), np.float32(place_x), np.float32(0.0)
    one = np.uint64(1)
    for j in range(weight.size):
        share = weight[j] * fade
        if share > zero:
            row = min(max(np.float32(to_samples * (at_y[j] - from_y)) + first_y, zero), last_row)
            column = min(max(np.float32(to_samples * (at_x[j] - from_x)) + first_x, zero), last_column)
            whole_y, whole_x = np.int32(row), np.int32(column)
            fy, fx = row - np.float32(whole_y), column - np.float32(whole_x)
            # Unsigned indices need no test whether they count from the end.
            k, m = np.uint64(whole_y), np.uint64(whole_x)
            below, beside = k + one, m + one
            square[j] += share * share
            a = scores[k, m, 0] + fx * (scores[k, beside, 0] - scores[k, m, 0])
            b = scores[below, m, 0] + fx * (scores[below, beside, 0] - scores[below, m, 0])
            opaque[j] += share * (a + fy * (b - a))
            if joint:
                a = scores[k, m, 1] + fx * (scores[k, beside, 1] - scores[k, m, 1])
                b = scores[below, m, 1] + fx * (scores[below, beside, 1] - scores[below, m, 1])
                excess[j] += share * (a + fy * (b - a))


@inner()
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


@inner(fastmath={"contract"})
def _spline(f: float, out: Any) -> None:
    """Write the weights (0 to 3) of a cubic B-spline and those of its slope (4 to 7), a fraction past the second."""
    g = 1.0 - f
    out[0], out[3] = g * g * g / 6.0, f * f * f / 6.0
    out[1], out[2] = 2.0 / 3.0 - f * f + 0.5 * f * f * f, 2.0 / 3.0 - g * g + 0.5 * g * g * g
    out[4], out[7] = -0.5 * g * g, 0.5 * f * f
    out[5], out[6] = 1.5 * f * f - 2.0 * f, 2.0 * g - 1.5 * g * g


@inner()
def _choose(place: Any, fade: Any, u: int, v: int, geometry: Any, key: int, epoch: float) -> None:
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
        place[turn, 0] = to_samples * (geometry[1] + _within(centre_y, geometry[3]) - v * spacing / _SKEW)
        place[turn, 1] = to_samples * (geometry[2] + _within(centre_x, geometry[4]) - (u + 0.5 * v) * spacing)


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
    whole = np.int32(position)
    k = np.uint64(whole)
    low = heights[k, column]
    return low + (position - np.float32(whole)) * (heights[k + np.uint64(1), column] - low)


@kernel()
def put_in_layer(thickness: Any, least: Any, most: Any) -> None:
    """Replace thickness (rows, columns) below the least one of the layer by it or by 0, and limit it to the largest."""
    half = np.float32(0.5) * least
    for i in range(thickness.shape[0]):
        for j in range(thickness.shape[1]):
            own = thickness[i, j]
            thickness[i, j] = np.float32(0.0) if own < half else min(max(own, least if own > 0.0 else own), most)
