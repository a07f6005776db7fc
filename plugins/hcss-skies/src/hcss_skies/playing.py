"""Patches of films side by side on a triangular lattice: clouds of neighbours meet without ghosts.

Each lattice point plays a piece of a film from a place of its own, fades into another one at its end, and goes on so.

Scattered clouds: a cell takes the largest of the scores of the patches around it, each with the logarithm of its weight
added; weights sum to 1. Gumbel's distribution is stable under this (max-stability; S. Coles, An Introduction to
Statistical Modeling of Extreme Values, Springer 2001, section 3.1.3), so that cover and thickness keep their
distribution, clouds of all patches stay as sharp as they are, and shrink towards the edge of their patch. A sum of
scores would show pale doubles of single ones. Where there are to be fewer clouds, scores are lowered, and they shrink.
Where there are to be more, skies with patches of their own are laid over one another: the largest of n scores is
distributed like one that is raised by ln n, but raised clouds would grow halos of what is clear in the film.

Sheets: a cell has the sum of normal scores with weights whose squares sum to 1 (E. Heitz and F. Neyret, Proc. ACM
Comput. Graph. Interact. Tech. 1(2), 31, 2018). Cover is changed by adding to it: thickness varies all over a sheet, so
that its thinnest parts open first.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from hcss_skies.hashing import hashed, uniform
from hcss_skies.reel import LOWEST, STEP
from hcss_twin.core.kernels import kernel

_SKEW = 2.0 / math.sqrt(3.0)

_LEAST = 1e-3
"""Weight below which a patch that fades is left out."""

_LOST = -160.0
"""Loss in ranks with which a patch is left out: its thickest cell in a thousand would be as thick as the thinnest."""

_OUTSIDE = 1e-4
"""Weight of a patch beyond its ends, where it is lost."""

_AT_ONCE, _OF_PATCH = 32, 8
"""Neighbours of a row, and of a patch in it, that are looked at together; those beyond its ends get nothing from it."""

_FEWEST = 1e-4
"""Share of its usual clouds from which on a cell has any."""

_MIDDLE = 127.5
"""Rank of the normal score 0."""

_OF_CLEAR = 1e-3
"""Weight of cells without cloud beside others in fields that belong to cloud."""


@kernel(fastmath={"contract"})
def play(
    out: Any, beside: Any, needed: Any, row: int, column: int, frames: Any, others: Any, usual: Any, shown: Any,
    per_score: float, spacing: float, shift: Any, sheet: bool, key: Any, age: float, lasting: Any, change: Any,
    sky: int, stretch: Any, under: Any, share: Any,
) -> None:  # fmt: skip
    """Write what cells show (rows, columns) from ``row`` and ``column`` on, and what belongs to it.

    Parameters
    ----------
    out : ndarray of float32 (rows, columns)
        Places in the table of thickness, 0 to 255, with fractions.
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
    usual : ndarray of float32 (F, 2, 256)
        Their usual values at ranks, and at what cells show: one that shows less than it has, has values in proportion.
    shown : ndarray of float32 (shifts, 256)
        Of :class:`~hcss_skies.reel.Cells`; none if cells show their ranks.
    per_score : float
        Ranks in a score.
    spacing : float
        Distance of lattice points in cells.
    shift : ndarray of float64 (2,)
        Of the lattice along y and x in cells.
    sheet : bool
        Whether scores are normal, those of sheets.
    key : uint64
        Of the random numbers.
    age : float
        Time in lifetimes of a patch; NaN: clouds do not change.
    lasting : ndarray of float64 (2,)
        Frames that a piece has, and frames after which the next one begins to replace it.
    change : ndarray of float32 (rows, columns)
        Ranks that are added to a sheet; for other clouds, how many times as many there are as in the film.
    sky : int
        Which of the skies that are laid over one another; the first one is 0.
    stretch : float32
        Most skies: where there are to be more clouds, all of them are raised alike.
    under : ndarray of float32 (rows, columns)
        Ranks of another sheet, which is added; none if it is empty.
    share : float32
        Its share of the variance.
    """
    rows, columns = out.shape
    low_v = np.int64(math.floor((row + shift[0]) / spacing * _SKEW))
    high_v = np.int64(math.floor((row + rows + shift[0]) / spacing * _SKEW)) + 2
    low_u = np.int64(math.floor((column + shift[1]) / spacing - 0.5 * (high_v + 1))) - 1
    high_u = np.int64(math.floor((column + columns + shift[1]) / spacing - 0.5 * low_v)) + 3
    # Two patches of each point: piece, frame, place along y and x; their loss of score, or weight in a sheet, and the
    # fraction of a frame.
    which = np.empty((high_v - low_v, high_u - low_u, 2, 4), np.int64)
    parts = np.empty((high_v - low_v, high_u - low_u, 2, 2), np.float32)
    for p in range(which.shape[0]):
        for q in range(which.shape[1]):
            _choose(which[p, q], parts[p, q], low_u + q, low_v + p, frames.shape, key, age, lasting)
            for turn in range(2):
                weight = float(parts[p, q, turn, 0])
                if not sheet:
                    parts[p, q, turn, 0] = math.log(weight) * per_score if weight > _LEAST else 2.0 * _LOST
    left_out, zero, one = np.float32(_LEAST if sheet else _LOST), np.float32(0.0), np.float32(1.0)
    length, tall, wide, inverse = frames.shape[1], frames.shape[2], frames.shape[3], 1.0 / spacing
    film, of_others, of_shown = frames.reshape(-1), others.reshape(-1), shown.reshape(-1)
    of_frame, of_field = np.uint64(frames[0, 0].size), np.uint64(frames.size)
    per_log = np.float32(per_score * math.log(2.0))
    padded, fields = columns + 2 * _AT_ONCE, beside.shape[0]
    # Of the cells of a row: points of the lattice before them and places after these, the same in any window; what all
    # patches lose there; what is added to the result; and the first of the cells from there on that has clouds.
    point, past, common = np.zeros(padded, np.float32), np.zeros(padded, np.float32), np.zeros(padded, np.float32)
    raised, following = np.zeros(padded, np.float32), np.arange(padded + 1)
    along = (column + np.arange(padded) + shift[1]) * inverse
    # Score and own rank of what is shown (or, in a sheet, sum of scores and of squares of weights), and its fields.
    best, own, rank = np.zeros(padded, np.float32), np.zeros(padded, np.float32), np.zeros(padded, np.float32)
    values, total = np.zeros((fields, padded), np.float32), np.zeros(padded, np.float32)
    weights, ranks = np.zeros(padded, np.float32), np.zeros(padded, np.float32)
    for i in range(rows):
        begin, beyond, clear = needed[0, i], needed[1, i], 0
        if begin >= beyond:
            continue
        line = slice(begin, begin + (beyond - begin + _AT_ONCE - 1) // _AT_ONCE * _AT_ONCE)
        _copy(raised[begin:beyond], change[i, begin:beyond])
        if not sheet:
            _times(raised[line], np.float32(sky), stretch, per_log)
            clear = _count(raised[begin:beyond])
            if clear > 0:
                following[beyond] = beyond
                for j in range(beyond - 1, begin - 1, -1):
                    following[j] = j if raised[j] > np.float32(_LOST) else following[j + 1]
            if clear == beyond - begin:
                _fill(out[i, begin:beyond], zero)
                for n in range(fields):
                    _fill(beside[n, i, begin:beyond], one)
                continue
        y = (row + i + shift[0]) / spacing * _SKEW
        v = np.int64(math.floor(y))
        fv = y - v
        _find(point[line], past[line], along[line], 0.5 * y, float(low_u))
        first = float(point[begin]) + float(past[begin])
        last = first + (beyond - begin) * inverse
        if not sheet:
            _share(common[line], past[line], np.float32(fv), per_log)
        _fill(best[line], zero if sheet else np.float32(-1e30))
        _fill(own[line], zero)
        if fields > 0:
            _fill(total[line], zero)
            for n in range(fields):
                _fill(values[n, line.start : line.stop], zero)
        for upper in range(2):
            # The weight of a point rises from its left end to its share of the row, and falls to its right end.
            left, right, most = (-fv, 1.0, fv) if upper else (-1.0, 1.0 - fv, 1.0 - fv)
            of_line = v - low_v + upper
            for place in range(np.int64(first), np.int64(last) + 2):
                start = max(begin, begin + np.int64(math.floor((place + left - first) * spacing)))
                end = min(beyond, begin + np.int64(math.ceil((place + right - first) * spacing)) + 1)
                start = following[start] if clear > 0 and start < end else start
                if start >= end:
                    continue
                ends = np.float32(place), np.float32(left), np.float32(right), np.float32(most)
                at = np.uint64(start)
                count = np.uint64((end - start + _OF_PATCH - 1) // _OF_PATCH * _OF_PATCH)
                for turn in range(2):
                    less, part = parts[of_line, place, turn, 0], parts[of_line, place, turn, 1]
                    if less < left_out:
                        continue
                    patch = which[of_line, place, turn]
                    k, m = (row + i + patch[2]) % tall, (column + start + patch[3]) % wide
                    before = np.uint64(((patch[0] * length + patch[1]) * tall + k) * wide)
                    box = np.uint64(m), np.uint64(wide)
                    _unroll(ranks, at, count, film, before, before + of_frame, box, part)
                    if sheet:
                        _add(best, own, ranks, point, past, at, count, ends, less)
                    elif fields == 0:
                        _raise(best, ranks, point, past, common, at, count, ends, less, per_log)
                    if fields == 0:
                        continue
                    if sheet:
                        _weigh(weights, total, point, past, at, count, ends, less)
                    else:
                        _lose(weights, point, past, common, at, count, ends, less, per_log)
                        _show(own, weights, best, ranks, at, count)
                    for n in range(fields):
                        _unroll(ranks, at, count, of_others, before, before + of_frame, box, part)
                        before += of_field
                        if sheet:
                            _add_field(values, n, weights, ranks, at, count)
                        else:
                            _take(values, n, weights, ranks, at, count)
        if sheet:
            _mean(best[line], own[line])
            if under.size > 0:
                _mix(best[begin:beyond], under[i, begin:beyond], share)
        _bound(rank[line], best[line], np.float32(_MIDDLE) if sheet else zero)
        if sheet:
            _copy(own[line], rank[line])
        if shown.shape[0] == 0:
            _look(out[i, begin:beyond], rank[begin:beyond], raised[begin:beyond])
        else:
            _see(out[i, begin:beyond], rank[begin:beyond], raised[begin:beyond], of_shown)
        for n in range(fields):
            if sheet:
                _divide(values[n, line.start : line.stop], total[line])
            field = beside[n, i, begin:beyond]
            _belong(field, values[n, begin:beyond], out[i, begin:beyond], own[begin:beyond], usual[n, 1], usual[n, 0])
        if clear == 0:
            continue
        for j in range(begin, beyond):  # whatever their neighbours have
            if following[j] > j:
                out[i, j] = zero
                for n in range(fields):
                    beside[n, i, j] = one


@kernel(inner=True, inline="always")
def _log2(value: Any) -> Any:
    """Return the binary logarithm of a number above 0, within 8e-6; unlike the library's, it is vectorised."""
    bits = np.float32(value).view(np.int32)
    t = np.int32((bits & np.int32(0x7FFFFF)) | np.int32(0x3F800000)).view(np.float32) - np.float32(1.0)
    bent = np.float32(0.1848622) + t * (np.float32(-0.0983876) + t * np.float32(0.0262731))
    bent = np.float32(0.4426594) + t * (np.float32(-0.2767283) + t * bent)
    return np.float32((bits >> np.int32(23)) - np.int32(127)) + (t + t * (np.float32(1.0) - t) * bent)


