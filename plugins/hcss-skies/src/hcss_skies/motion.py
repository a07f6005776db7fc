"""Motion of clouds between the snapshots of a film, and frames between snapshots in which clouds move with it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from hcss_skies.film import MAX_CELLS, PER_CELL, Bytes
from hcss_twin.core.kernels import kernel
from hcss_twin.providers import Array

_SMOOTH_CELLS = 1.0
"""Scores are smoothed so before they are compared: single cells flicker."""

_WINDOW = np.array([1.0, 3.0, 3.0, 1.0]) / 8.0
"""Weights of the quarters of a window of two blocks."""

_DOUBT = 0.03
"""Misfit per cell and squared cell away from the mean motion that is added: windows without structure follow it."""

_SPREAD = np.array([1.0, 2.0, 1.0]) / 4.0
"""Weights of neighbouring blocks."""


def motion_between(ranks: Bytes, block: int) -> NDArray[np.int8]:
    """Return displacements to the next snapshot (pieces, snapshots - 1, 2, block_rows, block_columns) in 1/16 cells.

    In windows of two blocks around the middle of each block, the squared difference of smoothed ranks is least; below
    a cell the minimum is that of a parabola. Displacements are smoothed over neighbouring blocks with the structure in
    the windows as weights; where there is none they are the mean motion of the snapshot.

    Parameters
    ----------
    ranks : ndarray of uint8 (pieces, snapshots, rows, columns)
        Of a film, periodic.
    block : int
        Cells along a side of a block.
    """
    smooth = gaussian_filter(ranks.astype(np.float32), (0.0, 0.0, _SMOOTH_CELLS, _SMOOTH_CELLS), mode="wrap")
    pieces, snapshots, rows, columns = ranks.shape
    motion = np.zeros((pieces, snapshots - 1, 2, rows // block, columns // block), np.int8)
    for piece, n in np.ndindex(pieces, snapshots - 1):
        found = _displacements(smooth[piece, n], smooth[piece, n + 1], block)
        limit = MAX_CELLS * PER_CELL
        motion[piece, n] = np.clip(np.rint(found * PER_CELL), -limit, limit)
    return motion


def _displacements(before: NDArray[np.float32], after: NDArray[np.float32], block: int) -> Array:
    """Return displacements (2, block_rows, block_columns) in cells."""
    reach = int(MAX_CELLS) + 1
    wide = 2 * reach + 1
    quarters = _quarters(block)
    misfit = np.empty((wide, wide, before.shape[0] // block, before.shape[1] // block))
    padded = np.pad(after, reach, mode="wrap")
    for i, j in np.ndindex(wide, wide):
        moved = padded[i : i + before.shape[0], j : j + before.shape[1]]
        misfit[i, j] = _windows((moved - before) ** 2, block, quarters)
    structure = (
        _windows((before - before.mean()) ** 2, block, quarters)
        - _windows(before - before.mean(), block, quarters) ** 2
    )
    offsets = np.arange(-reach, reach + 1.0)
    total = misfit.mean(axis=(2, 3))
    mean = np.array([float(part) for part in _minimum(total[:, :, None, None])[:, 0, 0]])
    away = np.add.outer((offsets - mean[0]) ** 2, (offsets - mean[1]) ** 2)
    own = _minimum(misfit + _DOUBT * away[:, :, None, None])
    weight = np.maximum(structure, 0.0)
    spread = _spread(weight)
    least = 0.02 * float(weight.mean()) + 1e-9
    smooth: Array = (_spread(own * weight) + mean[:, None, None] * least) / (spread + least)
    return smooth


def _quarters(block: int) -> int:
    """Return into how many parts along an axis a block is cut, for windows of two blocks about its middle."""
    return 2 if block % 2 == 0 else 1


def _windows(field: Any, block: int, quarters: int) -> Array:
    """Return weighted means (block_rows, block_columns) over windows of two blocks about the middle of each block."""
    part = block // quarters
    rows, columns = field.shape[0] // part, field.shape[1] // part
    cells: Any = field.reshape(rows, part, columns, part).mean(axis=(1, 3), dtype=np.float64)
    if quarters == 1:
        return _spread(cells)
    for axis in (0, 1):
        cells = sum(weight * np.roll(cells, 1 - k, axis) for k, weight in enumerate(_WINDOW))
        cells = cells[::2] if axis == 0 else cells[:, ::2]
    values: Array = cells
    return values


def _spread(field: Any) -> Array:
    """Return means over neighbouring blocks of the last two axes, periodic."""
    for axis in (-2, -1):
        field = sum(weight * np.roll(field, k - 1, axis) for k, weight in enumerate(_SPREAD))
    values: Array = field
    return values


def _minimum(misfit: Array) -> Array:
    """Return the places (2, ...) of the least misfit (wide, wide, ...) from the middle, with parabolas along axes."""
    wide = misfit.shape[0]
    inner = misfit[1:-1, 1:-1].reshape((wide - 2) ** 2, *misfit.shape[2:])
    least = np.argmin(inner, axis=0)
    i, j = least // (wide - 2) + 1, least % (wide - 2) + 1
    p, q = np.indices(misfit.shape[2:])
    at = misfit[i, j, p, q]
    found = []
    for low, high, place in ((misfit[i - 1, j, p, q], misfit[i + 1, j, p, q], i),
                             (misfit[i, j - 1, p, q], misfit[i, j + 1, p, q], j)):  # fmt: skip
        bend = low - 2.0 * at + high
        share = np.where(bend > 0.0, 0.5 * (low - high) / np.where(bend > 0.0, bend, 1.0), 0.0)
        found.append(place - wide // 2 + np.clip(share, -0.5, 0.5))
    return np.stack(found)


def densify(field: Bytes, motion: NDArray[np.int8], block: int, parts: int) -> Bytes:
    """Return frames (pieces, (snapshots - 1) * parts, rows, columns), ``parts`` for each interval of a film.

    A frame at a fraction f between snapshots A and B is (1 - f) A(x - f d) + f B(x + (1 - f) d) with the displacement
    d of the clouds there, bilinear; ranks are linear in the score. Frames are in the middles of parts: the snapshots
    themselves, which are sharper, would pulse between them.

    Parameters
    ----------
    field : ndarray of uint8 (pieces, snapshots, rows, columns)
        Ranks of a film, or :func:`filled` heights.
    """
    pieces, snapshots, rows, columns = field.shape
    out = np.empty((pieces, (snapshots - 1) * parts, rows, columns), np.uint8)
    for piece in range(pieces):
        for number in range(out.shape[1]):
            n, part = divmod(number, parts)
            both = field[piece, n], field[piece, n + 1]
            _frame(out[piece, number], *both, motion[piece, n], block, (part + 0.5) / parts)
    return out


def filled(heights: Bytes) -> Bytes:
    """Return heights (..., rows, columns), periodic, with those of cloud nearby where they are 0, clear.

    They are means of cloud over squares that double until they hold some, interpolated.
    """
    values: Any = _filled(heights.astype(np.float32), (heights > 0).astype(np.float32))
    result: Bytes = np.where(heights > 0, heights, np.rint(values)).astype(np.uint8)
    return result


def _filled(heights: Any, weight: Any) -> Any:
    """Return heights where there is weight, else those of squares of 2 x 2, recursively; periodic."""
    rows, columns = heights.shape[-2:]
    if rows % 2 or columns % 2:
        total = weight.sum(axis=(-2, -1), keepdims=True)
        mean = (heights * weight).sum(axis=(-2, -1), keepdims=True) / np.maximum(total, 1e-6)
        return np.where(weight > 0.0, heights, mean)
    squares = *heights.shape[:-2], rows // 2, 2, columns // 2, 2
    total = weight.reshape(squares).sum(axis=(-3, -1))
    mean = (heights * weight).reshape(squares).sum(axis=(-3, -1)) / np.maximum(total, 1e-6)
    coarse = _filled(mean, np.minimum(total, 1.0))
    for axis in (-2, -1):  # bilinear
        near = [0.75 * coarse + 0.25 * np.roll(coarse, by, axis) for by in (1, -1)]
        doubled = list(coarse.shape)
        doubled[axis] *= 2
        coarse = np.stack(near, axis=coarse.ndim + axis + 1).reshape(doubled)
    return np.where(weight > 0.0, heights, coarse)


@kernel(fastmath={"contract"})
def _frame(out: Any, before: Any, after: Any, motion: Any, block: int, f: float) -> None:
    """Write the frame (rows, columns) at a fraction of the interval."""
    rows, columns = out.shape
    block_columns = motion.shape[2]
    along_y, along_x = np.empty(block_columns + 1, np.float32), np.empty(block_columns + 1, np.float32)
    back, ahead, per_block = np.float32(f), np.float32(1.0 - f), np.float32(1.0 / block)
    half = np.float32(0.5)
    for i in range(rows):
        at = (np.float32(i) + half) * per_block - half
        low = int(np.floor(at))
        share = at - np.float32(low)
        first, second = low % motion.shape[1], (low + 1) % motion.shape[1]
        # displacements of this row in cells at the middles of blocks, the last one again before the first
        for k in range(block_columns + 1):
            n = (k - 1) % block_columns
            y = motion[0, first, n] + share * (motion[0, second, n] - motion[0, first, n])
            x = motion[1, first, n] + share * (motion[1, second, n] - motion[1, first, n])
            along_y[k], along_x[k] = y / np.float32(PER_CELL), x / np.float32(PER_CELL)
        for j in range(columns):
            place = (np.float32(j) + half) * per_block + half
            k = int(place)
            part = place - np.float32(k)
            after_k = k + 1 if k < block_columns else 1
            dy = along_y[k] + part * (along_y[after_k] - along_y[k])
            dx = along_x[k] + part * (along_x[after_k] - along_x[k])
            a = _bilinear(before, i, j, -back * dy, -back * dx)
            b = _bilinear(after, i, j, ahead * dy, ahead * dx)
            out[i, j] = np.uint8(ahead * a + back * b + half)


@kernel(inner=True, fastmath={"contract"})
def _bilinear(field: Any, i: int, j: int, dy: Any, dx: Any) -> Any:
    """Return the value at a cell moved by (dy, dx), periodic."""
    rows, columns = field.shape
    floor_y, floor_x = np.floor(dy), np.floor(dx)
    fy, fx = dy - floor_y, dx - floor_x
    top, left = i + int(floor_y), j + int(floor_x)
    below, right = top + 1, left + 1
    if top < 0 or below >= rows:
        top, below = top % rows, below % rows
    if left < 0 or right >= columns:
        left, right = left % columns, right % columns
    v00, v01 = np.float32(field[top, left]), np.float32(field[top, right])
    v10, v11 = np.float32(field[below, left]), np.float32(field[below, right])
    upper, lower = v00 + fx * (v01 - v00), v10 + fx * (v11 - v10)
    return upper + fy * (lower - upper)
