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

_OUTSIDE = 1e-4
"""Weight of a patch where it is lost."""

_AT_ONCE = 32
"""Neighbours of a row that are looked at together; those beyond the ends of a patch get nothing from it."""

_OF_CLEAR = 1e-3
"""Weight of cells without cloud beside others in fields that belong to cloud."""


@kernel(fastmath={"contract"}, error_model="numpy")
def play(
    out: Any, beside: Any, row: int, column: int, frames: Any, others: Any, usual: Any, scores: Any, spacing: float,
    shift: Any, sheet: bool, key: Any, age: float, lasting: Any,
) -> None:  # fmt: skip
    """Write ranks (rows, columns) of cells from ``row`` and ``column`` on, and what belongs to them.

    Parameters
    ----------
    out : ndarray of float32 (rows, columns)
        Ranks, 0 to 255, with fractions.
    beside : ndarray of float32 (F, rows, columns)
        Other fields of the patch that a cell shows; F may be 0.
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
    lost, last, tall, wide = np.float32(_LOST), np.float32(255.0), frames.shape[2], frames.shape[3]
    inverse, padded = 1.0 / spacing, columns + _AT_ONCE
    # Of the cells of a row: points of the lattice before them and places after these, the same in any window, and what
    # all patches lose there.
    point, past, common = np.empty(padded, np.float32), np.empty(padded, np.float32), np.empty(padded, np.float32)
    best, own, shown = np.empty(padded, np.float32), np.empty(padded, np.float32), np.empty(padded, np.uint32)
    share, per_log = np.empty(padded, np.float32), np.float32(per_score * math.log(2.0))
    of_points, parts_of_points = which.reshape((-1, 2, 4)), parts.reshape((-1, 2, 2))
    now, then = np.empty(padded, np.uint8), np.empty(padded, np.uint8)
    for i in range(rows):
        y = (row + i + shift[0]) / spacing * _SKEW
        v = np.int64(math.floor(y))
        fv = y - v
        for j in range(padded):
            x = (column + j + shift[1]) * inverse - 0.5 * y
            whole = math.floor(x)
            point[j], past[j] = whole - low_u, x - whole
        _share(common, past, np.float32(fv), per_log)
        first = point[0] + past[0]
        best[:], own[:], shown[:] = np.float32(-1e30), np.float32(0.0), np.uint32(0)
        for upper in range(2):
            # The weight of a point rises from its left end to its share of the row, and falls to its right end.
            left, right, most = (-fv, 1.0, fv) if upper else (-1.0, 1.0 - fv, 1.0 - fv)
            line = v - low_v + upper
            for place in range(which.shape[1]):
                start = max(0, np.int64(math.ceil((place + left - first) * spacing)))
                end = min(columns, np.int64(math.floor((place + right - first) * spacing)) + 1)
                if start >= end:
                    continue
                ends = np.float32(place), np.float32(left), np.float32(right), np.float32(most)
                for turn in range(2):
                    less, part = parts[line, place, turn, 0], parts[line, place, turn, 1]
                    if less < lost:
                        continue
                    patch = which[line, place, turn]
                    k, own_number = (row + i + patch[2]) % tall, np.uint32(2 * (line * which.shape[1] + place) + turn)
                    before, after = frames[patch[0], patch[1], k], frames[patch[0], patch[1] + 1, k]
                    stop = start + (end - start + _AT_ONCE - 1) // _AT_ONCE * _AT_ONCE
                    cells = slice(start, stop)
                    _lose(share[cells], point[cells], past[cells], common[cells], ends, less, per_log)
                    cell: Any = start
                    while cell < stop:  # up to the end of the box
                        place_in_box = (column + cell + patch[3]) % wide
                        count = min(stop - cell, wide - place_in_box)
                        here, there = slice(cell, cell + count), slice(place_in_box, place_in_box + count)
                        _copy(now[here], before[there])
                        _copy(then[here], after[there])
                        cell += count
                    if beside.shape[0] > 0:
                        of_patch = part, own_number, sheet
                        _show(own[cells], shown[cells], best[cells], share[cells], now[cells], then[cells], of_patch)
                    _take(best[cells], share[cells], now[cells], then[cells], part, sheet)
        for j in range(columns):
            top: Any = min(max(best[j], np.float32(0.0)), last)
            out[i, j] = last - top if sheet else top
        if beside.shape[0] > 0:
            for j in range(columns):
                number, second = np.int64(shown[j]) // 2, np.int64(shown[j]) % 2
                patch, part = of_points[number, second], parts_of_points[number, second, 1]
                k, m = (row + i + patch[2]) % tall, (column + j + patch[3]) % wide
                for n in range(beside.shape[0]):
                    value = _between(others[n, patch[0], patch[1], k, m], others[n, patch[0], patch[1] + 1, k, m], part)
                    beside[n, i, j] = value * usual[n, np.int64(out[i, j])] / usual[n, np.int64(own[j])]


@kernel(inner=True, inline="always")
def _log2(value: Any) -> Any:
    """Return the binary logarithm of a number above 0, within 8e-6; unlike the library's, it is vectorised."""
    bits = np.float32(value).view(np.int32)
    t = np.int32((bits & np.int32(0x7FFFFF)) | np.int32(0x3F800000)).view(np.float32) - np.float32(1.0)
    bent = np.float32(0.1848622) + t * (np.float32(-0.0983876) + t * np.float32(0.0262731))
    bent = np.float32(0.4426594) + t * (np.float32(-0.2767283) + t * bent)
    return np.float32((bits >> np.int32(23)) - np.int32(127)) + (t + t * (np.float32(1.0) - t) * bent)