@kernel(inner=True, fastmath={"contract"})
def _times(raised: Any, sky: Any, stretch: Any, per_log: Any) -> None:
    """Replace how many times as many clouds cells have in all skies by what raises their scores in one."""
    zero, one, fewest, lost = np.float32(0.0), np.float32(1.0), np.float32(_FEWEST), np.float32(_LOST)
    for j in range(raised.size):
        times = raised[j]
        each = max(one, times / stretch)
        times = min(max(times - sky * each, zero), each)
        raised[j] = lost if times < fewest else max(per_log * _log2(times), lost)


@kernel(inner=True)
def _count(raised: Any) -> Any:
    """Return how many cells have no clouds."""
    number = 0
    for j in range(raised.size):
        number += 1 if raised[j] <= np.float32(_LOST) else 0
    return number


@kernel(inner=True, fastmath={"contract"})
def _find(point: Any, past: Any, along: Any, before: float, first: float) -> None:
    """Write the points of a line from the ``first`` one on, and places past them, of the cells of a row."""
    for j in range(point.size):
        x = along[j] - before
        whole = math.floor(x)
        point[j], past[j] = np.float32(whole - first), np.float32(x - whole)


@kernel(inner=True, fastmath={"contract"})
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


@kernel(inner=True)
def _copy(line: Any, other: Any) -> None:
    for j in range(line.size):
        line[j] = other[j]


