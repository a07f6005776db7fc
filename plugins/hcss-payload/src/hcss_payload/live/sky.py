"""The sky of live frames: tiles of the field, for pairs of keyframes, made before they are needed.

A tile hangs on the sky, which drifts with the wind, and is named by its row, its column and the number of its first
keyframe: what it holds depends on nothing else. A thread makes the tiles toward which the camera moves; those that a
frame lacks are made at once, which is counted, since that frame is late.
"""

from __future__ import annotations

import math
import threading
from collections import OrderedDict
from collections.abc import Callable, Iterable
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hcss_payload.checks import PayloadError
from hcss_payload.live.kernels import TILE, VALUE_STEP, WIDE, pack
from hcss_payload.live.octaves import SeenOctaves
from hcss_twin.models.clouds.fractal.field import FractalField
from hcss_twin.providers import Array

LARGEST_BYTES = 2**30
"""Memory of all tiles."""

_PAUSE_S = 0.1
"""Time between two looks ahead."""

_TOGETHER = 4
"""Neighbouring tiles that are computed at once; a frame waits for no more of them than these."""


class Tiles(NamedTuple):
    """Tiles that a footprint needs: first row and column, those after the last, and the keyframe."""

    row: int
    column: int
    end_row: int
    end_column: int
    keyframe: int


