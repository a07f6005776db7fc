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
from numpy.typing import NDArray

from hcss_twin.core.kernels import inner, kernel

MARGIN = 7
"""Cells around those that are divided."""

STAGE = 2
"""Most halvings at a time."""

SIDE, DIRECTIONS = 256, 16
"""Period of textures in parts of cells, and the number of their directions."""

FLOOR = 0.02

# Relative changes above this are edges, which have no more detail than others.
_STEEPEST = 4.0

# Depth of clear cells in parts of the highest beside them, and displacement of edges in cells per unit of the numbers:
# edges are ragged, and stay inside the cloudy cells but for few.
_CLEAR, _EDGE = 2.5, 0.3

# Part of a cell's own value below which thickness falls exponentially: never 0, so that every mean can be reached.
_TAIL = 0.1

# What interpolation blurs of the factor is added beforehand, in parts of the difference to its blurred self.
_BLURRED, _LARGEST = 1.5, 2.0

# Part of fibres in the numbers where the direction is the same in 3 x 3 cells, wavenumber and width of an octave in
# cycles per part, and width of the direction of fibres.
_ALIGNED, _WAVENUMBER, _OCTAVE, _SPREAD = 0.8, 0.22, 0.4, 0.35

# Textures are longer than their period by what a cell reads at most.
_PADDED = SIDE + 2**STAGE

_STEPS = 8


def textures() -> NDArray[np.float32]:
    """Return periodic textures (1 + DIRECTIONS, SIDE, padded) of variance 1: one without direction, then fibres."""
    spectra = [np.fft.rfft2(np.random.default_rng([21, n]).standard_normal((SIDE, SIDE))) for n in range(2)]
    ky, kx = np.meshgrid(np.fft.fftfreq(SIDE), np.fft.rfftfreq(SIDE), indexing="ij")
    k = np.maximum(np.hypot(ky, kx), 1e-9)
    octave = np.exp(-0.5 * (np.log(k / _WAVENUMBER) / _OCTAVE) ** 2)
    fields = [np.fft.irfft2(spectra[0] * octave)]
    for turn in math.pi / DIRECTIONS * np.arange(DIRECTIONS):
        off = 1.0 - ((np.cos(turn) * kx + np.sin(turn) * ky) / k) ** 2
        fields.append(np.fft.irfft2(spectra[1] * octave * np.exp(-0.5 * off / _SPREAD**2)))
    scaled = np.stack([each / each.std() for each in fields])
    return np.pad(scaled, ((0, 0), (0, 0), (0, _PADDED - SIDE)), mode="wrap").astype(np.float32)


@kernel(fastmath={"contract"})
def refine(
    out: Any, cells: Any, first: Any, strength: float, deviations: Any, most: float, visible: float, textures: Any,
    places: Any, parts: Any,
) -> None:  # fmt: skip
    """Write the parts of cells without the ``MARGIN`` outermost ones.

    Parameters
    ----------
    out : ndarray of float64 ((rows - 14) 2^halvings, (columns - 14) 2^halvings)
        Thickness in m.
    cells : ndarray of float64 (rows, columns)
        Thickness in m.
    first : ndarray of int64 (2,)
        Indices of the first cell.
    strength : float
        Standard deviation of the logarithm of thickness where it changes by itself from cell to cell; 0: no detail.
    deviations : ndarray of float64 (halvings,)
        Standard deviation of each octave in parts of it.
    most, visible : float
        Greatest thickness, and the thickness with an optical thickness of about 1.
    textures : ndarray of float32
        Of :func:`textures`.
    places, parts : ndarray of int64 (halvings, 2, 2), of float64 (halvings, 2)
        Where two uses of the textures begin, and their parts in the numbers.
    """
    rows, columns = cells.shape
    side = 1 << deviations.size
    seen, level = np.empty((rows, columns)), np.empty((rows, columns))
    _see(seen, level, cells, visible)
    change, fibres = np.zeros((2, rows, columns)), np.zeros((rows, columns))
    which = np.zeros((rows, columns), np.int64)
    _orient(change, fibres, which, cells, seen, strength)
    numbers = np.zeros((1, 1), np.float32)
    for octave in range(deviations.size):
        finer = np.zeros(((rows - 6) * (2 << octave), (columns - 6) * (2 << octave)), np.float32)
        if octave:
            _double(finer, numbers)
        if strength > 0.0:
            _add(finer, fibres, which, first, 2 << octave, textures, places[octave], parts[octave] * deviations[octave])
        numbers = finer
    values = np.empty(((rows - 8) * side, (columns - 8) * side), np.float32)
    factor = np.zeros((rows, columns))
    _shape(values, factor, seen, level, change, numbers, side)
    _smooth(factor, cells, most, visible, side)
    for i in range(MARGIN, rows - MARGIN):
        for j in range(MARGIN, columns - MARGIN):
            y, x = (i - MARGIN) * side, (j - MARGIN) * side
            own = out[y : y + side, x : x + side]
            if 0.0 < cells[i, j] < most:
                y, x = (i - 4) * side, (j - 4) * side
                _keep(own, values[y : y + side, x : x + side], factor[i - 1 : i + 2, j - 1 : j + 2], cells[i, j], most)
            else:
                own[:] = min(max(cells[i, j], 0.0), most)


