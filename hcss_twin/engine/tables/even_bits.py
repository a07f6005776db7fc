"""Tables of one layer on an axis even in the bits of the thickness: look-up without search and division.

The leading bits of a single-precision number are even in the number itself from each power of 2 to the next, so that
they are the interval, and the other bits the position in it. A table is resampled to these intervals. A line through
an interval misses the corners that the table has in it: where it misses one by more than ``CORNER``, its slope is NaN,
and pixels that become NaN are looked up in the table itself.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.kernels import inner, kernel

SHIFT = 13
"""Bits within an interval: 1024 intervals from each power of 2 to the next."""

FEWEST = 1024
"""Fewest intervals of a table, so that rounding errors of the lines stay below those of the thickness."""

CORNER = 2e-6
"""Largest relative error of a line."""


class EvenAxis(NamedTuple):
    """Intervals from below the first node of a table to beyond the last.

    Attributes
    ----------
    shift, first : int
        Interval of a number: bits >> shift, minus ``first``.
    bits : (int, int, int, int)
        Of the smallest and the largest number allowed, and of the first and the last node.
    interval, part : ndarray (E,)
        Interval of the nodes, and position in it, of the ends of these; the outermost continue.
    own, place : ndarray (N,)
        Interval of each node, and position in it; the outermost nodes are rounded to single precision.
    """

    shift: int
    first: int
    bits: tuple[int, int, int, int]
    interval: NDArray[np.intp]
    part: Array
    own: NDArray[np.intp]
    place: Array


class EvenTable(NamedTuple):
    """Values (C,) and slopes (C,) in turn: of clear sky, then of each interval."""

    pairs: NDArray[np.float32]
    channels: int
    shift: int
    first: int
    bits: tuple[int, int, int, int]


def even_axis(nodes_m: Array, rounding: float) -> EvenAxis:
    """Return the axis of ascending nodes (N,); numbers beyond them by a share ``rounding`` are allowed."""
    ends = [nodes_m[0] * (1 - rounding), nodes_m[-1] * (1 + rounding), nodes_m[0], nodes_m[-1]]
    least, most, low, high = (int(each) for each in np.array(ends, np.float32).view(np.int32))
    shift = SHIFT
    while shift > 0 and (high >> shift) - (low >> shift) < FEWEST:
        shift -= 1
    at = (np.arange(low >> shift, (high >> shift) + 2, dtype=np.int64) << shift).astype(np.int32)
    at_m = at.view(np.float32).astype(np.float64)
    index = np.clip(np.searchsorted(nodes_m, at_m, side="right") - 1, 0, nodes_m.size - 2)
    part = (at_m - nodes_m[index]) / (nodes_m[index + 1] - nodes_m[index])
    nearest = nodes_m.copy()
    nearest[[0, -1]] = nodes_m[[0, -1]].astype(np.float32)
    own = np.searchsorted(at_m, nearest, side="right") - 1
    place = (nearest - at_m[own]) / (at_m[own + 1] - at_m[own])
    return EvenAxis(shift, low >> shift, (least, most, low, high), index, part, own, place)


def even_table(axis: EvenAxis, clear: Array, values: Array) -> EvenTable:
    """Resample ``values`` (N, C) at the nodes; ``clear`` (C,) is the value without cloud."""
    pairs = np.zeros((axis.interval.size, clear.size, 2), np.float32)
    pairs[0, :, 0] = clear
    _resample(pairs, axis.interval, axis.part, axis.own, axis.place, np.ascontiguousarray(values))
    return EvenTable(pairs.reshape(-1), clear.size, axis.shift, axis.first, axis.bits)


@kernel()
def _resample(pairs, index, part, own, place, values):  # type: ignore[no-untyped-def]
    at = np.empty((index.size, values.shape[1]))
    for i in range(index.size):
        low, high = values[index[i]], values[index[i] + 1]
        for c in range(values.shape[1]):
            at[i, c] = low[c] + part[i] * (high[c] - low[c])
            if i < index.size - 1:
                pairs[i + 1, c, 0] = at[i, c]
            if i:
                pairs[i, c, 1] = at[i, c] - at[i - 1, c]
    for node in range(own.size):
        i = own[node]
        # At the outermost nodes, only what their rounding to single precision changes.
        allowed = CORNER if 0 < node < own.size - 1 else 0.01 * CORNER
        for c in range(values.shape[1]):  # each by itself: it has the same bits whatever else is asked for
            line = at[i, c] + place[node] * (at[i + 1, c] - at[i, c])
            if not abs(line - values[node, c]) <= allowed * abs(values[node, c]):
                pairs[i + 1, c, 1] = np.nan


@inner()
def fill_even(radiance, row, column, table, bits, index, share):  # type: ignore[no-untyped-def]
    """Write one row of points; return whether all are allowed, and whether any is NaN.

    Parameters
    ----------
    radiance : ndarray of float32 (C, Y, X)
        Filled from ``row`` and ``column`` on.
    table : EvenTable
    bits : ndarray of int32 (N,)
        Of the thickness of the points.
    index, share : ndarray of uint32 and float32, at least (N,)
        Scratch.
    """
    pairs, channels, count = table.pairs, table.channels, bits.size
    shift, none, step = np.int32(table.shift), np.int32(0), np.uint64(2 * channels)
    start, mask = np.int32(table.first << table.shift), np.int32((1 << table.shift) - 1)
    scale, not_a_number = np.float32(0.5**table.shift), np.int32(-0x800000)
    least, most, low, high = table.bits
    least, most, low, high = np.int32(least), np.int32(most), np.int32(low), np.int32(high)
    outside, is_nan = none, none
    for x in range(count):
        number = bits[x]
        cloudy = number > none
        wrong = (number > most) | (cloudy & (number < least)) | ((number < none) & (number > not_a_number))
        outside = np.int32(outside | np.int32(wrong))
        place = np.int32(min(max(number, low), high) - start)
        index[x] = np.uint32(np.int32(place >> shift) + np.int32(1)) if cloudy else np.uint32(0)
        share[x] = np.float32(np.int32(place & mask)) * scale if cloudy else np.float32(0.0)
    if outside:
        return False, False
    first, points = channels // 3 * 3, slice(column, column + count)
    for c in range(0, first, 3):  # three at once take the time of two
        own, one = pairs[2 * c :], radiance[c, row, points]
        two, three = radiance[c + 1, row, points], radiance[c + 2, row, points]
        for x in range(count):
            k, part = np.uint64(index[x]) * step, share[x]
            one[x] = own[k] + part * own[k + np.uint64(1)]
            two[x] = own[k + np.uint64(2)] + part * own[k + np.uint64(3)]
            three[x] = own[k + np.uint64(4)] + part * own[k + np.uint64(5)]
    for c in range(first, channels):
        own, one = pairs[2 * c :], radiance[c, row, points]
        for x in range(count):
            k = np.uint64(index[x]) * step
            one[x] = own[k] + share[x] * own[k + np.uint64(1)]
    for c in range(channels):
        plane = radiance[c, row, points]
        for x in range(count):
            is_nan = np.int32(is_nan | np.int32(plane[x] != plane[x]))
    return True, is_nan != none