@kernel(inner=True)
def _fill(line: Any, value: Any) -> None:
    for j in range(line.size):
        line[j] = value


@kernel(inner=True, fastmath={"contract"})
def _unroll(ranks: Any, at: Any, count: Any, film: Any, before: Any, after: Any, box: Any, part: Any) -> None:
    """Write what a patch has between two frames, from a place of a row of the box on, which is repeated."""
    place, wide = box
    done = np.uint64(0)
    while done < count:
        some = min(count - done, wide - place)
        to, first, second = at + done, before + place, after + place
        for n in range(some):
            value = np.float32(film[first + n])
            ranks[to + n] = value + part * (np.float32(film[second + n]) - value)
        done, place = done + some, np.uint64(0)


@kernel(inner=True, inline="always", fastmath={"contract"})
def _near(point: Any, past: Any, ends: Any, least: Any) -> Any:
    """Return the weight of a patch, ``least`` beyond its ends."""
    place, left, right, most = ends
    x = (point - place) + past
    return max(min(min(x - left, right - x), most), least)


@kernel(inner=True, fastmath={"contract"})
def _raise(
    best: Any, ranks: Any, point: Any, past: Any, common: Any, at: Any, count: Any, ends: Any, less: Any, per_log: Any
) -> None:
    """Raise the cells of a row to the score of a patch where it is the largest so far."""
    four, outside, lost = np.float32(4.0) * per_log, np.float32(_OUTSIDE), np.float32(_LOST)
    for n in range(count):
        j = at + n
        share = four * _log2(_near(point[j], past[j], ends, outside)) - common[j] + less
        value = share + ranks[j]
        best[j] = value if value > best[j] and share >= lost else best[j]


