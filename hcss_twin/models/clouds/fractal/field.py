"""The normal field V of eqs 2-4: any tile of any frame of an unbounded sky."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property
from threading import Lock

import numpy as np
from numpy.typing import NDArray

from hcss_twin.models.clouds.fractal.blocks import BLOCK_COLUMNS, BLOCK_ROWS, MAX_BLOCKS, BlockCache, NodeWindow
from hcss_twin.models.clouds.fractal.lattice import lattice_normals, plane_key, unit_offset
from hcss_twin.models.clouds.fractal.octaves import Octave
from hcss_twin.models.clouds.fractal.rows import add_nodes, add_octave, cubic_weights, split

__all__ = ["FractalField"]

_X, _Y, _T = 0, 1, 2

_FEWEST_ROWS = 256
"""Number of tile rows that justifies another thread: to start it takes as long as 64 of a small image."""

_FEWEST_BLOCKS = 128
"""The same of blocks of nodes."""

_GATHER_ROWS_UNTIL = 1.25
"""Node rows per pixel row above which summing rows before interpolation along the columns is cheaper."""

_NO_SLOTS = np.empty((0, 0, 0), dtype=np.int32)
_NO_COLUMNS = np.empty(0, dtype=np.uint32)
_NO_WEIGHTS = np.empty((0, 0), dtype=np.float32)
_NEAREST = np.ones((1, 1), dtype=np.float32)


@dataclass(frozen=True)
class _Axis:
    """Nodes of one octave along one axis.

    ``start`` (N,) is the first node of each pixel; ``weights`` are (N, 4) or, for the nearest node, (1, 1); ``phase``
    numbers the lattices of the pixel parts.
    """

    start: NDArray[np.int64]
    weights: NDArray[np.float32]
    phase: int

    @property
    def interpolates(self) -> bool:
        return bool(self.weights.shape[1] == 4)

    @cached_property
    def span(self) -> tuple[int, int]:
        return int(self.start[0]), int(self.start[-1]) + self.weights.shape[1]

    def blocks(self, size: int) -> tuple[int, int]:
        """First node and end of the blocks around the span, which consecutive frames often share."""
        first, last = self.span
        return first // size * size, -(-last // size) * size


class FractalField:
    """V(x, y, t) = sum_k sqrt(variance_k) S_k, unit variance everywhere (eqs 2-4 of the HCSS paper).

    S_k interpolates a lattice of independent normals as defined by ``octaves``. Values do not depend on the tile,
    earlier calls or the number of threads.

    Parameters
    ----------
    seed : int
        Realisation.
    octaves : tuple of Octave
        Terms of the sum.
    threads : int, optional
        Default: one for each processor available to this process, at most 8.

    Attributes
    ----------
    Lattice, PixelWindow
        The normals at the nodes with what interpolates them, and the pixels of :meth:`window` along one axis.
    """

    @dataclass(frozen=True)
    class PixelWindow:
        """Pixels first, first + 1, ... along one axis, ``origin + index`` pixels from the origin of the sky.

        The integer index is separate from the origin, because a lattice of pixels needs it without rounding.
        """

        first: int
        count: int
        origin: float

        @property
        def position(self) -> NDArray[np.float64]:
            """Pixel centres in pixels from the origin of the sky: x + v_x t of eq 4."""
            # Whole and half numbers are added first and exactly, so that moving the window and moving the
            # platform by whole pixels give the same sum.
            indices = np.arange(self.first, self.first + self.count, dtype=np.int64)
            return indices.astype(np.float64) + self.origin

    class Lattice:
        """Standard normal numbers at the nodes of an infinite lattice, and what interpolates them with unit variance.

        Parameters
        ----------
        seed, octave : int
            Each pair has its own lattice.
        """

        def __init__(self, seed: int, octave: int) -> None:
            self._seed, self._octave = seed, octave

        def offset(self, axis: int) -> float:
            """Return the offset in [0, 1) cells along one axis, so that octaves do not share a node at the origin."""
            return unit_offset(self._seed, self._octave, axis)

        def normals(self, t: int, y: NDArray[np.int64], x: NDArray[np.int64]) -> NDArray[np.float32]:
            """Return the numbers (M, N) of one time plane on nodes ``y`` (M,) x ``x`` (N,); ``x`` ascends."""
            return lattice_normals(self._seed, self._octave, t, y, x)

        @staticmethod
        def weights(fraction: NDArray[np.float64]) -> NDArray[np.float64]:
            """Return the cubic weights (N, 4), of unit norm, of nodes -1, 0, 1, 2 for ``fraction`` (N,) in [0, 1]."""
            return np.asarray(cubic_weights(fraction))

    def __init__(self, seed: int, octaves: tuple[Octave, ...], threads: int | None = None) -> None:
        self._seed = seed
        self._octaves = octaves
        self._threads = threads or min(8, len(os.sched_getaffinity(0)) if _HAS_AFFINITY else os.cpu_count() or 1)
        self._stored = [index for index, octave in enumerate(octaves) if _is_stored(octave)]
        self._amplitudes = np.sqrt([octave.variance for octave in octaves])[:, None]
        self._cells = [
            _Cells.of(seed, octaves, _X, [octave.x for octave in octaves]),
            _Cells.of(seed, octaves, _Y, [octave.y for octave in octaves]),
            _Cells.of(seed, octaves, _T, [octave.t for octave in octaves]),
        ]
        self._cache = BlockCache()
        self._lock = Lock()
        self._pool: ThreadPoolExecutor | None = None

    def window(
        self,
        time_s: float,
        y: FractalField.PixelWindow,
        x: FractalField.PixelWindow,
        out: NDArray[np.float32] | None = None,
    ) -> NDArray[np.float32]:
        """Return V (rows, columns), written to ``out`` if given.

        Raises
        ------
        ValueError
            If node indices exceed 64 bits, or ``out`` is not a contiguous float32 array of the window's shape.
        """
        total = np.empty((y.count, x.count), dtype=np.float32) if out is None else out
        if total.shape != (y.count, x.count) or total.dtype != np.float32 or not total.flags.c_contiguous:
            raise ValueError(
                f"out: {total.dtype} of shape {total.shape} given, allowed: contiguous float32 of shape "
                f"{(y.count, x.count)}"
            )
        if total.size == 0:
            return total
        times = self._times(time_s)
        along_x = self._axes(x, _X)
        with self._lock:
            for start, stop in self._strips(y, along_x):
                strip = FractalField.PixelWindow(y.first + start, stop - start, y.origin)
                self._add(total[start:stop], time_s, strip, along_x, times)
        return total

    def _strips(self, y: FractalField.PixelWindow, along_x: list[_Axis]) -> list[tuple[int, int]]:
        """Divide the rows into strips whose nodes fit into the cache."""
        if y.count <= BLOCK_ROWS:
            return [(0, y.count)]
        per_row = sum(
            4.0 * (along_x[index].span[1] - along_x[index].span[0]) * max(1.0, self._octaves[index].y.step)
            for index in self._stored
        )
        rows = max(BLOCK_ROWS, int(MAX_BLOCKS * BLOCK_ROWS * BLOCK_COLUMNS / max(per_row, 1.0)))
        return [(start, min(start + rows, y.count)) for start in range(0, y.count, rows)]

    def _add(
        self,
        total: NDArray[np.float32],
        time_s: float,
        y: FractalField.PixelWindow,
        along_x: list[_Axis],
        times: list[tuple[list[int], NDArray[np.float32]]],
    ) -> None:
        along_y = self._axes(y, _Y)
        planes = [
            tuple(plane_key(self._seed, octave.k, t, ay.phase, ax.phase) for t in cells)
            for octave, ay, ax, (cells, _) in zip(self._octaves, along_y, along_x, times, strict=True)
        ]
        windows = {
            index: NodeWindow(planes[index], along_y[index].blocks(BLOCK_ROWS), along_x[index].blocks(BLOCK_COLUMNS))
            for index in self._stored
        }
        slots = dict(zip(windows, self._cache.load(time_s, windows.values(), self._each_block), strict=True))

        def part(start: int, stop: int) -> None:
            total[start:stop] = 0.0
            for index, octave in enumerate(self._octaves):
                self._add_octave(
                    octave,
                    total[start:stop],
                    slots.get(index, _NO_SLOTS),
                    np.array(planes[index], dtype=np.uint64),
                    times[index][1],
                    along_y[index],
                    slice(start, stop),
                    along_x[index],
                )

        self._each(part, total.shape[0], _FEWEST_ROWS)

    def _add_octave(
        self,
        octave: Octave,
        total: NDArray[np.float32],
        slots: NDArray[np.int32],
        planes: NDArray[np.uint64],
        time_weights: NDArray[np.float32],
        along_y: _Axis,
        rows: slice,
        along_x: _Axis,
    ) -> None:
        first, last = along_x.span
        nodes, start = along_x.start, along_y.start[rows]
        if slots.size == 0 and not along_x.interpolates and not along_y.interpolates:
            add_nodes(total, planes, time_weights, start, nodes)
            return
        columns, column_weights = _NO_COLUMNS, _NO_WEIGHTS
        if along_x.interpolates:
            nodes = np.arange(first, last, dtype=np.int64)
            columns = (along_x.start - first).astype(np.uint32)
            column_weights = np.ascontiguousarray(along_x.weights.T)
        corner = np.array(
            [along_y.span[0] // BLOCK_ROWS * BLOCK_ROWS, first // BLOCK_COLUMNS * BLOCK_COLUMNS], dtype=np.int64
        )
        weights = along_y.weights[rows] if along_y.interpolates else _NEAREST
        add_octave(
            total,
            self._cache.pool,
            slots,
            planes,
            time_weights,
            corner,
            start,
            weights,
            nodes,
            columns,
            column_weights,
            along_x.interpolates and along_y.interpolates and octave.y.step <= _GATHER_ROWS_UNTIL,
        )

    def _times(self, time_s: float) -> list[tuple[list[int], NDArray[np.float32]]]:
        """Return each octave's time-plane cells and their weights, which include its amplitude."""
        cells, weights = self._cells[_T].at(np.array([time_s]))
        weights = (self._amplitudes * weights[:, 0]).astype(np.float32)
        result = []
        for octave, cell, weight, amplitude in zip(
            self._octaves, cells[:, 0].tolist(), weights, self._amplitudes, strict=True
        ):
            if octave.t.step == 0.0 or octave.t.nearest:
                result.append(([0 if octave.t.step == 0.0 else cell], amplitude.astype(np.float32)))
            else:
                result.append(([cell - 1, cell, cell + 1, cell + 2], weight))
        return result

    def _axes(self, window: FractalField.PixelWindow, axis: int) -> list[_Axis]:
        """Return each octave's nodes and weights of a window along one axis."""
        cells, weights = self._cells[axis].at(window.position)
        weights = weights.astype(np.float32)
        result = []
        for number, octave in enumerate(self._octaves):
            scale = octave.x if axis == _X else octave.y
            if scale.nearest and octave.is_noise:
                # Each part of a pixel has a node; the parts seen at one time form a lattice, numbered by the phase.
                node = math.floor(window.origin * scale.phases)
                first, phase = divmod(node, scale.phases)
                start = np.arange(window.first + first, window.first + first + window.count, dtype=np.int64)
                result.append(_Axis(start, _NEAREST, phase))
            elif scale.nearest:
                result.append(_Axis(cells[number], _NEAREST, 0))
            else:
                result.append(_Axis(cells[number] - 1, weights[number], 0))
        return result

    def _each_block(self, part: Callable[[int, int], None], count: int) -> None:
        self._each(part, count, _FEWEST_BLOCKS)

    def _each(self, part: Callable[[int, int], None], count: int, fewest: int) -> None:
        """Run ``part(start, stop)`` over ``count`` items, in several threads where worthwhile."""
        threads = min(self._threads, max(1, count // fewest))
        if threads == 1:
            part(0, count)
            return
        if self._pool is None:
            self._pool = ThreadPoolExecutor(self._threads, thread_name_prefix="clouds")
        bounds = [count * index // threads for index in range(threads + 1)]
        for _ in self._pool.map(part, bounds[:-1], bounds[1:]):
            pass


_HAS_AFFINITY = hasattr(os, "sched_getaffinity")


def _is_stored(octave: Octave) -> bool:
    """Whether nodes are contiguous and occur in several frames, so that caching is worthwhile."""
    return not octave.t.nearest and (octave.is_noise or not (octave.x.nearest or octave.y.nearest))


@dataclass(frozen=True)
class _Cells:
    """Lattice coordinates of all octaves along one axis, steps (K, 1) and offsets (K, 1).

    All at once, because starting a kernel takes longer than a small image.
    """

    steps: NDArray[np.float64]
    offsets: NDArray[np.float64]

    @classmethod
    def of(cls, seed: int, octaves: Sequence[Octave], axis: int, scales: Sequence[Octave.AxisScale]) -> _Cells:
        """Without interpolation, nodes are half a cell from the next rounding."""
        offsets = []
        for octave, scale in zip(octaves, scales, strict=True):
            is_own = not (scale.nearest and (octave.is_noise or axis == _T))
            offsets.append((unit_offset(seed, octave.k, axis) if is_own else 0.0) + 0.5 * scale.nearest)
        # Lattices of pixels need no cells.
        steps = [
            0.0 if scale.nearest and o.is_noise and axis != _T else scale.step
            for o, scale in zip(octaves, scales, strict=True)
        ]
        return cls(np.array(steps)[:, None], np.array(offsets)[:, None])

    def at(self, position: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Return the cells (K, N) at positions (N,), and the weights (K, N, 4) of the nodes around each."""
        shape = self.steps.shape[0], position.size
        cell, fraction = split((position * self.steps + self.offsets).ravel())
        return cell.reshape(shape), cubic_weights(fraction).reshape(*shape, 4)
