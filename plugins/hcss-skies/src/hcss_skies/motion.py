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


def densify(ranks: Bytes, motion: NDArray[np.int8], block: int, parts: int) -> Bytes:
    """Return frames (pieces, (snapshots - 1) * parts + 1, rows, columns) with ``parts`` intervals for one of a film.

    A frame at a fraction f between snapshots A and B is (1 - f) A(x - f d) + f B(x + (1 - f) d) with the displacement
    d of the clouds there, bilinear. Every ``parts``-th frame is a snapshot. Ranks are linear in the score.
    """
    return _between(ranks, motion, block, parts, False)


def densify_heights(heights: Bytes, motion: NDArray[np.int8], block: int, parts: int) -> Bytes:
    """Return frames of tops or bases as :func:`densify`, but means of cloud alone: 0, clear sky, has no weight.

    Cloud of the frames of ranks is cloud here, too; here it reaches further, by as much as snapshots disagree.
    """
    return _between(heights, motion, block, parts, True)


def _between(field: Bytes, motion: NDArray[np.int8], block: int, parts: int, holes: bool) -> Bytes:
    pieces, snapshots, rows, columns = field.shape
    out = np.empty((pieces, (snapshots - 1) * parts + 1, rows, columns), np.uint8)
    out[:, ::parts] = field
    for piece in range(pieces):
        for n in range(snapshots - 1):
            for part in range(1, parts):
                frame = out[piece, n * parts + part]
                _frame(frame, field[piece, n], field[piece, n + 1], motion[piece, n], block, part / parts, holes)
    return out


@kernel(fastmath={"contract"}, error_model="numpy")
def _frame(out: Any, before: Any, after: Any, motion: Any, block: int, f: float, holes: bool) -> None:
    """Write the frame (rows, columns) at a fraction of the interval."""
    rows, columns = out.shape
    block_columns = motion.shape[2]
    along_y, along_x = np.empty(block_columns + 1, np.float32), np.empty(block_columns + 1, np.float32)
    back, ahead, per_block = np.float32(f), np.float32(1.0 - f), np.float32(1.0 / block)
    half, zero = np.float32(0.5), np.float32(0.0)
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
            a, of_a = _bilinear(before, i, j, -back * dy, -back * dx, holes)
            b, of_b = _bilinear(after, i, j, ahead * dy, ahead * dx, holes)
            total = ahead * of_a + back * of_b
            value = (ahead * a + back * b) / total if total > zero else zero
            out[i, j] = np.uint8(value + half)


@kernel(inner=True, fastmath={"contract"}, error_model="numpy")
def _bilinear(field: Any, i: int, j: int, dy: Any, dx: Any, holes: bool) -> Any:
    """Return weighted sum and sum of weights around a cell moved by (dy, dx), periodic; 0 may have no weight."""
    rows, columns = field.shape
    floor_y, floor_x = np.floor(dy), np.floor(dx)
    fy, fx = dy - floor_y, dx - floor_x
    top, left = i + int(floor_y), j + int(floor_x)
    below, right = top + 1, left + 1
    if top < 0 or below >= rows:
        top, below = top % rows, below % rows
    if left < 0 or right >= columns:
        left, right = left % columns, right % columns
    one = np.float32(1.0)
    v00, v01 = np.float32(field[top, left]), np.float32(field[top, right])
    v10, v11 = np.float32(field[below, left]), np.float32(field[below, right])
    upper, lower = v00 + fx * (v01 - v00), v10 + fx * (v11 - v10)
    total = upper + fy * (lower - upper)
    if not holes:
        return total, one
    zero = np.float32(0.0)
    w00, w01 = (one if v00 > zero else zero), (one if v01 > zero else zero)
    w10, w11 = (one if v10 > zero else zero), (one if v11 > zero else zero)
    upper, lower = w00 + fx * (w01 - w00), w10 + fx * (w11 - w10)
    return total, upper + fy * (lower - upper)