@kernel(inner=True, fastmath={"contract"})
def _lose(
    share: Any, point: Any, past: Any, common: Any, at: Any, count: Any, ends: Any, less: Any, per_log: Any
) -> None:
    """Write what a patch loses, as :func:`_raise` has it."""
    four, outside = np.float32(4.0) * per_log, np.float32(_OUTSIDE)
    for n in range(count):
        j = at + n
        share[j] = four * _log2(_near(point[j], past[j], ends, outside)) - common[j] + less


@kernel(inner=True, fastmath={"contract"})
def _show(own: Any, share: Any, best: Any, ranks: Any, at: Any, count: Any) -> None:
    """Raise cells as :func:`_raise` does; of those that are raised write the own rank, and 1 for what they lose."""
    lost = np.float32(_LOST)
    for n in range(count):
        j = at + n
        rank, less, most, before = ranks[j], share[j], best[j], own[j]
        better = less + rank > most and less >= lost
        best[j] = less + rank if better else most
        own[j] = rank if better else before
        share[j] = np.float32(1.0) if better else np.float32(0.0)


@kernel(inner=True, fastmath={"contract"})
def _take(values: Any, field: int, better: Any, ranks: Any, at: Any, count: Any) -> None:
    """Write another field of a patch where :func:`_show` shows it."""
    for n in range(count):
        j = at + n
        value, before = ranks[j], values[field, j]
        values[field, j] = value if better[j] > np.float32(0.0) else before


