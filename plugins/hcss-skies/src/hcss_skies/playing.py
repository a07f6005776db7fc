"""Patches of films side by side on a triangular lattice: clouds of neighbours meet without ghosts.

Each lattice point plays a piece of a film from a place of its own, fades into another one at its end, and goes on so. A
cell takes the largest of the scores of the patches around it, each with the logarithm of its weight added; weights sum
to 1. Gumbel's distribution is stable under this (max-stability; S. Coles, An Introduction to Statistical Modeling of
Extreme Values, Springer 2001, section 3.1.3), so that cover and thickness keep their distribution, clouds of all
patches stay as sharp as they are, and shrink towards the edge of their patch. A sum of scores, as for images of many
clouds (``blending.py``), would show pale doubles of single ones. In sheets, holes are what is rare: there the smallest
score less the logarithm counts.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from hcss_skies.hashing import hashed, uniform
from hcss_twin.core.kernels import kernel

_SKEW = 2.0 / math.sqrt(3.0)

_LEAST = 1e-3
"""Weight below which a patch that fades is left out."""

_LOST = -160.0
"""Loss in ranks with which a patch is left out: its thickest cell in a thousand would be as thick as the thinnest."""

_STEPS = 4096
"""Steps of a table of logarithms: of .1 rank where a patch has a fifth of the weight."""


_OF_CLEAR = 1e-3
"""Weight of cells without cloud beside others in fields that belong to cloud."""


@kernel(fastmath={"contract"}, error_model="numpy")
def play(
    out: Any, beside: Any, needed: Any, row: int, column: int, frames: Any, others: Any, usual: Any, scores: Any,
    spacing: float, shift: Any, sheet: bool, key: Any, age: float, lasting: Any,
) -> None:  # fmt: skip
    """Write ranks (rows, columns) of cells from ``row`` and ``column`` on, and what belongs to them.

    Parameters
    ----------
    out : ndarray of float32 (rows, columns)
        Ranks, 0 to 255, with fractions.
    beside : ndarray of float32 (F, rows, columns)
        Other fields of the patch that a cell shows; F may be 0.
    needed : ndarray of int64 (2, rows)
        First column of each row that is written, and the one after the last.
    row, column : int
        First cell, in the unbounded sky.
    frames : ndarray of uint8 (pieces, frames, rows, columns)
        Ranks of a film.
    others : ndarray of uint8 (F, pieces, frames, rows, columns)
        Its other fields.
    usual : ndarray of float32 (F, 256)
        Their usual values at ranks: what a patch shows of a lower rank than it has, has values in proportion.
    scores : ndarray of float64 (2,)
        Scores of ranks 0 and 255.
    spacing : float
        Distance of lattice points in cells.
    shift : ndarray of float64 (2,)
        Of the lattice along y and x in cells.
    sheet : bool
        Whether scores are those of sheets.
    key : uint64
        Of the random numbers.
    age : float
        Time in lifetimes of a patch; NaN: clouds do not change.
    lasting : ndarray of float64 (2,)
        Frames that a piece has, and frames after which the next one begins to replace it.
    """
    rows, columns = out.shape
    per_score = 255.0 / (scores[1] - scores[0])
    low_v = np.int64(math.floor((row + shift[0]) / spacing * _SKEW))
    high_v = np.int64(math.floor((row + rows + shift[0]) / spacing * _SKEW)) + 2
    low_u = np.int64(math.floor((column + shift[1]) / spacing - 0.5 * (high_v + 1))) - 1
    high_u = np.int64(math.floor((column + columns + shift[1]) / spacing - 0.5 * low_v)) + 3
    # Two patches of each point: piece, frame, place along y and x; their loss of score, and the fraction of a frame.
    which = np.empty((high_v - low_v, high_u - low_u, 2, 4), np.int64)
    parts = np.empty((high_v - low_v, high_u - low_u, 2, 2), np.float32)
    for p in range(which.shape[0]):
        for q in range(which.shape[1]):
            _choose(which[p, q], parts[p, q], low_u + q, low_v + p, frames.shape, key, age, lasting)
            for turn in range(2):
                weight = float(parts[p, q, turn, 0])
                parts[p, q, turn, 0] = math.log(weight) * per_score if weight > _LEAST else 2.0 * _LOST
    logarithm = np.empty(_STEPS + 1, np.float32)
    for n in range(_STEPS + 1):
        logarithm[n] = math.log((n + 0.5) / _STEPS) * per_score
    lost, last = np.float32(_LOST), np.float32(255.0)
    four, steps, tall, wide = np.float32(4.0), np.float32(_STEPS), frames.shape[2], frames.shape[3]
    inverse = 1.0 / spacing
    triangle, losses = np.empty(columns, np.int64), np.empty((3, columns), np.float32)
    best, own, shown = np.empty(columns, np.float32), np.empty(columns, np.float32), np.empty(columns, np.int64)
    for i in range(rows):
        y = (row + i + shift[0]) / spacing * _SKEW
        v = np.int64(math.floor(y))
        fv = y - v
        low, high = needed[0, i], needed[1, i]
        for j in range(low, high):
            x = (column + j + shift[1]) * inverse - 0.5 * y
            u = np.int64(math.floor(x))
            fu = x - u
            far = fu + fv > 1.0
            triangle[j] = 2 * (u - low_u) + (1 if far else 0)
            w0 = np.float32(abs(1.0 - fu - fv))
            w1, w2 = np.float32(1.0 - fv if far else fu), np.float32(1.0 - fu if far else fv)
            # the fourth power: a cell sees mostly one patch
            loss = logarithm[np.int64((w0 * w0 * w0 * w0 + w1 * w1 * w1 * w1 + w2 * w2 * w2 * w2) * steps)]
            losses[0, j] = four * logarithm[np.int64(w0 * steps)] - loss
            losses[1, j] = four * logarithm[np.int64(w1 * steps)] - loss
            losses[2, j] = four * logarithm[np.int64(w2 * steps)] - loss
            best[j], own[j], shown[j] = np.float32(-1e30), np.float32(0.0), 0
        start = low
        while start < high:  # cells between the same three points
            end, far = start + 1, triangle[start] % 2
            while end < high and triangle[end] == triangle[start]:
                end += 1
            for corner in range(3):
                line = v - low_v + (far if corner == 0 else corner - 1)
                place = triangle[start] // 2 + (far if corner == 0 else 2 - corner)
                for turn in range(2):
                    less, part = parts[line, place, turn, 0], parts[line, place, turn, 1]
                    if less < lost:
                        continue
                    patch = which[line, place, turn]
                    k, number = (row + i + patch[2]) % tall, 2 * (line * which.shape[1] + place) + turn
                    before, after = frames[patch[0], patch[1], k], frames[patch[0], patch[1] + 1, k]
                    j = start
                    while j < end:  # up to the end of the box
                        m = (column + j + patch[3]) % wide
                        stop = min(end, j + wide - m)
                        _take(best, own, shown, losses[corner], less, part, number, before, after, j, stop, m, sheet)
                        j = stop
            start = end
        for j in range(low, high):
            rank = min(max(best[j], np.float32(0.0)), last)
            out[i, j] = last - rank if sheet else rank
        if beside.shape[0] > 0:
            for j in range(low, high):
                point = shown[j] // 2
                line, place, turn = point // which.shape[1], point % which.shape[1], shown[j] % 2
                patch, part = which[line, place, turn], parts[line, place, turn, 1]
                k, m = (row + i + patch[2]) % tall, (column + j + patch[3]) % wide
                for n in range(beside.shape[0]):
                    first = np.float32(others[n, patch[0], patch[1], k, m])
                    second = np.float32(others[n, patch[0], patch[1] + 1, k, m])
                    value = first + part * (second - first)
                    beside[n, i, j] = value * usual[n, np.int64(out[i, j])] / usual[n, np.int64(own[j])]


@kernel(inner=True, fastmath={"contract"}, error_model="numpy")
def _take(
    best: Any, own: Any, shown: Any, losses: Any, less: Any, part: Any, number: int, before: Any, after: Any,
    start: int, stop: int, place: int, sheet: bool,
) -> None:  # fmt: skip
    """Let the cells of a row from ``start`` to ``stop`` show a patch where its score is the largest so far."""
    last, lost, shift = np.float32(255.0), np.float32(_LOST), place - start
    for j in range(start, stop):
        share = losses[j] + less
        first = np.float32(before[j + shift])
        rank = first + part * (np.float32(after[j + shift]) - first)
        value = share + (last - rank if sheet else rank)
        better = value > best[j] and share >= lost
        best[j] = value if better else best[j]
        own[j] = rank if better else own[j]
        shown[j] = number if better else shown[j]


@kernel(fastmath={"contract"}, error_model="numpy")
def show(out: Any, ranks: Any, y: Any, y_turned: Any, x: Any, x_turned: Any, row: int, column: int, table: Any) -> None:
    """Write values of a table (256,) at ranks between the middles of cells, bilinear.

    Parameters
    ----------
    out : ndarray of float32 (Y, X)
        The result.
    ranks : ndarray of float32 (rows, columns)
        Of cells from ``row`` and ``column`` on.
    y, y_turned, x, x_turned : ndarray of float64
        Where the pixels are: see :class:`hcss_skies.pace.Places`.
    row, column : int
        First cell.
    table : ndarray of float32 (256,)
        Values at ranks.
    """
    place, past = np.empty((2, x.size), np.int64), np.empty((2, x.size), np.float32)
    for i in range(y.size):
        # a loop of its own, which is vectorised
        for j in range(x.size):
            at_y, at_x = y[i] - x_turned[j], x[j] + y_turned[i]
            low_y, low_x = math.floor(at_y), math.floor(at_x)
            past[0, j], past[1, j] = at_y - low_y, at_x - low_x
            place[0, j], place[1, j] = np.int64(low_y) - row, np.int64(low_x) - column
        for j in range(x.size):
            (k, m), (fy, fx) = (place[0, j], place[1, j]), (past[0, j], past[1, j])
            low = ranks[k, m] + fx * (ranks[k, m + 1] - ranks[k, m])
            high = ranks[k + 1, m] + fx * (ranks[k + 1, m + 1] - ranks[k + 1, m])
            rank = low + fy * (high - low)
            n: Any = np.int64(rank)
            n = min(n, 254)
            out[i, j] = table[n] + (rank - np.float32(n)) * (table[n + 1] - table[n])


@kernel(fastmath={"contract"}, error_model="numpy")
def show_beside(
    out: Any, cells: Any, ranks: Any, cloudy: float, y: Any, y_turned: Any, x: Any, x_turned: Any, row: int, column: int
) -> None:
    """Write another field of cells between their middles: bilinear among cells with cloud, as far as there are any.

    Parameters
    ----------
    out : ndarray of float32 (Y, X)
        The result.
    cells, ranks : ndarray of float32 (rows, columns)
        Of cells from ``row`` and ``column`` on.
    cloudy : float
        Rank above which a cell has cloud.
    y, y_turned, x, x_turned : ndarray of float64
        Where the pixels are: see :class:`hcss_skies.pace.Places`.
    row, column : int
        First cell.
    """
    clear, one = np.float32(_OF_CLEAR), np.float32(1.0)
    for i in range(y.size):
        for j in range(x.size):
            at_y, at_x = y[i] - x_turned[j], x[j] + y_turned[i]
            low_y, low_x = math.floor(at_y), math.floor(at_x)
            k, fy = np.int64(low_y) - row, np.float32(at_y - low_y)
            m, fx = np.int64(low_x) - column, np.float32(at_x - low_x)
            total = value = np.float32(0.0)
            for down in range(2):
                share = fy if down else one - fy
                for right in range(2):
                    part = share * (fx if right else one - fx)
                    part *= one if ranks[k + down, m + right] > cloudy else clear
                    total += part
                    value += part * cells[k + down, m + right]
            out[i, j] = value / total


@kernel(inner=True)
def _choose(which: Any, parts: Any, u: int, v: int, shape: Any, key: Any, age: float, lasting: Any) -> None:
    """Write what the two patches of a lattice point play, and their weights, which sum to 1."""
    first = hashed(hashed(key, u), v)
    moment, number = uniform(first), np.int64(0)
    if not math.isnan(age):
        moment += age
        number = np.int64(math.floor(moment))
    played = (moment - number) * lasting[1]
    for turn in range(2):
        random = hashed(first, number - turn)
        which[turn, 0] = np.int64(uniform(hashed(random, np.int64(1))) * shape[0])
        which[turn, 2] = np.int64(uniform(hashed(random, np.int64(2))) * shape[2])
        which[turn, 3] = np.int64(uniform(hashed(random, np.int64(3))) * shape[3])
        at = min(played + turn * lasting[1], shape[1] - 1.001)
        which[turn, 1] = np.int64(at)
        parts[turn, 1] = at - which[turn, 1]
    phase = 1.0 if math.isnan(age) else min(played / (lasting[0] - lasting[1]), 1.0)
    parts[0, 0] = phase * phase * (3.0 - 2.0 * phase)
    parts[1, 0] = 1.0 - parts[0, 0]