@inner(fastmath={"contract"})
def _see(seen: Any, level: Any, cells: Any, visible: float) -> None:
    """Write what is seen of cells, and the same with clear cells below 0."""
    rows, columns = cells.shape
    for i in range(rows):
        for j in range(columns):
            seen[i, j] = level[i, j] = math.log(1.0 + max(cells[i, j], 0.0) / visible)
    for i in range(1, rows - 1):
        for j in range(1, columns - 1):
            if cells[i, j] <= 0.0:
                level[i, j] = -_CLEAR * np.max(seen[i - 1 : i + 2, j - 1 : j + 2])


@inner(fastmath={"contract"})
def _orient(change: Any, fibres: Any, which: Any, cells: Any, seen: Any, strength: float) -> None:
    """Write what numbers change by cell (relatively; what is seen), the part of fibres, and their texture.

    The direction is that of the structure tensor of 3 x 3 cells (J. Weickert, "Coherence-enhancing diffusion
    filtering", Int. J. Comput. Vis. 31, 111, 1999, eq 3).
    """
    rows, columns = cells.shape
    tensor = np.zeros((3, rows, columns))
    edge = _EDGE if strength > 0.0 else 0.0
    for i in range(1, rows - 1):
        for j in range(1, columns - 1):
            y, x = 0.5 * (cells[i + 1, j] - cells[i - 1, j]), 0.5 * (cells[i, j + 1] - cells[i, j - 1])
            mean = np.sum(cells[i - 1 : i + 2, j - 1 : j + 2]) / 9.0
            change[0, i, j] = strength * math.sqrt(min(math.sqrt(y * y + x * x) / max(mean, 1e-6), _STEEPEST) + FLOOR)
            y, x = 0.5 * (seen[i + 1, j] - seen[i - 1, j]), 0.5 * (seen[i, j + 1] - seen[i, j - 1])
            change[1, i, j] = edge * math.sqrt(y * y + x * x)
            tensor[0, i, j], tensor[1, i, j], tensor[2, i, j] = x * x - y * y, 2.0 * x * y, x * x + y * y
    for i in range(2, rows - 2):
        for j in range(2, columns - 2):
            p, q, total = 0.0, 0.0, 1e-9
            for m in range(i - 1, i + 2):
                for n in range(j - 1, j + 2):
                    p, q, total = p + tensor[0, m, n], q + tensor[1, m, n], total + tensor[2, m, n]
            fibres[i, j] = _ALIGNED * math.sqrt(math.sqrt(p * p + q * q) / total)
            turn = math.atan2(q, p) * (0.5 / math.pi * DIRECTIONS) + DIRECTIONS + 0.5
            which[i, j] = 1 + np.int64(turn) % DIRECTIONS


