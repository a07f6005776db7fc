"""Cells are divided into finer ones that keep their mean: smooth shapes, ragged edges and fibres below a pixel.

1. What is seen of a thickness t, log(1 + t / visible), is about linear in brightness temperature for thin cloud and
   changes little where cloud is opaque. A cubic through the centres of cells interpolates it. Clear cells beside cloudy
   ones count as negative, so that edges lie inside the cloudy cells and do not follow their sides.
2. Numbers with the spectrum of the detail, one octave for each halving, displace edges and are the logarithm of a
   factor of the thickness. They are periodic textures; where cells have a direction, textures are fibres along it.
3. The factor that gives each cell its mean is first interpolated between cells, so that their sides are not seen, and
   then exact; what would exceed the greatest thickness gets it.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from hcss_skies.fibres import number, orient
from hcss_twin.core.kernels import kernel

MARGIN = 7
"""Cells around those that are divided."""

STAGE = 2
"""Most halvings at a time."""

# Depth of clear cells in parts of the highest beside them: edges stay inside the cloudy cells but for few.
_CLEAR = 2.5

# Part of a cell's own value below which thickness falls exponentially: never 0, so that every mean can be reached.
_TAIL = 0.1

# What interpolation blurs of the factor is added beforehand, in parts of the difference to its blurred self.
_BLURRED, _LARGEST = 1.5, 2.0

# Rows of cells whose parts are kept until their neighbours' sums are known.
_KEPT = 4

_STEPS = 8


@kernel(fastmath={"contract"})
def refine(
    out: Any, cells: Any, first: Any, strength: float, deviations: Any, most: float, visible: float, textures: Any,
    places: Any, parts: Any,
) -> None:  # fmt: skip
    """Write the parts of cells without the ``MARGIN`` outermost ones.

    Loops run along rows of cells, because the same part of each has the same weights: parts are kept in arrays (side,
    side, columns), where the first two indices count those of a cell.

    Parameters
    ----------
    out : ndarray of float32 or float64 ((rows - 14) 2^halvings, (columns - 14) 2^halvings)
        Thickness in m.
    cells : ndarray of float32 or float64 (rows, columns)
        Thickness in m.
    first : ndarray of int64 (2,)
        Indices of the first cell.
    strength : float
        Standard deviation of the logarithm of thickness where it changes by itself from cell to cell; 0: no detail.
    deviations : ndarray of float64 (halvings,)
        Standard deviation of each octave in parts of it.
    most, visible : float
        Greatest thickness, and the thickness with an optical thickness of about 1.
    textures : ndarray of int16
        Of :func:`~hcss_skies.fibres.textures`.
    places, parts : ndarray of int64 (halvings, 2, 2), of float64 (halvings, 2)
        Where two uses of the textures begin, and their parts in the numbers.
    """
    rows, columns = cells.shape
    side = 1 << deviations.size
    level, tail = np.empty((rows, columns), np.float32), np.empty((2, rows, columns), np.float32)
    change, fibres = np.zeros((2, rows, columns), np.float32), np.zeros((2, rows, columns), np.float32)
    which = np.empty((rows, columns), np.int32)
    seen = tail[0]
    _see(seen, cells, visible)
    orient(change, fibres, which, cells, seen, strength)
    _edges(level, tail, cells)
    flat = textures.reshape(-1)
    values = np.zeros((_KEPT, side, side, columns), np.float32)
    factor = np.zeros((4, rows, columns), np.float32)
    taps = np.empty((side, 6), np.float32)  # of the cubic, then of the linear interpolation
    for n in range(side):
        f = (n + 0.5) / side - 0.5
        _cubic(f - math.floor(f), taps[n])
    sums, line = np.empty(columns, np.float32), np.empty((3, columns), np.float32)
    scale, highest = np.empty((2, columns)), np.empty(columns, np.float32)
    coarser = values
    for octave in range(deviations.size):
        finest = octave == deviations.size - 1
        numbers = values if finest else np.zeros((rows, 2 << octave, 2 << octave, columns), np.float32)
        for cell in range(4 if finest else 2, rows - (4 if finest else 2)):
            cell_values = numbers[cell % numbers.shape[0]]
            if strength > 0.0:
                number(cell_values, coarser, cell, fibres, which, first, flat, places[octave],
                       parts[octave] * deviations[octave])  # fmt: skip
            if finest:
                _shape(cell_values, sums, cell, taps, level, change, tail, line)
                _smooth(factor, sums, cell, cells, most, visible, side, line)
            last = cell - 3
            if finest and last >= MARGIN:
                cell_values = values[last % _KEPT]
                _weigh(cell_values, scale[0], highest, factor[2], last, line)
                _keep(out, cell_values, scale, highest, last, cells, most)
        coarser = numbers


@kernel(inner=True, fastmath={"contract"})
def _see(seen: Any, cells: Any, visible: float) -> None:
    """Write what is seen of cells."""
    rows, columns = cells.shape
    one, per_visible, zero = np.float32(1.0), np.float32(1.0 / visible), np.float32(0.0)
    bits = seen.view(np.int32)
    rest, power = np.empty(columns, np.float32), np.empty(columns, np.float32)
    for i in range(rows):
        for j in range(columns):
            thickness = max(np.float32(cells[i, j]), zero) * per_visible
            seen[i, j] = one + thickness
            rest[j] = (thickness - (seen[i, j] - one)) / seen[i, j]  # rounding
        _logarithm(seen, bits, i, power)
        for j in range(columns):
            seen[i, j] += rest[j]


@kernel(inner=True, fastmath={"contract"})
def _edges(level: Any, tail: Any, cells: Any) -> None:
    """Write what is seen with clear cells below 0, and replace it by where thickness falls exponentially (1 / ...)."""
    rows, columns = cells.shape
    seen = tail[0]
    line = np.empty(columns, np.float32)
    below, one, least, share = np.float32(-_CLEAR), np.float32(1.0), np.float32(1e-9), np.float32(_TAIL)
    for i in range(1, rows - 1):
        for j in range(columns):
            line[j] = max(max(seen[i - 1, j], seen[i, j]), seen[i + 1, j])
            level[i, j] = seen[i, j]
        for j in range(columns - 2):
            if cells[i, j + 1] <= 0.0:
                level[i, j + 1] = below * max(max(line[j], line[j + 1]), line[j + 2])
    for i in range(rows):
        for j in range(columns):
            tail[0, i, j] = share * seen[i, j] + least
            tail[1, i, j] = one / tail[0, i, j]


@kernel(inner=True, fastmath={"contract"})
def _shape(values: Any, sums: Any, cell: int, taps: Any, level: Any, change: Any, tail: Any, line: Any) -> None:
    """Replace numbers of a row of cells by thickness over the visible one, and write its sums by cell."""
    side, columns = values.shape[1], values.shape[2]
    zero, one, least = np.float32(0.0), np.float32(1.0), np.float32(-11.0)
    for j in range(columns):
        sums[j] = zero
    for m in range(side):
        low = cell - 1 if 2 * m + 1 < side else cell
        a, b, c, d, e, f = taps[m, 0], taps[m, 1], taps[m, 2], taps[m, 3], taps[m, 4], taps[m, 5]
        for j in range(columns):
            line[0, j] = a * level[low - 1, j] + b * level[low, j] + c * level[low + 1, j] + d * level[low + 2, j]
            line[1, j] = e * change[0, low, j] + f * change[0, low + 1, j]
            line[2, j] = e * change[1, low, j] + f * change[1, low + 1, j]
        for n in range(side):
            shift = 0 if 2 * n + 1 < side else 1
            a, b, c, d, e, f = taps[n, 0], taps[n, 1], taps[n, 2], taps[n, 3], taps[n, 4], taps[n, 5]
            for j in range(columns - 4):
                k = j + shift
                number = values[m, n, j + 2]
                q = a * line[0, k] + b * line[0, k + 1] + c * line[0, k + 2] + d * line[0, k + 3]
                q += number * (e * line[2, k + 1] + f * line[2, k + 2])
                x = number * (e * line[1, k + 1] + f * line[1, k + 2])
                limit = tail[0, cell, j + 2]
                thin = max((q - limit) * tail[1, cell, j + 2], least)
                power = _exponential(q if q > limit else thin)
                value = _exponential(x) * (max(power - one, q) if q > limit else limit * power)  # rounding
                values[m, n, j + 2] = value
                sums[j + 2] += value


@kernel(inner=True, fastmath={"contract"})
def _cubic(f: float, out: Any) -> None:
    """Write weights of a cubic through values at -1 to 2 with central slopes (Catmull-Rom), and of 0 and 1 alone."""
    out[0], out[3] = 0.5 * f * (f * (2.0 - f) - 1.0), 0.5 * f * f * (f - 1.0)
    out[1], out[2] = 0.5 * (f * f * (3.0 * f - 5.0) + 2.0), 0.5 * f * (f * (4.0 - 3.0 * f) + 1.0)
    out[4], out[5] = 1.0 - f, f


@kernel(inner=True, fastmath={"contract"})
def _smooth(factor: Any, sums: Any, cell: int, cells: Any, most: float, visible: float, side: int, line: Any) -> None:
    """Write what sums of values lack (0), the same also where it is not known (3: 1 where it is) (1), and for them (2).

    These are logarithms in rows ``cell``, ``cell - 1`` and ``cell - 2``.
    """
    columns = cells.shape[1]
    lack, filled, known = factor[0], factor[1], factor[3]
    one, zero, largest = np.float32(1.0), np.float32(0.0), np.float32(_LARGEST)
    per_sum = side * side / visible
    for j in range(columns):
        visible_part = cells[cell, j]
        found = 0.0 < visible_part < most and sums[j] > zero and 4 <= j < columns - 4
        known[cell, j] = one if found else zero
        lack[cell, j] = np.float32(visible_part * per_sum) / sums[j] if found else one
    _logarithm(lack, lack.view(np.int32), cell, line[0])
    for j in range(columns):
        lack[cell, j] = min(max(lack[cell, j], -largest), largest)
    i = cell - 1
    if i >= 5:  # clear and full cells take the mean of those around
        for j in range(columns):
            line[0, j] = known[i - 1, j] + known[i, j] + known[i + 1, j]
            line[1, j] = lack[i - 1, j] + lack[i, j] + lack[i + 1, j]
        for j in range(columns - 2):
            near = line[0, j] + line[0, j + 1] + line[0, j + 2]
            mean = (line[1, j] + line[1, j + 1] + line[1, j + 2]) / max(near, one)
            filled[i, j + 1] = lack[i, j + 1] if known[i, j + 1] > zero else mean
    i = cell - 2
    if i >= 6:
        visible_part, other, more = np.float32(0.75), np.float32(0.125), np.float32(_BLURRED)
        for j in range(columns):
            line[0, j] = visible_part * filled[i, j] + other * (filled[i - 1, j] + filled[i + 1, j])
        for j in range(columns - 2):
            blurred = visible_part * line[0, j + 1] + other * (line[0, j] + line[0, j + 2])
            factor[2, i, j + 1] = filled[i, j + 1] + more * (filled[i, j + 1] - blurred)


@kernel(inner=True, fastmath={"contract"})
def _weigh(values: Any, sums: Any, highest: Any, factor: Any, cell: int, line: Any) -> None:
    """Multiply values of a row of cells by the factor between cells; write their sums and largest by cell."""
    side, columns = values.shape[1], values.shape[2]
    for j in range(columns):
        sums[j], highest[j] = 0.0, np.float32(0.0)
    for m in range(side):
        f = (m + 0.5) / side - 0.5
        low = cell - 1 if f < 0.0 else cell
        after = np.float32(f - math.floor(f))
        before = np.float32(1.0) - after
        for j in range(columns):
            line[0, j] = before * factor[low, j] + after * factor[low + 1, j]
        for n in range(side):
            g = (n + 0.5) / side - 0.5
            shift = 1 if g > 0.0 else 0
            part = np.float32(g)
            for j in range(columns - 2):
                share = line[0, j + 1] + part * (line[0, j + 1 + shift] - line[0, j + shift])
                value = _exponential(share) * values[m, n, j + 1]
                values[m, n, j + 1] = value
                sums[j + 1] += value
                highest[j + 1] = max(highest[j + 1], value)


@kernel(inner=True, fastmath={"contract"})
def _keep(out: Any, values: Any, scale: Any, highest: Any, cell: int, cells: Any, most: float) -> None:
    """Write the parts of a row of cells with their means, none above ``most``; ``scale``: sums, and room."""
    side, columns = values.shape[1], values.shape[2]
    wide = columns - 2 * MARGIN
    full = scale[1]
    for j in range(columns):
        mean = cells[cell, j]
        partly = 0.0 < mean < most
        scale[0, j] = mean * (side * side) / scale[0, j] if partly else 0.0
        full[j] = 0.0 if partly else min(max(mean, 0.0), most)
    top = (cell - MARGIN) * side
    for m in range(side):
        if side == 4:
            for j in range(wide):
                k = j + MARGIN
                out[top + m, 4 * j] = min(scale[0, k] * values[m, 0, k], most) + full[k]
                out[top + m, 4 * j + 1] = min(scale[0, k] * values[m, 1, k], most) + full[k]
                out[top + m, 4 * j + 2] = min(scale[0, k] * values[m, 2, k], most) + full[k]
                out[top + m, 4 * j + 3] = min(scale[0, k] * values[m, 3, k], most) + full[k]
        else:
            for n in range(side):
                for j in range(wide):
                    k = j + MARGIN
                    out[top + m, side * j + n] = min(scale[0, k] * values[m, n, k], most) + full[k]
    for j in range(wide):
        k = j + MARGIN
        if scale[0, k] * highest[k] > most:
            of_cell = out[top : top + side, side * j : side * (j + 1)]
            _limit(of_cell, values, k, scale[0, k], highest[k], cells[cell, k], most)


@kernel(inner=True, fastmath={"contract"})
def _limit(out: Any, values: Any, column: int, scale: float, highest: float, mean: float, most: float) -> None:
    """Write the parts of a cell some of which would exceed ``most``: they get it, and the rest is for the others."""
    side = out.shape[0]
    wanted = mean * side * side
    for _ in range(_STEPS):
        if scale * highest <= most:
            break
        full, rest = 0, 0.0
        for m in range(side):
            for n in range(side):
                if scale * values[m, n, column] >= most:
                    full += 1
                else:
                    rest += values[m, n, column]
        if rest <= 0.0 or wanted - full * most <= scale * rest:
            break
        scale = (wanted - full * most) / rest
    total = part = 0.0
    for m in range(side):
        for n in range(side):
            total += min(scale * values[m, n, column], most)
    lack = wanted - total
    if abs(lack) > 1e-12 * wanted:  # after the last step: in parts of what each has left
        part = lack / (most * side * side - total if lack > 0.0 else total)
    for m in range(side):
        for n in range(side):
            limited = min(scale * values[m, n, column], most)
            out[m, n] = limited + part * ((most - limited) if lack > 0.0 else limited)


@kernel(inner=True, fastmath={"contract"})
def _logarithm(x: Any, bits: Any, row: int, power: Any) -> None:
    """Replace a row of positive numbers of single precision, whose ``bits`` share their memory, by their logarithms.

    A number is 2^power times one between 1 / sqrt(2) and sqrt(2), for which ln z = 2 artanh((z - 1) / (z + 1)).
    """
    one, two = np.float32(1.0), np.float32(2.0)
    for j in range(x.shape[1]):
        shift = (bits[row, j] - 0x3F3504F3) >> 23
        power[j] = np.float32(shift)
        bits[row, j] = bits[row, j] - (shift << 23)
    for j in range(x.shape[1]):
        s = (x[row, j] - one) / (x[row, j] + one)
        z = s * s
        series = two + z * (np.float32(2 / 3) + z * (np.float32(2 / 5) + z * np.float32(2 / 7)))
        x[row, j] = power[j] * np.float32(math.log(2.0)) + s * series


@kernel(inner=True, fastmath={"contract"})
def _exponential(x: Any) -> Any:
    """Return exp(x), of single precision, for -12 < x < 12: a series of x / 32, squared five times."""
    one = np.float32(1.0)
    y = x * np.float32(0.03125)
    power = one + y * (
        one + y * (np.float32(1 / 2) + y * (np.float32(1 / 6) + y * (np.float32(1 / 24) + y * np.float32(1 / 120))))
    )
    power *= power
    power *= power
    power *= power
    power *= power
    return power * power
