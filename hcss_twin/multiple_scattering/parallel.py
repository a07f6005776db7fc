"""Compiled loops, which release the interpreter's lock, in several threads."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from types import TracebackType

_MOST = 8

# A thread is worth starting for this many layers, some milliseconds.
_FEWEST = 16


class Team:
    """Threads that are started once for several loops, the first time that one has work for them.

    Parameters
    ----------
    threads : int, optional
        Default: one for each processor this process may use, at most 8.

    Raises
    ------
    ValueError
        If ``threads`` is below 1.
    """

    def __init__(self, threads: int | None) -> None:
        if threads is not None and threads < 1:
            raise ValueError(f"threads {threads}: allowed from 1; closest is 1")
        self._wanted = threads or min(_MOST, _processors())
        # One part is done by the thread that asks.
        self._others = ThreadPoolExecutor(max(self._wanted - 1, 1), thread_name_prefix="scattering")

    def __enter__(self) -> Team:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._others.shutdown()

    def run(self, part: Callable[[int, int], None], count: int) -> None:
        """Run ``part(start, step)`` so that all of ``range(start, count, step)`` together are all items.

        Neighbouring items go to different threads, because thick layers stand together and take longer.
        """
        step = max(1, min(self._wanted, count // _FEWEST))
        others = [self._others.submit(part, start, step) for start in range(1, step)]
        part(0, step)
        for other in others:
            other.result()


def _processors() -> int:
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