@kernel(inner=True, fastmath={"contract"})
def _add(
    total: Any, squares: Any, ranks: Any, point: Any, past: Any, at: Any, count: Any, ends: Any, weight: Any
) -> None:
    """Add the scores of a patch, in ranks, and the squares of its weights, to the cells of a row."""
    middle, nothing = np.float32(_MIDDLE), np.float32(0.0)
    for n in range(count):
        j = at + n
        near = _near(point[j], past[j], ends, nothing)
        share = near * near * weight
        total[j] += share * (ranks[j] - middle)
        squares[j] += share * share


@kernel(inner=True, fastmath={"contract"})
def _weigh(share: Any, total: Any, point: Any, past: Any, at: Any, count: Any, ends: Any, weight: Any) -> None:
    """Write and add up the weights of a patch of a sheet."""
    for n in range(count):
        j = at + n
        near = _near(point[j], past[j], ends, np.float32(0.0))
        share[j] = near * near * weight
        total[j] += share[j]


@kernel(inner=True, fastmath={"contract"})
def _add_field(total: Any, field: int, share: Any, ranks: Any, at: Any, count: Any) -> None:
    for n in range(count):
        j = at + n
        total[field, j] += share[j] * ranks[j]


@kernel(inner=True)
def _divide(total: Any, weight: Any) -> None:
    for j in range(total.size):
        total[j] /= weight[j]


@kernel(inner=True)
def _belong(field: Any, value: Any, out: Any, own: Any, shown: Any, usual: Any) -> None:
    """Write another field, with the usual values at what cells show and at their own ranks."""
    for j in range(field.size):
        field[j] = value[j] * shown[np.uint32(np.int32(out[j]))] / usual[np.uint32(np.int32(own[j]))]


@kernel(inner=True)
def _mean(total: Any, squares: Any) -> None:
    """Replace sums of scores by scores, with the sums of squares of weights."""
    for j in range(total.size):
        total[j] /= np.sqrt(squares[j])


@kernel(inner=True)
def _mix(rank: Any, under: Any, share: Any) -> None:
    """Add another sheet that has a share of the variance."""
    middle, part, other = np.float32(_MIDDLE), np.float32(math.sqrt(1.0 - share)), np.float32(math.sqrt(share))
    for j in range(rank.size):
        rank[j] = part * rank[j] + other * (under[j] - middle)


@kernel(inner=True)
def _bound(rank: Any, score: Any, middle: Any) -> None:
    """Write the ranks of scores that are ``middle`` where the scores are 0."""
    for j in range(rank.size):
        rank[j] = min(max(score[j] + middle, np.float32(0.0)), np.float32(255.0))


@kernel(inner=True)
def _look(out: Any, rank: Any, raised: Any) -> None:
    """Write what cells show that show their ranks."""
    for j in range(out.size):
        out[j] = min(max(rank[j] + raised[j], np.float32(0.0)), np.float32(255.0))


@kernel(inner=True, fastmath={"contract"})
def _see(out: Any, rank: Any, raised: Any, shown: Any) -> None:
    """Write what cells show by the table for their size, between its shifts and ranks."""
    lowest, highest, per_step = np.float32(LOWEST), np.float32(LOWEST + 23.99 * STEP), np.float32(1.0 / STEP)
    zero, last, after, below = np.float32(0.0), np.float32(255.0), np.uint32(1), np.uint32(256)
    for j in range(out.size):
        at = (min(max(raised[j], lowest), highest) - lowest) * per_step
        s, r = np.int32(at), np.int32(min(rank[j], np.float32(254.0)))
        fs, fr = at - np.float32(s), rank[j] - np.float32(r)
        n = np.uint32(s * np.int32(256) + r)
        low = shown[n] + fr * (shown[n + after] - shown[n])
        n += below
        high = shown[n] + fr * (shown[n + after] - shown[n])
        out[j] = min(max(low + fs * (high - low), zero), last)


