"""Numbers that make detail ragged: an octave of random textures for each halving, fibres where cells have a direction.

``refining.py`` has what becomes of them.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.kernels import kernel

SIDE, DIRECTIONS = 256, 16
"""Period of textures in parts of cells, a power of two, and the number of their directions."""

FLOOR = 0.02

# Relative changes above this are edges, which have no more detail than others.
_STEEPEST = 4.0

# Displacement of edges in cells per unit of the numbers: edges are ragged.
_EDGE = 0.3

# Part of fibres in the numbers where the direction is the same in 3 x 3 cells, wavenumber and width of an octave in
# cycles per part, and width of the direction of fibres.
_ALIGNED, _WAVENUMBER, _OCTAVE, _SPREAD = 0.8, 0.22, 0.4, 0.35

# Standard deviation of textures: half of the memory of single precision, the reading of which takes most of their time.
_UNIT = 5000.0

# Textures are longer than their period by the most parts of a cell.
_PADDED = SIDE + 16

# Tangents of the doubled angles at which one direction ends and the next begins.
_ENDS = tuple(math.tan((2 * n + 1) * math.pi / DIRECTIONS) for n in range(DIRECTIONS // 4))


def textures() -> NDArray[np.int16]:
    """Return periodic textures (1 + DIRECTIONS, SIDE, padded) in units: one without direction, then fibres."""
    spectra = [np.fft.rfft2(np.random.default_rng([21, n]).standard_normal((SIDE, SIDE))) for n in range(2)]
    ky, kx = np.meshgrid(np.fft.fftfreq(SIDE), np.fft.rfftfreq(SIDE), indexing="ij")
    k = np.maximum(np.hypot(ky, kx), 1e-9)
    octave = np.exp(-0.5 * (np.log(k / _WAVENUMBER) / _OCTAVE) ** 2)
    fields = [np.fft.irfft2(spectra[0] * octave)]
    for turn in math.pi / DIRECTIONS * np.arange(DIRECTIONS):
        off = 1.0 - ((np.cos(turn) * kx + np.sin(turn) * ky) / k) ** 2
        fields.append(np.fft.irfft2(spectra[1] * octave * np.exp(-0.5 * off / _SPREAD**2)))
    scaled = np.stack([np.rint(_UNIT / field.std() * field) for field in fields])
    return np.pad(scaled, ((0, 0), (0, 0), (0, _PADDED - SIDE)), mode="wrap").astype(np.int16)


@kernel(inner=True, fastmath={"contract"})
def orient(change: Any, fibres: Any, which: Any, cells: Any, seen: Any, strength: float) -> None:
    """Write what numbers change by cell (relatively; what is seen), the parts of textures, and where fibres begin.

    The direction is that of the structure tensor of 3 x 3 cells (J. Weickert, "Coherence-enhancing diffusion
    filtering", Int. J. Comput. Vis. 31, 111, 1999, eq 3).
    """
    rows, columns = cells.shape
    tensor, line = np.zeros((3, rows, columns), np.float32), np.empty((3, columns), np.float32)
    edge, half = np.float32(_EDGE if strength > 0.0 else 0.0), np.float32(0.5)
    part, ninth, least, floor = np.float32(strength), np.float32(1.0 / 9.0), np.float32(1e-6), np.float32(FLOOR)
    steepest, two, aligned = np.float32(_STEEPEST), np.float32(2.0), np.float32(_ALIGNED)
    one, zero, tiny = np.float32(1.0), np.float32(0.0), np.float32(1e-9)
    a, b, c, d = np.float32(_ENDS[0]), np.float32(_ENDS[1]), np.float32(_ENDS[2]), np.float32(_ENDS[3])
    for i in range(1, rows - 1):
        for j in range(columns):
            line[0, j] = np.float32(cells[i - 1, j]) + np.float32(cells[i, j]) + np.float32(cells[i + 1, j])
        for j in range(columns - 2):
            y = half * np.float32(cells[i + 1, j + 1] - cells[i - 1, j + 1])
            x = half * np.float32(cells[i, j + 2] - cells[i, j])
            mean = ninth * (line[0, j] + line[0, j + 1] + line[0, j + 2])
            change[0, i, j + 1] = part * np.sqrt(min(np.sqrt(y * y + x * x) / max(mean, least), steepest) + floor)
            y, x = half * (seen[i + 1, j + 1] - seen[i - 1, j + 1]), half * (seen[i, j + 2] - seen[i, j])
            change[1, i, j + 1] = edge * np.sqrt(y * y + x * x)
            tensor[0, i, j + 1], tensor[1, i, j + 1] = x * x - y * y, two * x * y
            tensor[2, i, j + 1] = x * x + y * y
    for i in range(2, rows - 2):
        which[i, 0] = which[i, columns - 1] = np.int32(0)
        for k in range(3):
            for j in range(columns):
                line[k, j] = tensor[k, i - 1, j] + tensor[k, i, j] + tensor[k, i + 1, j]
        for j in range(columns - 2):
            p = line[0, j] + line[0, j + 1] + line[0, j + 2]
            q = line[1, j] + line[1, j + 1] + line[1, j + 2]
            total = line[2, j] + line[2, j + 1] + line[2, j + 2] + tiny
            fibre = aligned * np.sqrt(np.sqrt(p * p + q * q) / total)
            fibres[0, i, j + 1], fibres[1, i, j + 1] = fibre, np.sqrt(one - fibre * fibre)
            x, y = abs(p), abs(q)
            turn = (1 if y > a * x else 0) + (1 if y > b * x else 0) + (1 if y > c * x else 0) + (1 if y > d * x else 0)
            turn = DIRECTIONS // 2 - turn if p < zero else turn
            turn = -turn if q < zero else turn
            which[i, j + 1] = SIDE * _PADDED * (1 + (turn & (DIRECTIONS - 1)))


@kernel(inner=True, fastmath={"contract"})
def number(
    numbers: Any, coarser: Any, cell: int, fibres: Any, which: Any, first: Any, textures: Any, places: Any, parts: Any
) -> None:
    """Write the numbers (side, side, columns) of a row of cells: between those of coarser parts, and an octave."""
    side, columns = numbers.shape[1], numbers.shape[2]
    near, far, zero = np.float32(0.75), np.float32(0.25), np.float32(0.0)
    half = side // 2
    line = np.empty((half, columns), np.float32)
    column = np.empty((2, columns), np.uint64)
    for m in range(side):
        if side == 2:
            for n in range(2):
                for j in range(columns):
                    numbers[m, n, j] = zero
        else:
            nearest = m // 2
            other, above = nearest + (1 if m % 2 else -1), cell
            if other < 0:
                other, above = half - 1, cell - 1
            elif other == half:
                other, above = 0, cell + 1
            for n in range(half):
                for j in range(columns):
                    line[n, j] = near * coarser[cell, nearest, n, j] + far * coarser[above, other, n, j]
            for n in range(side):
                nearest = n // 2
                other, shift = nearest + (1 if n % 2 else -1), 1
                if other < 0:
                    other, shift = half - 1, 0
                elif other == half:
                    other, shift = 0, 2
                for j in range(columns - 2):
                    numbers[m, n, j + 1] = near * line[nearest, j + 1] + far * line[other, j + shift]
    for use in range(2):
        part = np.float32(parts[use] / _UNIT)
        if part == zero:
            continue
        for j in range(columns):
            column[0, j] = (first[1] + j) * side + places[use, 1] & (SIDE - 1)
            column[1, j] = column[0, j] + which[cell, j]
        for m in range(side):
            row = np.uint64(((first[0] + cell) * side + m + places[use, 0] & (SIDE - 1)) * _PADDED)
            for n in range(0, side, 2):
                left = row + np.uint64(n)
                right = left + np.uint64(1)
                for j in range(columns):
                    along, other = part * fibres[0, cell, j], part * fibres[1, cell, j]
                    numbers[m, n, j] += along * np.float32(textures[left + column[1, j]]) + other * np.float32(
                        textures[left + column[0, j]]
                    )
                    numbers[m, n + 1, j] += along * np.float32(textures[right + column[1, j]]) + other * np.float32(
                        textures[right + column[0, j]]
                    )