@kernel(inner=True, fastmath={"contract"}, error_model="numpy")
def _share(common: Any, past: Any, up: Any, per_log: Any) -> None:
    """Write what all patches lose at the cells of a row, which lie past points and up from their line."""
    one = np.float32(1.0)
    for j in range(past.size):
        right = past[j]
        far = right + up > one
        w0 = abs(one - right - up)
        w1, w2 = one - up if far else right, one - right if far else up
        # the fourth power: a cell sees mostly one patch
        common[j] = per_log * _log2(w0 * w0 * w0 * w0 + w1 * w1 * w1 * w1 + w2 * w2 * w2 * w2)


@kernel(inner=True, fastmath={"contract"}, error_model="numpy")
def _lose(share: Any, point: Any, past: Any, common: Any, ends: Any, less: Any, per_log: Any) -> None:
    """Write what a patch loses: all beyond its ends."""
    four, (place, left, right, most) = np.float32(4.0) * per_log, ends
    for j in range(share.size):
        x = (point[j] - place) + past[j]
        weight = max(min(min(x - left, right - x), most), np.float32(_OUTSIDE))
        share[j] = four * _log2(weight) - common[j] + less


@kernel(inner=True)
def _copy(line: Any, of_box: Any) -> None:
    for j in range(line.size):
        line[j] = of_box[j]


@kernel(inner=True, inline="always", fastmath={"contract"})
def _between(before: Any, after: Any, part: Any) -> Any:
    first = np.float32(before)
    return first + part * (np.float32(after) - first)


@kernel(inner=True, fastmath={"contract"}, error_model="numpy")
def _take(best: Any, share: Any, before: Any, after: Any, part: Any, sheet: bool) -> None:
    """Let cells of a row show a patch where its score is the largest so far."""
    last, lost = np.float32(255.0), np.float32(_LOST)
    for j in range(best.size):
        rank = _between(before[j], after[j], part)
        value = share[j] + (last - rank if sheet else rank)
        best[j] = value if value > best[j] and share[j] >= lost else best[j]


@kernel(inner=True, fastmath={"contract"}, error_model="numpy")
def _show(own: Any, shown: Any, best: Any, share: Any, before: Any, after: Any, of_patch: Any) -> None:
    """Write own rank and number of a patch where :func:`_take` will show it."""
    last, lost, (part, number, sheet) = np.float32(255.0), np.float32(_LOST), of_patch
    for j in range(best.size):
        rank = _between(before[j], after[j], part)
        value = share[j] + (last - rank if sheet else rank)
        shown[j] = number if value > best[j] and share[j] >= lost else shown[j]
    for j in range(best.size):
        if shown[j] == number:
            own[j] = _between(before[j], after[j], part)


@kernel(fastmath={"contract"}, error_model="numpy")
def show(out: Any, ranks: Any, y: Any, x: Any, row: int, column: int, table: Any) -> None:
    """Write values of a table (256,) at ranks between the middles of cells, bilinear.

    Parameters
    ----------
    out : ndarray of float32 (Y, X)
        The result.
    ranks : ndarray of float32 (rows, columns)
        Of cells from ``row`` and ``column`` on.
    y, x : ndarray of float64 (Y,), (X,)
        Positions: whole numbers are the middles of cells.
    row, column : int
        First cell.
    table : ndarray of float32 (256,)
        Values at ranks.
    """
    at, past = np.empty(x.size, np.int64), np.empty(x.size, np.float32)
    for j in range(x.size):
        whole = math.floor(x[j])
        at[j], past[j] = np.int64(whole) - column, x[j] - whole
    for i in range(y.size):
        whole = math.floor(y[i])
        k, fy = np.int64(whole) - row, np.float32(y[i] - whole)
        for j in range(x.size):
            m = at[j]
            low = ranks[k, m] + past[j] * (ranks[k, m + 1] - ranks[k, m])
            high = ranks[k + 1, m] + past[j] * (ranks[k + 1, m + 1] - ranks[k + 1, m])
            rank = low + fy * (high - low)
            n: Any = np.int64(rank)
            n = min(n, 254)
            out[i, j] = table[n] + (rank - np.float32(n)) * (table[n + 1] - table[n])


@kernel(fastmath={"contract"}, error_model="numpy")
def show_beside(out: Any, cells: Any, ranks: Any, cloudy: float, y: Any, x: Any, row: int, column: int) -> None:
    """Write another field of cells between their middles: bilinear among cells with cloud, as far as there are any.

    Parameters
    ----------
    out : ndarray of float32 (Y, X)
        The result.
    cells, ranks : ndarray of float32 (rows, columns)
        Of cells from ``row`` and ``column`` on.
    cloudy : float
        Rank above which a cell has cloud.
    y, x : ndarray of float64 (Y,), (X,)
        Positions: whole numbers are the middles of cells.
    row, column : int
        First cell.
    """
    clear, one = np.float32(_OF_CLEAR), np.float32(1.0)
    for i in range(y.size):
        whole = math.floor(y[i])
        k, fy = np.int64(whole) - row, np.float32(y[i] - whole)
        for j in range(x.size):
            whole = math.floor(x[j])
            m, fx = np.int64(whole) - column, np.float32(x[j] - whole)
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
