"""Inner loops of eqs 2-4 of the HCSS paper: interpolation of lattice nodes and sum over octaves, row by row.

The paper specifies "cubic interpolation" in eq 2; this is the cubic convolution of Keys (1981, IEEE Trans. ASSP 29,
1153, eq 15: a = -1/2). Interpolating independent numbers averages them: in three dimensions the mean variance falls to
0.54, and frames pulse as the time coordinate passes through a cell. Dividing the weights of each axis by the root of
their sum of squares makes the variance 1 everywhere, so that eq 5 gives a uniform p.

The sum over 4 x 4 x 4 nodes factorises. Time planes are blended on the lattice, which is usually much coarser than the
image; each lattice row is then interpolated at the pixels' columns, once; and each pixel row is a weighted sum of four
such rows, which a ring buffer holds. If the lattice has more rows than the image, rows are summed first and then
interpolated.

Fields are in single precision, which halves the memory traffic; sums have a fixed order and no fused multiply-add, so
that a pixel has the same bits in every tile and on every machine.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.kernels import kernel
from hcss_twin.models.clouds.fractal.blocks import BLOCK_COLUMNS, BLOCK_ROWS
from hcss_twin.models.clouds.fractal.lattice import blend_scattered

_u4, _u8 = np.uint32, np.uint64

_LARGEST_COORDINATE = 2.0**62

# Mean run length of consecutive nodes above which vector loads are faster than single loads.
_LONG_RUN = 8


def cubic_weights(fraction: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the four weights (N, 4) of the nodes at -1, 0, 1, 2 for ``fraction`` (N,) in [0, 1].

    Keys' kernel with a = -1/2, divided by sqrt(sum w^2): the squared weights sum to 1 (eq 2).
    """
    f, g = fraction, 1.0 - fraction
    w0, w1 = -0.5 * f * g * g, 1.0 + f * f * (1.5 * f - 2.5)
    w2, w3 = 1.0 + g * g * (1.5 * g - 2.5), -0.5 * g * f * f
    return np.stack((w0, w1, w2, w3), axis=1) / np.sqrt((w0 * w0 + w3 * w3) + (w1 * w1 + w2 * w2))[:, None]