@kernel()
def with_clouds(needed: Any, change: Any, sky: int) -> Any:
    """Return the first column (2, rows) of each row where a sky has clouds, and the one after the last.

    Parameters
    ----------
    needed : ndarray of int64 (2, rows)
        Those between which they are.
    change : ndarray of float32 (rows, columns)
        How many times as many clouds there are as in the film.
    sky : int
        Which of the skies that are laid over one another, from 1.
    """
    found = needed.copy()
    for i in range(change.shape[0]):
        begin, beyond = found[0, i], found[1, i]
        while begin < beyond and change[i, begin] <= sky:
            begin += 1
        while begin < beyond and change[i, beyond - 1] <= sky:
            beyond -= 1
        found[0, i], found[1, i] = begin, beyond
    return found


@kernel(fastmath={"contract"})
def lay_over(out: Any, beside: Any, cells: Any, others: Any, needed: Any, table: Any, places: Any) -> None:
    """Lay a sky over another one: where both have cloud, values of a table add up; else the larger place stays.

    Parameters
    ----------
    out, cells : ndarray of float32 (rows, columns)
        What both show; the first one is changed.
    beside, others : ndarray of float32 (F, rows, columns)
        What belongs to them.
    needed : ndarray of int64 (2, rows)
        First column of each row that is laid over, and the one after the last.
    table : ndarray of float32 (256,)
        Values, ascending from 0.
    places : ndarray of float32 (N,)
        Places of values that are evenly spaced from 0 to the last one.
    """
    per_value = np.float32(places.size - 1) / table[-1]
    for i in range(out.shape[0]):
        for j in range(needed[0, i], needed[1, i]):
            added, rank = cells[i, j], out[i, j]
            if added <= np.float32(0.0):
                continue
            if added > rank:
                out[i, j] = added
                for n in range(beside.shape[0]):
                    beside[n, i, j] = others[n, i, j]
            total = _at(table, min(added, rank))
            if total > 0.0:
                out[i, j] = _rank_of(places, per_value, total + _at(table, max(added, rank)))


@kernel(inner=True)
def _at(table: Any, rank: Any) -> Any:
    n: Any = np.int64(rank)
    n = min(n, 254)
    return table[n] + (rank - np.float32(n)) * (table[n + 1] - table[n])


@kernel(inner=True)
def _rank_of(places: Any, per_value: Any, value: Any) -> Any:
    """Return the place of a value, the last one if there is none."""
    at = min(value * per_value, np.float32(places.size - 1.01))
    n = np.int64(at)
    return places[n] + (at - np.float32(n)) * (places[n + 1] - places[n])


@kernel(fastmath={"contract"})
def show(out: Any, ranks: Any, y: Any, y_turned: Any, x: Any, x_turned: Any, row: int, column: int, table: Any) -> None:
    """Write values of a table (256,) at ranks between the middles of cells, bilinear.

    Parameters
    ----------
    out : ndarray of float32 (Y, X)
        The result.
    ranks : ndarray of float32 (rows, columns)
        Of cells from ``row`` and ``column`` on.
    y, y_turned, x, x_turned : ndarray of float64
        Where the pixels are: see :class:`hcss_skies.pace.TurnedPixels`.
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


@kernel(fastmath={"contract"})
def show_beside(
    out: Any, cloud: Any, cells: Any, ranks: Any, cloudy: float, y: Any, y_turned: Any, x: Any, x_turned: Any,
    row: int, column: int,
) -> None:  # fmt: skip
    """Write another field of cells between their middles: bilinear among cells with cloud, as far as there are any.

    Parameters
    ----------
    out : ndarray of float32 (Y, X)
        The result; 0 where pixels are clear.
    cloud : ndarray of float32 (Y, X)
        Above 0 where pixels have cloud.
    cells, ranks : ndarray of float32 (rows, columns)
        Of cells from ``row`` and ``column`` on.
    cloudy : float
        Rank above which a cell has cloud.
    y, y_turned, x, x_turned : ndarray of float64
        Where the pixels are: see :class:`hcss_skies.pace.TurnedPixels`.
    row, column : int
        First cell.
    """
    clear, one = np.float32(_OF_CLEAR), np.float32(1.0)
    for i in range(y.size):
        for j in range(x.size):
            if cloud[i, j] <= np.float32(0.0):
                out[i, j] = np.float32(0.0)
                continue
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