@inner(fastmath={"contract"})
def _double(finer: Any, numbers: Any) -> None:
    """Write numbers (2 rows, 2 columns) between those of coarser parts, bilinear; those at the border are not right."""
    near, far = np.float32(0.75), np.float32(0.25)
    rows, columns = numbers.shape
    line = np.empty(columns, np.float32)
    for i in range(2 * rows):
        own, other = i // 2, min(max(i // 2 + (1 if i % 2 else -1), 0), rows - 1)
        for j in range(columns):
            line[j] = near * numbers[own, j] + far * numbers[other, j]
        for j in range(1, columns - 1):
            finer[i, 2 * j] = near * line[j] + far * line[j - 1]
            finer[i, 2 * j + 1] = near * line[j] + far * line[j + 1]


@inner(fastmath={"contract"})
def _add(numbers: Any, fibres: Any, which: Any, first: Any, side: int, textures: Any, places: Any, parts: Any) -> None:
    """Add an octave to numbers of cells without the three outermost ones."""
    for use in range(2):
        if parts[use] == 0.0:
            continue
        for i in range(numbers.shape[0]):
            cell = i // side + 3
            row = ((first[0] + 3) * side + i + places[use, 0]) & (SIDE - 1)
            for own in range(3, fibres.shape[1] - 3):
                column = ((first[1] + own) * side + places[use, 1]) & (SIDE - 1)
                along = np.float32(parts[use] * fibres[cell, own])
                other = np.float32(parts[use] * math.sqrt(1.0 - fibres[cell, own] ** 2))
                fibre = textures[which[cell, own], row, column : column + side]
                plain = textures[0, row, column : column + side]
                target = numbers[i, (own - 3) * side : (own - 2) * side]
                for j in range(side):
                    target[j] += along * fibre[j] + other * plain[j]


@inner(fastmath={"contract"})
def _shape(values: Any, sums: Any, seen: Any, level: Any, change: Any, numbers: Any, side: int) -> None:
    """Write thickness over the visible one without the four outermost cells, and its sums by cell."""
    columns = seen.shape[1]
    taps = np.empty((side, 6), np.float32)  # of the cubic, then of the linear interpolation
    for n in range(side):
        f = (n + 0.5) / side - 0.5
        _cubic(f - math.floor(f), taps[n])
    line, own_tail = np.empty((3, columns), np.float32), np.empty(values.shape[1], np.float32)
    q, x = np.empty(values.shape[1], np.float32), np.empty(values.shape[1], np.float32)
    zero, one, least = np.float32(0.0), np.float32(1.0), np.float32(-11.0)
    for i in range(values.shape[0]):
        cell, tap = i // side + 4, taps[i % side]
        low = cell - 1 if 2 * (i % side) + 1 < side else cell
        for j in range(columns):
            line[0, j] = (
                tap[0] * level[low - 1, j] + tap[1] * level[low, j] + tap[2] * level[low + 1, j]
                + tap[3] * level[low + 2, j]
            )  # fmt: skip
            line[1, j] = tap[4] * change[0, low, j] + tap[5] * change[0, low + 1, j]
            line[2, j] = tap[4] * change[1, low, j] + tap[5] * change[1, low + 1, j]
        for own in range(4, columns - 4):
            tail = np.float32(_TAIL * seen[cell, own] + 1e-9)
            for n in range(side):
                tap, j = taps[n], (own - 4) * side + n
                m = own - 1 if 2 * n + 1 < side else own
                number = numbers[i + side, j + side]
                q[j] = (
                    tap[0] * line[0, m - 1] + tap[1] * line[0, m] + tap[2] * line[0, m + 1] + tap[3] * line[0, m + 2]
                    + number * (tap[4] * line[2, m] + tap[5] * line[2, m + 1])
                )  # fmt: skip
                x[j] = number * (tap[4] * line[1, m] + tap[5] * line[1, m + 1])
                own_tail[j] = tail
        for j in range(q.size):
            tail = own_tail[j]
            thick = max(_exponential(max(q[j], zero)) - one, q[j])  # rounding
            thin = tail * _exponential(min(max((q[j] - tail) / tail, least), zero))
            values[i, j] = _exponential(x[j]) * (thick if q[j] > tail else thin)
        for own in range(4, columns - 4):
            sums[cell, own] += np.sum(values[i, (own - 4) * side : (own - 3) * side])