class Sky:
    """Tiles of the field of one cloud layer.

    Parameters
    ----------
    seed : int
        Of the layer.
    octaves : callable
        The octaves that a pixel sees at a time in s, at the points of the tiles of a keyframe.
    interval_s : float
        Between keyframes.
    capacity : int
        Tiles in memory.
    ahead : callable
        Returns, for the time of a frame, the tiles that frames soon need; called by the thread.

    Attributes
    ----------
    pool : ndarray of int32 (capacity x WIDE x WIDE)
        Two keyframes of 16 bits in each number, on machines with the low byte first.
    stalls : int
        Tiles that a frame had to wait for.
    """

    def __init__(
        self,
        seed: int,
        octaves: Callable[[float, int], SeenOctaves],
        interval_s: float,
        capacity: int,
        ahead: Callable[[float], Iterable[Tiles]],
    ) -> None:
        size = capacity * WIDE * WIDE * 2
        if 2 * size > LARGEST_BYTES:
            raise PayloadError(
                f"camera: {capacity} tiles of the sky need {2e-6 * size:.0f} MB; allowed: {1e-6 * LARGEST_BYTES:.0f} "
                "MB, with fewer pixels or a smaller fineness"
            )
        self._seed, self._interval_s, self._ahead = seed, interval_s, ahead
        self._octaves = octaves
        self._field = lru_cache(maxsize=6)(self._new_field)
        self.pool = np.zeros(size // 2, np.int32)
        self._tiles = self.pool.view(np.int16).reshape(capacity, WIDE, WIDE, 2)
        self._slots: OrderedDict[tuple[int, int, int], int] = OrderedDict()
        self._free = list(range(capacity))
        self._pinned: set[tuple[int, int, int]] = set()
        self._now: tuple[Tiles, NDArray[np.int64]] | None = None
        self.stalls = 0
        self._making = threading.Lock()
        self._wanted = threading.Condition()
        self._asked: float | None = None
        self._last: float | None = None
        self._failed: BaseException | None = None
        self._closed = threading.Event()
        self._thread = threading.Thread(target=self._work, name="sky", daemon=True)
        self._thread.start()

    def keyframe(self, time_s: float) -> tuple[int, np.float32]:
        """Return the keyframe before a time, and the weight of the next one."""
        position = time_s / self._interval_s
        number = int(np.floor(position))
        return number, np.float32(position - number)

    def require(self, tiles: Tiles) -> NDArray[np.int64]:
        """Return the positions (rows, columns) of tiles in the pool; they stay until the next call."""
        if self._now is not None and self._now[0] == tiles:
            return self._now[1]
        names = _names(tiles)
        with self._making:
            self._pinned = set(names)
        self.stalls += self._make(tiles)
        slots = np.empty((tiles.end_row - tiles.row, tiles.end_column - tiles.column), np.int64)
        with self._making:
            for (row, column, _), name in zip(names, names, strict=True):
                self._slots.move_to_end(name)
                slots[row - tiles.row, column - tiles.column] = self._slots[name]
        self._now = tiles, slots
        return slots

    def value(self, point: Array, tiles: Tiles, slots: NDArray[np.int64], later: float) -> float:
        """Return the field at a point (x, y) within tiles that are required, as frames have it."""
        whole = np.floor(point).astype(np.int64)
        (x, y), (column, row) = whole % TILE, whole // TILE
        around = self._tiles[slots[row - tiles.row, column - tiles.column], y : y + 2, x : x + 2].astype(np.float64)
        now = around[..., 0] + later * (around[..., 1] - around[..., 0])
        (fx, fy) = point - whole
        lines = now[:, 0] + fx * (now[:, 1] - now[:, 0])
        return float(VALUE_STEP) * float(lines[0] + fy * (lines[1] - lines[0]))

    def look_ahead(self, time_s: float) -> None:
        """Let the thread make the tiles that frames soon after a time need.

        Raises
        ------
        Exception
            What stopped the thread.
        """
        if self._failed is not None:
            raise self._failed
        if self._last is not None and abs(time_s - self._last) < _PAUSE_S:
            return
        self._last = time_s
        with self._wanted:
            self._asked = time_s
            self._wanted.notify()

    def close(self) -> None:
        """End the thread."""
        with self._wanted:
            self._closed.set()
            self._wanted.notify()
        self._thread.join()

    def _work(self) -> None:
        while True:
            with self._wanted:
                self._wanted.wait_for(lambda: self._asked is not None or self._closed.is_set())
                if self._closed.is_set():
                    return
                time_s, self._asked = self._asked, None
            assert time_s is not None
            try:
                for tiles in self._ahead(time_s):
                    self._make(tiles, ahead=True)
                    if self._closed.is_set():
                        return
            except BaseException as error:  # for the next frame to raise
                self._failed = error
                return

    def _make(self, tiles: Tiles, ahead: bool = False) -> int:
        """Compute the tiles that are missing, and return how many those were."""
        count = 0
        for row in range(tiles.row, tiles.end_row):
            for first in range(tiles.column, tiles.end_column, _TOGETHER):
                columns = range(first, min(first + _TOGETHER, tiles.end_column))
                with self._making:
                    missing = [c for c in columns if (row, c, tiles.keyframe) not in self._slots]
                    if missing:
                        count += self._compute(row, missing[0], missing[-1] + 1, tiles.keyframe, ahead)
                if ahead and self._closed.is_set():
                    return count
        return count

    def _compute(self, row: int, first: int, end: int, keyframe: int, ahead: bool) -> int:
        """Compute neighbouring tiles of a row; fewer ahead of time where those in use leave no room."""
        y = FractalField.PixelWindow(row * TILE, WIDE, 0.0)
        x = FractalField.PixelWindow(first * TILE, (end - first) * TILE + 1, 0.0)
        values = [
            self._field(number, keyframe).window(number * self._interval_s, y, x) for number in (keyframe, keyframe + 1)
        ]
        count = 0
        for column in range(first, end):
            name = row, column, keyframe
            if name in self._slots:
                continue
            slot = self._slot(ahead)
            if slot is None:
                break
            inside = slice((column - first) * TILE, (column - first) * TILE + WIDE)
            pack(values[0][:, inside], values[1][:, inside], self._tiles[slot])
            self._slots[name] = slot
            count += 1
        return count

    def _slot(self, ahead: bool) -> int | None:
        if self._free:
            return self._free.pop()
        oldest = next((name for name in self._slots if name not in self._pinned), None)
        if oldest is None:
            if ahead:
                return None
            raise PayloadError("camera: sees more of the sky than in the prepared pass; allowed: attitudes like those")
        return self._slots.pop(oldest)

    def _new_field(self, number: int, keyframe: int) -> FractalField:
        return FractalField(self._seed, self._octaves(number * self._interval_s, keyframe).octaves, threads=1)


def _names(tiles: Tiles) -> list[tuple[int, int, int]]:
    return [
        (row, column, tiles.keyframe)
        for row in range(tiles.row, tiles.end_row)
        for column in range(tiles.column, tiles.end_column)
    ]


def tiles_around(reach: tuple[float, float, float, float], keyframe: int) -> Tiles:
    """Return the tiles that hold points of the sky, given their smallest and largest x and y.

    Blocks begin up to two points before their nodes.
    """
    low_x, low_y, high_x, high_y = reach
    left, bottom = math.floor(low_x - 2.0) // TILE, math.floor(low_y - 2.0) // TILE
    right, top = math.floor(high_x + 2.0) // TILE, math.floor(high_y + 2.0) // TILE
    return Tiles(bottom, left, top + 1, right + 1, keyframe)
