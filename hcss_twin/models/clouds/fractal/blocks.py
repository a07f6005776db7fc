"""Lattice nodes kept between frames, in blocks, so that only what is new is generated.

A cache of a pure function: what it holds or drops never changes a value.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from hcss_twin.models.clouds.fractal.lattice import fill_row

BLOCK_ROWS, BLOCK_COLUMNS = 64, 256
"""Nodes of one block: 64 KiB. Powers of two, so that aligned blocks never straddle a multiple of 2**32."""

MAX_BLOCKS = 1 << 12
"""Kept at a time: 256 MiB."""

_FEWEST_SLOTS = 16


@dataclass(frozen=True)
class NodeWindow:
    """Nodes of some time planes of one octave: the lattice that a tile needs.

    Attributes
    ----------
    planes : tuple of int
        Keys of the time planes.
    rows, columns : (int, int)
        First node, and one past the last.
    """

    planes: tuple[int, ...]
    rows: tuple[int, int]
    columns: tuple[int, int]

    @property
    def block_rows(self) -> range:
        """Blocks along y."""
        return range(self.rows[0] // BLOCK_ROWS, (self.rows[1] - 1) // BLOCK_ROWS + 1)

    @property
    def block_columns(self) -> range:
        """Blocks along x."""
        return range(self.columns[0] // BLOCK_COLUMNS, (self.columns[1] - 1) // BLOCK_COLUMNS + 1)


@dataclass
class BlockCache:
    """Blocks of lattice nodes by (plane, block row, block column).

    Blocks that neither this frame nor the one before has used make room for new ones; without such the
    pool grows, up to :data:`MAX_BLOCKS`, and then the least recently used go.

    Attributes
    ----------
    pool : ndarray of float32 (slots, nodes of a block)
        The nodes; slots beyond those in use hold nothing.
    """

    pool: NDArray[np.float32] = field(
        default_factory=lambda: np.empty((0, BLOCK_ROWS * BLOCK_COLUMNS), dtype=np.float32)
    )
    _slot_of: dict[tuple[int, int, int], int] = field(default_factory=dict)
    _key_of: list[tuple[int, int, int] | None] = field(default_factory=list)
    _last_use: NDArray[np.int64] = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    _loads: int = 0
    _frame_s: float = math.nan
    _frame_loads: tuple[int, int] = (0, 0)
    _tables: dict[NodeWindow, NDArray[np.int32]] = field(default_factory=dict)

    @property
    def slots(self) -> int:
        """Slots in use."""
        return len(self._key_of)

    def load(
        self, time_s: float, windows: Iterable[NodeWindow], each: Callable[[Callable[[int, int], None], int], None]
    ) -> list[NDArray[np.int32]]:
        """Make sure that the nodes of all windows are in the pool, and say where.

        Parameters
        ----------
        time_s : float
            Tells frames apart.
        windows : iterable of NodeWindow
            What one tile needs, at most :data:`MAX_BLOCKS` blocks or as many as there is memory for.
        each : callable
            Runs a function of (start, stop) over parts of a number of items, perhaps in several threads.

        Returns
        -------
        list of ndarray of int32 (planes, block rows, block columns)
            For each window the slots of its blocks.
        """
        wanted = list(windows)
        self._loads += 1
        if time_s != self._frame_s:
            self._frame_s, self._frame_loads = time_s, (self._frame_loads[1], self._loads)
        known = {window: self._tables[window] for window in wanted if window in self._tables}
        for table in known.values():
            self._last_use[table] = self._loads
        tables = {window: known.get(window) for window in wanted}
        missing: list[tuple[int, int, int]] = []
        free = self._free_slots()
        for window, found in tables.items():
            if found is None:
                tables[window] = self._table(window, missing, free)
        # What was thrown out to make room may be part of tables of earlier tiles; keep the current ones only.
        self._tables = {window: table for window, table in tables.items() if table is not None}
        if missing:
            self._fill(missing, each)
        return [self._tables[window] for window in wanted]

    def _table(self, window: NodeWindow, missing: list[tuple[int, int, int]], free: Iterator[int]) -> NDArray[np.int32]:
        rows, columns = window.block_rows, window.block_columns
        table = np.empty((len(window.planes), len(rows), len(columns)), dtype=np.int32)
        for p, plane in enumerate(window.planes):
            for i, row in enumerate(rows):
                for j, column in enumerate(columns):
                    key = (plane, row, column)
                    slot = self._slot_of.get(key)
                    if slot is None:
                        slot = next(free)
                        self._slot_of[key] = slot
                        self._key_of[slot] = key
                        missing.append(key)
                    self._last_use[slot] = self._loads
                    table[p, i, j] = slot
        return table

    def _free_slots(self) -> Iterator[int]:
        """Yield slots whose blocks this load does not need, and forget the blocks."""
        while True:
            size = self.slots
            for number in np.argsort(self._last_use, kind="stable"):
                slot = int(number)
                last = self._last_use[slot]
                if last == self._loads:  # taken meanwhile
                    continue
                if last >= self._frame_loads[0] and size < MAX_BLOCKS:
                    break
                old = self._key_of[slot]
                if old is not None:
                    del self._slot_of[old]
                yield slot
            more, room = max(_FEWEST_SLOTS, size // 2), MAX_BLOCKS - size
            # Beyond, only for a tile that needs more by itself: a larger pool is copied, with both in memory.
            self._grow(min(more, room) if room > 0 else more)

    def _grow(self, more: int) -> None:
        kept = self.slots
        if kept + more > self.pool.shape[0]:
            # Memory that is never written is never given: all of it at once saves copies as the pool grows.
            pool = np.empty((max(kept + more, MAX_BLOCKS), BLOCK_ROWS * BLOCK_COLUMNS), dtype=np.float32)
            pool[:kept] = self.pool[:kept]
            self.pool = pool
        self._key_of += [None] * more
        self._last_use = np.concatenate((self._last_use, np.full(more, -1, dtype=np.int64)))

    def _fill(self, keys: list[tuple[int, int, int]], each: Callable[[Callable[[int, int], None], int], None]) -> None:
        planes = np.array([key[0] for key in keys], dtype=np.uint64)
        rows = np.array([key[1] for key in keys], dtype=np.int64)
        columns = np.array([key[2] for key in keys], dtype=np.int64)
        slots = np.array([self._slot_of[key] for key in keys], dtype=np.int64)

        def part(start: int, stop: int) -> None:
            chosen = slice(start, stop)
            _fill_blocks(planes[chosen], rows[chosen], columns[chosen], slots[chosen], self.pool)

        each(part, len(keys))


@njit(cache=True, nogil=True)
def _fill_blocks(planes: Any, rows: Any, columns: Any, slots: Any, pool: Any) -> None:
    bits = np.empty(BLOCK_COLUMNS, dtype=np.uint32)
    work = np.empty(BLOCK_COLUMNS, dtype=np.float32)
    for b in range(slots.size):
        block = pool[slots[b]]
        for r in range(BLOCK_ROWS):
            values = block[r * BLOCK_COLUMNS : (r + 1) * BLOCK_COLUMNS]
            fill_row(planes[b], rows[b] * BLOCK_ROWS + r, columns[b] * BLOCK_COLUMNS, values, bits, work)
