"""Cache of lattice nodes in blocks, so that a frame generates only nodes that the previous frame did not use.

Consecutive frames share most of their nodes: the platform moves by a few pixels, and the four time planes of an octave
change only as its cells evolve. The nodes are a pure function of their indices (:mod:`.lattice`), so that the cache
never changes a value.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.kernels import kernel
from hcss_twin.models.clouds.fractal.lattice import fill_row

BLOCK_ROWS, BLOCK_COLUMNS = 16, 128
"""Block size: 8 KiB, as of large cells a small image needs a few nodes. Powers of two, so that no block straddles a
multiple of 2**32, where row keys change."""

MAX_BLOCKS = 1 << 15
"""Largest number of blocks in memory: 256 MiB."""

_FEWEST_SLOTS = 128


@dataclass(frozen=True)
class NodeWindow:
    """Nodes of one octave that a tile needs: keys of the time planes, start and stop along y and x."""

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

    New blocks replace blocks that neither this frame nor the previous one has used. If there are none, the pool grows
    up to :data:`MAX_BLOCKS`; then they replace the least recently used blocks.

    Attributes
    ----------
    pool : ndarray of float32 (slots, nodes of a block)
        The nodes; unused slots are not initialised.
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
        """Number of slots in use."""
        return len(self._key_of)

    def load(
        self, time_s: float, windows: Iterable[NodeWindow], in_parts: Callable[[Callable[[int, int], None], int], None]
    ) -> list[NDArray[np.int32]]:
        """Generate the missing nodes of all windows and return the slots of their blocks.

        Parameters
        ----------
        time_s : float
            Time of the frame.
        windows : iterable of NodeWindow
            Windows of one tile, with at most :data:`MAX_BLOCKS` blocks or as many as fit in memory.
        in_parts : callable
            Runs a function of (start, stop) over a number of items in parts, possibly in several threads.

        Returns
        -------
        list of ndarray of int32 (planes, block rows, block columns)
            Slots of the blocks of each window.
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
        for window, table_of_slots in tables.items():
            if table_of_slots is None:
                tables[window] = self._table(window, missing, free)
        # Tables of earlier tiles may contain reused slots; only the current tables are valid.
        self._tables = {window: table for window, table in tables.items() if table is not None}
        if missing:
            self._fill(missing, in_parts)
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
        """Yield slots whose blocks this load does not need, and remove their blocks."""
        while True:
            size = self.slots
            for number in np.argsort(self._last_use, kind="stable"):
                slot = int(number)
                last = self._last_use[slot]
                if last == self._loads:  # in use since the sort
                    continue
                if last >= self._frame_loads[0] and size < MAX_BLOCKS:
                    break
                old = self._key_of[slot]
                if old is not None:
                    del self._slot_of[old]
                yield slot
            more, available = max(_FEWEST_SLOTS, size // 2), MAX_BLOCKS - size
            # More than MAX_BLOCKS only for a single tile that needs them: copying the pool takes the memory of both.
            self._grow(min(more, available) if available > 0 else more)

    def _grow(self, more: int) -> None:
        size = self.slots
        if size + more > self.pool.shape[0]:
            # Allocating the whole pool at once avoids copies; the system provides memory only when it is written.
            pool = np.empty((max(size + more, MAX_BLOCKS), BLOCK_ROWS * BLOCK_COLUMNS), dtype=np.float32)
            pool[:size] = self.pool[:size]
            self.pool = pool
        self._key_of += [None] * more
        self._last_use = np.concatenate((self._last_use, np.full(more, -1, dtype=np.int64)))

    def _fill(
        self, keys: list[tuple[int, int, int]], in_parts: Callable[[Callable[[int, int], None], int], None]
    ) -> None:
        planes = np.array([plane for plane, _, _ in keys], dtype=np.uint64)
        rows = np.array([row for _, row, _ in keys], dtype=np.int64)
        columns = np.array([column for _, _, column in keys], dtype=np.int64)
        slots = np.array([self._slot_of[key] for key in keys], dtype=np.int64)

        def part(start: int, stop: int) -> None:
            chosen = slice(start, stop)
            _fill_blocks(planes[chosen], rows[chosen], columns[chosen], slots[chosen], self.pool)

        in_parts(part, len(keys))


@kernel()
def _fill_blocks(planes: Any, rows: Any, columns: Any, slots: Any, pool: Any) -> None:
    bits = np.empty(BLOCK_COLUMNS, dtype=np.uint32)
    for b in range(slots.size):
        block = pool[slots[b]]
        for r in range(BLOCK_ROWS):
            values = block[r * BLOCK_COLUMNS : (r + 1) * BLOCK_COLUMNS]
            fill_row(planes[b], rows[b] * BLOCK_ROWS + r, columns[b] * BLOCK_COLUMNS, values, bits)
