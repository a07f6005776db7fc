"""Chains of layers, each solved by one sequence of doublings, the threads that solve them, and when modes end.

Compiled loops release the interpreter's lock, so threads can share the chains of one azimuth mode.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from types import TracebackType

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array

_MAX_THREADS = 8

_MIN_CHAINS = 64
"""Per thread: with few streams they take a millisecond, which justifies starting a thread."""


class Team:
    """Threads shared by several loops; they start when the first loop has work for them.

    Parameters
    ----------
    threads : int, optional
        Default: one for each processor available to this process, at most 8.

    Raises
    ------
    ValueError
        If ``threads`` is below 1.
    """

    def __init__(self, threads: int | None) -> None:
        if threads is not None and threads < 1:
            raise ValueError(f"threads {threads}: allowed from 1; closest is 1")
        self._wanted = threads or min(_MAX_THREADS, _processors())
        # The calling thread computes one part itself.
        self._others = ThreadPoolExecutor(max(self._wanted - 1, 1), thread_name_prefix="scattering")

    def __enter__(self) -> Team:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._others.shutdown()

    def run(self, part: Callable[[int, int], None], count: int) -> None:
        """Run ``part(start, step)`` for every start, so that the ranges ``(start, count, step)`` cover all items.

        Neighbouring items go to different threads: thick layers are neighbours and take longer.
        """
        step = max(1, min(self._wanted, count // _MIN_CHAINS))
        others = [self._others.submit(part, start, step) for start in range(1, step)]
        part(0, step)
        for other in others:
            other.result()


def _processors() -> int:
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


SAME = 1e-12
"""Relative difference below which thicknesses count as equal."""


@dataclass(frozen=True)
class DoublingChains:
    """Layers in the order of their solution: chain after chain, each from thin to thick.

    Attributes
    ----------
    cell : ndarray of int (n,)
        Position of each layer in the flattened (T, V).
    column : ndarray of int (n,)
        Row of its kernels: index into ``wavenumber``.
    thickness : ndarray (n,)
        Its optical thickness.
    doublings : ndarray of int (n,)
        Number since the previous layer of its chain; 0 for the first.
    first : ndarray of int (chains + 1,)
        Index of the first layer of each chain, and n.
    wavenumber : ndarray of int
        Indices of the wavenumbers that have layers, ascending.
    """

    cell: NDArray[np.int64]
    column: NDArray[np.int64]
    thickness: Array
    doublings: NDArray[np.int64]
    first: NDArray[np.int64]
    wavenumber: NDArray[np.int64]


def chains(thickness: Array, wanted: NDArray[np.bool_]) -> DoublingChains:
    """Sort layers into chains, whose layers have one wavenumber and thicknesses that differ by powers of 2.

    Thicknesses are written m 2^e, m from 0.5 to 1; successive layers of a chain have the same m, to ``SAME``.

    Parameters
    ----------
    thickness : ndarray (T, V)
        Optical thickness.
    wanted : ndarray of bool (T, V)
        Layers to be solved.
    """
    cell = np.flatnonzero(wanted)
    tau = thickness.ravel()[cell]
    wavenumber, column = np.unique(cell % thickness.shape[1], return_inverse=True)
    m, e = np.frexp(tau)
    # Rounding may put a thickness just below a power of 2.
    below = m > 1.0 - SAME
    m, e = np.where(below, 0.5 * m, m), np.where(below, e + 1, e)
    order = np.lexsort((m, column))
    apart = (np.diff(column[order]) > 0) | (np.diff(m[order]) > SAME * m[order][1:])
    chain = np.empty(cell.size, dtype=np.int64)
    chain[order] = np.concatenate([np.zeros(min(cell.size, 1), dtype=np.int64), np.cumsum(apart)])
    order = np.lexsort((e, chain))
    chain, e = chain[order], e[order].astype(np.int64)
    begins = np.diff(chain, prepend=-1) > 0
    doublings = np.where(begins, 0, np.diff(e, prepend=0))
    first = np.append(np.flatnonzero(begins), cell.size)
    return DoublingChains(cell[order], column[order], tau[order], doublings, first, wavenumber)


class AzimuthSeries:
    """Layers whose Fourier series need more terms: a series ends after two successive small modes.

    Parameters
    ----------
    thickness : ndarray (T, V)
        Optical thickness.

    Attributes
    ----------
    chains : DoublingChains
        Of the layers that still need a mode.
    """

    def __init__(self, thickness: Array) -> None:
        self._thickness = thickness
        self._going = np.ones(thickness.shape, dtype=np.bool_)
        # Layers whose previous mode was small.
        self._quiet = np.zeros(thickness.size, dtype=np.bool_)
        self.chains = chains(thickness, self._going)

    def end_where(self, small: NDArray[np.bool_]) -> bool:
        """Record for which layers of ``chains`` (n,) this mode was small; return whether all series have ended."""
        cells = self.chains.cell
        ended = small & self._quiet[cells]
        self._quiet[cells] = small
        if np.any(ended):
            self._going.flat[cells[ended]] = False
            self.chains = chains(self._thickness, self._going)
        return bool(np.all(ended))