@inner(fastmath={"contract"})
def _cubic(f: float, out: Any) -> None:
    """Write weights of a cubic through values at -1 to 2 with central slopes (Catmull-Rom), and of 0 and 1 alone."""
    out[0], out[3] = 0.5 * f * (f * (2.0 - f) - 1.0), 0.5 * f * f * (f - 1.0)
    out[1], out[2] = 0.5 * (f * f * (3.0 * f - 5.0) + 2.0), 0.5 * f * (f * (4.0 - 3.0 * f) + 1.0)
    out[4], out[5] = 1.0 - f, f


@inner(fastmath={"contract"})
def _smooth(factor: Any, cells: Any, most: float, visible: float, side: int) -> None:
    """Replace sums of values by what they lack, such that interpolation between cells gives about that to each."""
    rows, columns = cells.shape
    lack, known = np.zeros((rows, columns)), np.zeros((rows, columns))
    for i in range(4, rows - 4):
        for j in range(4, columns - 4):
            if 0.0 < cells[i, j] < most and factor[i, j] > 0.0:
                ratio = math.log(cells[i, j] / visible * side * side / factor[i, j])
                lack[i, j], known[i, j] = min(max(ratio, -_LARGEST), _LARGEST), 1.0
    filled = lack.copy()
    for i in range(5, rows - 5):
        for j in range(5, columns - 5):
            if known[i, j] == 0.0:  # clear and full cells take the mean of those around
                near = np.sum(known[i - 1 : i + 2, j - 1 : j + 2])
                filled[i, j] = np.sum(lack[i - 1 : i + 2, j - 1 : j + 2]) / max(near, 1.0)
    for i in range(6, rows - 6):
        for j in range(6, columns - 6):
            blurred = 0.0
            for m in range(-1, 2):
                for n in range(-1, 2):
                    blurred += filled[i + m, j + n] * (0.125 if m else 0.75) * (0.125 if n else 0.75)
            factor[i, j] = filled[i, j] + _BLURRED * (filled[i, j] - blurred)


@inner(fastmath={"contract"})
def _keep(out: Any, values: Any, factor: Any, mean: float, most: float) -> None:
    """Write the parts of a cell with this mean, none above ``most``; ``factor`` (3, 3): logarithms around it."""
    side = out.shape[0]
    total = highest = 0.0
    for m in range(side):
        f = (m + 0.5) / side - 0.5
        low = 0 if f < 0.0 else 1
        f -= math.floor(f)
        left, middle, right = (1.0 - f) * factor[low] + f * factor[low + 1]
        for n in range(side):
            g = (n + 0.5) / side - 0.5
            share = middle + g * (right - middle if g > 0.0 else middle - left)
            out[m, n] = _exponential(np.float32(share)) * values[m, n]
            total += out[m, n]
            highest = max(highest, out[m, n])
    wanted = mean * side * side
    scale = wanted / total
    for _ in range(_STEPS):
        if scale * highest <= most:
            break
        # What would exceed the greatest thickness gets it; the rest is for the others.
        full, rest = 0, 0.0
        for m in range(side):
            for n in range(side):
                if scale * out[m, n] >= most:
                    full += 1
                else:
                    rest += out[m, n]
        if rest <= 0.0 or wanted - full * most <= scale * rest:
            break
        scale = (wanted - full * most) / rest
    total = 0.0
    for m in range(side):
        for n in range(side):
            out[m, n] = min(scale * out[m, n], most)
            total += out[m, n]
    lack = wanted - total
    if abs(lack) > 1e-12 * wanted:  # after the last step: in parts of what each has left
        part = lack / (most * side * side - total if lack > 0.0 else total)
        for m in range(side):
            for n in range(side):
                out[m, n] += part * ((most - out[m, n]) if lack > 0.0 else out[m, n])


@inner(fastmath={"contract"})
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