def split(coordinate: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Split lattice coordinates (N,) into the cell (N,) and the fraction (N,) in [0, 1].

    The fraction rounds to 1 only for negative coordinates very close to 0; its weights then equal those for fraction 0
    of the next cell.

    Raises
    ------
    ValueError
        If a coordinate is not finite or its cell does not fit into 64 bits.
    """
    if not np.all(np.abs(coordinate) < _LARGEST_COORDINATE):
        raise ValueError("coordinate: a lattice coordinate is not finite or beyond +-2**62 cells")
    floor = np.floor(coordinate)
    return floor.astype(np.int64), coordinate - floor


@kernel(inner=True)
def _blend_stored(pool: Any, slots: Any, weights: Any, row: Any, first: Any, line: Any) -> None:
    """Blend the stored time planes of one row of nodes into ``line`` (N,).

    ``row`` and ``first`` count from the corner of the first block in ``slots`` (planes, block rows, block columns). The
    size of blocks is a constant of the compiled loop: kept code is that of this file alone.
    """
    by, r = row // BLOCK_ROWS, row % BLOCK_ROWS
    done, x = 0, first
    while done < line.size:
        bx, c = x // BLOCK_COLUMNS, x % BLOCK_COLUMNS
        count = min(BLOCK_COLUMNS - c, line.size - done)
        start = r * BLOCK_COLUMNS + c
        part = line[done : done + count]
        plane0 = pool[slots[0, by, bx], start : start + count]
        w0 = weights[0]
        if weights.size == 4:
            plane1 = pool[slots[1, by, bx], start : start + count]
            plane2 = pool[slots[2, by, bx], start : start + count]
            plane3 = pool[slots[3, by, bx], start : start + count]
            w1, w2, w3 = weights[1], weights[2], weights[3]
            for i in range(count):
                part[i] = w0 * plane0[i] + w1 * plane1[i] + w2 * plane2[i] + w3 * plane3[i]
        else:
            for i in range(count):
                part[i] = w0 * plane0[i]
        done += count
        x += count


@kernel(inner=True)
def _gather(line: Any, index: Any, weights: Any, gathered: Any) -> None:
    """Interpolate a line of nodes at the columns: nodes ``index`` (N,) to ``index + 3``, weights (4, N)."""
    w0, w1, w2, w3 = weights[0], weights[1], weights[2], weights[3]
    for c in range(gathered.size):
        i = index[c]
        gathered[c] = (
            w0[c] * line[_u8(i)]
            + w1[c] * line[_u8(i + _u4(1))]
            + w2[c] * line[_u8(i + _u4(2))]
            + w3[c] * line[_u8(i + _u4(3))]
        )


@kernel(inner=True)
def _runs(index: Any) -> Any:
    """Return the starts of runs in which ``index`` (N,) increases by 1 per column, followed by N.

    Runs are long if node and pixel spacings are similar.
    """
    starts = np.empty(index.size + 1, dtype=np.int64)
    count = 0
    for c in range(index.size):
        if c == 0 or index[c] != index[c - 1] + _u4(1):
            starts[count] = c
            count += 1
    starts[count] = index.size
    return starts[: count + 1]


@kernel(inner=True)
def _gather_runs(line: Any, index: Any, starts: Any, weights: Any, gathered: Any) -> None:
    """Same as :func:`_gather` with contiguous loads, which are several times faster for long runs."""
    for run in range(starts.size - 1):
        start, stop = starts[run], starts[run + 1]
        first, count = np.int64(index[start]), stop - start
        n0, n1 = line[first : first + count], line[first + 1 : first + 1 + count]
        n2, n3 = line[first + 2 : first + 2 + count], line[first + 3 : first + 3 + count]
        w0, w1, w2, w3 = (
            weights[0, start:stop],
            weights[1, start:stop],
            weights[2, start:stop],
            weights[3, start:stop],
        )
        result = gathered[start:stop]
        for c in range(count):
            result[c] = w0[c] * n0[c] + w1[c] * n1[c] + w2[c] * n2[c] + w3[c] * n3[c]


@kernel(inner=True)
def _combine(row0: Any, row1: Any, row2: Any, row3: Any, w0: Any, w1: Any, w2: Any, w3: Any, result: Any) -> None:
    for c in range(result.size):
        result[c] = w0 * row0[c] + w1 * row1[c] + w2 * row2[c] + w3 * row3[c]


@kernel(inner=True)
def _add(row0: Any, row1: Any, row2: Any, row3: Any, w0: Any, w1: Any, w2: Any, w3: Any, total: Any) -> None:
    for c in range(total.size):
        total[c] += w0 * row0[c] + w1 * row1[c] + w2 * row2[c] + w3 * row3[c]


@kernel()
def add_nodes(
    total: NDArray[np.float32],
    planes: NDArray[np.uint64],
    time_weights: NDArray[np.float32],
    rows: NDArray[np.int64],
    nodes: NDArray[np.int64],
) -> None:
    """Add one octave to a tile like :func:`add_octave`, the nearest node to each pixel."""
    line, scratch = np.empty(nodes.size, dtype=np.float32), np.empty(nodes.size, dtype=np.uint32)
    for r in range(total.shape[0]):
        blend_scattered(planes, time_weights, rows[r], nodes, line, scratch)
        row_total = total[r]
        for c in range(line.size):
            row_total[c] += line[c]


@kernel()
def add_octave(
    total: NDArray[np.float32],
    pool: NDArray[np.float32],
    slots: NDArray[np.int32],
    planes: NDArray[np.uint64],
    time_weights: NDArray[np.float32],
    corner: NDArray[np.int64],
    rows: NDArray[np.int64],
    row_weights: NDArray[np.float32],
    nodes: NDArray[np.int64],
    columns: NDArray[np.uint32],
    column_weights: NDArray[np.float32],
    gathers_first: bool,
) -> None:
    """Add one octave k, gamma^(-k H) S_k of eqs 2-4, to a tile.

    Parameters
    ----------
    total : ndarray of float32 (M, N)
        The tile.
    pool, slots
        Cached nodes and their slots (:class:`BlockCache`); if ``slots`` has shape (0, 0, 0), nodes are generated from
        their indices.
    planes : ndarray of uint64 (P,)
        Keys of the time planes, 1 or 4.
    time_weights : ndarray of float32 (P,)
        Weights of the planes, times the amplitude.
    corner : ndarray of int64 (2,)
        Row and column of the first node of ``slots``.
    rows : ndarray of int64 (M,)
        First row of nodes of each pixel row, ascending.
    row_weights : ndarray of float32 (M, 4) or (M, 1)
        Weights of this row and the following ones; a single weight for the nearest row.
    nodes : ndarray of int64 (K,)
        Columns of nodes, ascending; contiguous if nodes are cached.
    columns : ndarray of uint32 (N,)
        Index in ``nodes`` of the first node of each pixel column; empty if ``nodes`` are the nearest nodes of the
        columns.
    column_weights : ndarray of float32 (4, N) or (0, 0)
        Weights of four nodes.
    gathers_first : bool
        Whether node rows are interpolated at the columns before they are summed. This is a property of the octave, not
        of the tile, because the order of sums determines the bits.
    """
    width, count = total.shape[1], nodes.size
    is_stored, interpolates_x, taps = slots.size > 0, columns.size > 0, row_weights.shape[1]
    ring = np.empty((4, width if gathers_first else count), dtype=np.float32)
    line = np.empty(count, dtype=np.float32)
    gathered = np.empty(width, dtype=np.float32)
    scratch = np.empty(0 if is_stored else count, dtype=np.uint32)
    starts = _runs(columns)
    has_runs = columns.size > _LONG_RUN * (starts.size - 1)
    have = rows[0] - 1
    for r in range(total.shape[0]):
        base = rows[r]
        have = max(have, base - 1)
        while have < base + taps - 1:
            have += 1
            target = line if gathers_first else ring[have & 3]
            if is_stored:
                _blend_stored(pool, slots, time_weights, have - corner[0], nodes[0] - corner[1], target)
            else:
                blend_scattered(planes, time_weights, have, nodes, target, scratch)
            if gathers_first and has_runs:
                _gather_runs(line, columns, starts, column_weights, ring[have & 3])
            elif gathers_first:
                _gather(line, columns, column_weights, ring[have & 3])
        row0 = ring[base & 3]
        if taps == 4:
            row1, row2, row3 = ring[(base + 1) & 3], ring[(base + 2) & 3], ring[(base + 3) & 3]
            w0, w1, w2, w3 = row_weights[r, 0], row_weights[r, 1], row_weights[r, 2], row_weights[r, 3]
            if gathers_first or not interpolates_x:
                _add(row0, row1, row2, row3, w0, w1, w2, w3, total[r])
                continue
            _combine(row0, row1, row2, row3, w0, w1, w2, w3, line)
            row0 = line
        if interpolates_x and has_runs:
            _gather_runs(row0, columns, starts, column_weights, gathered)
            row0 = gathered
        elif interpolates_x:
            _gather(row0, columns, column_weights, gathered)
            row0 = gathered
        row_total = total[r]
        for c in range(width):
            row_total[c] += row0[c]
