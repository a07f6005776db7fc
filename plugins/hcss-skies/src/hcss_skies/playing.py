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
from numpy.typing import NDArray

from hcss_skies.hashing import hashed, uniform
from hcss_skies.reel import LOWEST, STEP
from hcss_twin.core.kernels import kernel

_SKEW = 2.0 / math.sqrt(3.0)

_LEAST = 1e-3
"""Weight below which a patch that fades is left out."""

_LOST = -160.0
"""Loss in ranks with which a patch is left out: its thickest cell in a thousand would be as thick as the thinnest."""

_STEPS = 4096
"""Steps of a table of logarithms: of .1 rank where a patch has a fifth of the weight."""

_FEWEST = 1e-4
"""Share of its usual clouds from which on a cell has any."""

_MIDDLE = 127.5
"""Rank of the normal score 0."""

_OF_CLEAR = 1e-3
"""Weight of cells without cloud beside others in fields that belong to cloud."""


def logarithms(per_score: float) -> NDArray[np.float32]:
    """Return the logarithms of weights up to 1, in ranks."""
    return (np.log((np.arange(_STEPS + 1) + 0.5) / _STEPS) * per_score).astype(np.float32)


@kernel(fastmath={"contract"}, error_model="numpy")
def play(
    out: Any, beside: Any, needed: Any, row: int, column: int, frames: Any, others: Any, usual: Any, shown: Any,
    per_score: float, spacing: float, shift: Any, sheet: bool, key: Any, age: float, lasting: Any, change: Any,
    sky: int, stretch: Any, under: Any, share: Any, logarithm: Any,
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
    logarithm : ndarray of float32 (N,)
        Of :func:`logarithms`.
    """
    part_under, part_own = np.float32(math.sqrt(share)), np.float32(math.sqrt(1.0 - share))
    rows, columns = out.shape
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
                if not sheet:
                    parts[p, q, turn, 0] = math.log(weight) * per_score if weight > _LEAST else 2.0 * _LOST
    lost, last, middle, seen = np.float32(_LOST), np.float32(255.0), np.float32(_MIDDLE), np.float32(_LEAST)
    zero, one, fewest = np.float32(0.0), np.float32(1.0), np.float32(_FEWEST)
    four, steps, tall, wide = np.float32(4.0), np.float32(_STEPS), frames.shape[2], frames.shape[3]
    inverse, number_of_sky = 1.0 / spacing, np.float32(sky)
    triangle, losses = np.empty(columns, np.int64), np.empty((3, columns), np.float32)
    best, own, patches = np.empty(columns, np.float32), np.empty(columns, np.float32), np.empty(columns, np.int64)
    squares, raised = np.empty(columns, np.float32), np.empty(columns, np.float32)
    weights, totals = np.empty(columns, np.float32), np.empty((beside.shape[0], columns), np.float32)
    for i in range(rows):
        empty, begin, beyond = True, needed[0, i], needed[1, i]
        for j in range(begin, beyond):
            if sheet:
                raised[j], empty = change[i, j], False
                continue
            times = change[i, j]
            each = max(one, times / stretch)
            times = min(max(times - number_of_sky * each, zero), each)
            if times < fewest:
                raised[j] = lost
            else:
                empty = False
                raised[j] = (
                    logarithm[np.int64(times * steps)] if times < one else np.float32(math.log(times) * per_score)
                )
        if empty:
            for j in range(columns):
                out[i, j] = zero
                for n in range(beside.shape[0]):
                    beside[n, i, j] = one
            continue
        y = (row + i + shift[0]) / spacing * _SKEW
        v = np.int64(math.floor(y))
        fv = y - v
        for j in range(begin, beyond):
            x = (column + j + shift[1]) * inverse - 0.5 * y
            u = np.int64(math.floor(x))
            fu = x - u
            far = fu + fv > 1.0
            triangle[j] = 2 * (u - low_u) + (1 if far else 0)
            w0 = np.float32(abs(1.0 - fu - fv))
            w1, w2 = np.float32(1.0 - fv if far else fu), np.float32(1.0 - fu if far else fv)
            if sheet:
                losses[0, j], losses[1, j], losses[2, j] = w0 * w0, w1 * w1, w2 * w2
                best[j], squares[j], weights[j] = zero, zero, zero
                for n in range(beside.shape[0]):
                    totals[n, j] = zero
                continue
            # the fourth power: a cell sees mostly one patch
            loss = logarithm[np.int64((w0 * w0 * w0 * w0 + w1 * w1 * w1 * w1 + w2 * w2 * w2 * w2) * steps)]
            losses[0, j] = four * logarithm[np.int64(w0 * steps)] - loss
            losses[1, j] = four * logarithm[np.int64(w1 * steps)] - loss
            losses[2, j] = four * logarithm[np.int64(w2 * steps)] - loss
            best[j] = np.float32(-1e30)
            if beside.shape[0] > 0:
                own[j], patches[j] = zero, 0
        start = begin
        while start < beyond:  # cells between the same three points
            end, far = start + 1, triangle[start] % 2
            while end < beyond and triangle[end] == triangle[start]:
                end += 1
            least = lost
            for j in range(start, end):
                least = max(least, raised[j])
            if least == lost:  # no clouds here
                start = end
                continue
            for corner in range(3):
                line = v - low_v + (far if corner == 0 else corner - 1)
                place = triangle[start] // 2 + (far if corner == 0 else 2 - corner)
                for turn in range(2):
                    less, part = parts[line, place, turn, 0], parts[line, place, turn, 1]
                    if less < (seen if sheet else lost):
                        continue
                    patch = which[line, place, turn]
                    k, number = (row + i + patch[2]) % tall, 2 * (line * which.shape[1] + place) + turn
                    before, after = frames[patch[0], patch[1], k], frames[patch[0], patch[1] + 1, k]
                    j = start
                    while j < end:  # up to the end of the box
                        m = (column + j + patch[3]) % wide
                        stop = min(end, j + wide - m)
                        if sheet:
                            _add(best, squares, losses[corner], less, part, before, after, j, stop, m)
                        elif beside.shape[0] == 0:
                            _raise(best, losses[corner], less, part, before, after, j, stop, m)
                        else:
                            _take(best, own, patches, losses[corner], less, part, number, before, after, j, stop, m)
                        j = stop
            start = end
        for j in range(begin, beyond):
            rank = best[j]
            if sheet:
                rank = rank / np.sqrt(squares[j]) if squares[j] > zero else zero
                if under.size:
                    rank = part_own * rank + part_under * (under[i, j] - middle)
                rank += middle
                own[j] = min(max(rank, zero), last)
            rank = min(max(rank, zero), last) if sheet or raised[j] > lost else zero  # whatever its neighbours have
            if shown.shape[0] == 0:
                out[i, j] = min(max(rank + raised[j], zero), last)
                continue
            at = (min(max(raised[j], np.float32(LOWEST)), np.float32(LOWEST + 23.99 * STEP)) - np.float32(LOWEST)) / (
                np.float32(STEP)
            )
            r: Any = np.int64(rank)
            s, r = np.int64(at), min(r, 254)
            fs, fr = at - np.float32(s), rank - np.float32(r)
            low = shown[s, r] + fr * (shown[s, r + 1] - shown[s, r])
            high = shown[s + 1, r] + fr * (shown[s + 1, r + 1] - shown[s + 1, r])
            out[i, j] = min(max(low + fs * (high - low), zero), last)
        if beside.shape[0] == 0:
            continue
        if not sheet:
            for j in range(begin, beyond):
                point = patches[j] // 2
                line, place, turn = point // which.shape[1], point % which.shape[1], patches[j] % 2
                patch, part = which[line, place, turn], parts[line, place, turn, 1]
                k, m = (row + i + patch[2]) % tall, (column + j + patch[3]) % wide
                for n in range(beside.shape[0]):
                    first = np.float32(others[n, patch[0], patch[1], k, m])
                    second = np.float32(others[n, patch[0], patch[1] + 1, k, m])
                    value = first + part * (second - first)
                    beside[n, i, j] = value * usual[n, 1, np.int64(out[i, j])] / usual[n, 0, np.int64(own[j])]
            continue
        for j in range(begin, beyond):
            far = triangle[j] % 2
            for corner in range(3):
                line = v - low_v + (far if corner == 0 else corner - 1)
                place = triangle[j] // 2 + (far if corner == 0 else 2 - corner)
                for turn in range(2):
                    share, part = losses[corner, j] * parts[line, place, turn, 0], parts[line, place, turn, 1]
                    if share <= zero:
                        continue
                    patch = which[line, place, turn]
                    k, m = (row + i + patch[2]) % tall, (column + j + patch[3]) % wide
                    weights[j] += share
                    for n in range(beside.shape[0]):
                        first = np.float32(others[n, patch[0], patch[1], k, m])
                        second = np.float32(others[n, patch[0], patch[1] + 1, k, m])
                        totals[n, j] += share * (first + part * (second - first))
            for n in range(beside.shape[0]):
                value = totals[n, j] / weights[j]
                beside[n, i, j] = value * usual[n, 1, np.int64(out[i, j])] / usual[n, 0, np.int64(own[j])]


@kernel(inner=True, fastmath={"contract"}, error_model="numpy")
def _take(
    best: Any, own: Any, shown: Any, losses: Any, less: Any, part: Any, number: int, before: Any, after: Any,
    start: int, stop: int, place: int,
) -> None:  # fmt: skip
    """Let the cells of a row from ``start`` to ``stop`` show a patch where its score is the largest so far."""
    lost, shift = np.float32(_LOST), place - start
    for j in range(start, stop):
        share = losses[j] + less
        first = np.float32(before[j + shift])
        rank = first + part * (np.float32(after[j + shift]) - first)
        value = share + rank
        better = value > best[j] and share >= lost
        best[j] = value if better else best[j]
        own[j] = rank if better else own[j]
        shown[j] = number if better else shown[j]


@kernel(inner=True, fastmath={"contract"}, error_model="numpy")
def _raise(
    best: Any, losses: Any, less: Any, part: Any, before: Any, after: Any, start: int, stop: int, place: int
) -> None:
    """Raise the cells of a row to the score of a patch where it is the largest so far."""
    lost, shift = np.float32(_LOST), place - start
    for j in range(start, stop):
        share = losses[j] + less
        first = np.float32(before[j + shift])
        value = share + (first + part * (np.float32(after[j + shift]) - first))
        best[j] = value if value > best[j] and share >= lost else best[j]


@kernel(inner=True, fastmath={"contract"}, error_model="numpy")
def _add(
    total: Any, squares: Any, shares: Any, weight: Any, part: Any, before: Any, after: Any, start: int, stop: int,
    place: int,
) -> None:  # fmt: skip
    """Add the scores of a patch, in ranks, and the square of its weight, to the cells of a row."""
    middle, shift = np.float32(_MIDDLE), place - start
    for j in range(start, stop):
        share = shares[j] * weight
        first = np.float32(before[j + shift])
        rank = first + part * (np.float32(after[j + shift]) - first)
        total[j] += share * (rank - middle)
        squares[j] += share * share


@kernel(fastmath={"contract"}, error_model="numpy")
def lay_over(out: Any, beside: Any, cells: Any, others: Any, table: Any, places: Any) -> None:
    """Lay a sky over another one: where both have cloud, values of a table add up; else the larger place stays.

    Parameters
    ----------
    out, cells : ndarray of float32 (rows, columns)
        What both show; the first one is changed.
    beside, others : ndarray of float32 (F, rows, columns)
        What belongs to them.
    table : ndarray of float32 (256,)
        Values, ascending from 0.
    places : ndarray of float32 (N,)
        Places of values that are evenly spaced from 0 to the last one.
    """
    per_value = np.float32(places.size - 1) / table[-1]
    for i in range(out.shape[0]):
        for j in range(out.shape[1]):
            added, rank = cells[i, j], out[i, j]
            if added > rank:
                out[i, j] = added
                for n in range(beside.shape[0]):
                    beside[n, i, j] = others[n, i, j]
            total = _at(table, min(added, rank))
            if total > 0.0:
                out[i, j] = _rank_of(places, per_value, total + _at(table, max(added, rank)))


@kernel(inner=True, error_model="numpy")
def _at(table: Any, rank: Any) -> Any:
    n: Any = np.int64(rank)
    n = min(n, 254)
    return table[n] + (rank - np.float32(n)) * (table[n + 1] - table[n])


@kernel(inner=True, error_model="numpy")
def _rank_of(places: Any, per_value: Any, value: Any) -> Any:
    """Return the place of a value, the last one if there is none."""
    at = min(value * per_value, np.float32(places.size - 1.01))
    n = np.int64(at)
    return places[n] + (at - np.float32(n)) * (places[n + 1] - places[n])


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
        Where the pixels are: see :class:`hcss_skies.pace.TurnedPixels`.
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
