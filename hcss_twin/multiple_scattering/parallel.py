"""Compiled loops, which release the interpreter's lock, in several threads."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

_MOST = 8

# A thread is worth starting for this many layers, some milliseconds.
_FEWEST = 16


def in_threads(part: Callable[[int, int], None], count: int, threads: int | None) -> None:
    """Run ``part(start, step)`` so that all of ``range(start, count, step)`` together are all items.

    Neighbouring items go to different threads, because thick layers stand together and take longer.

    Raises
    ------
    ValueError
        If ``threads`` is below 1.
    """
    if threads is not None and threads < 1:
        raise ValueError(f"threads {threads}: allowed from 1; closest is 1")
    wanted = threads or min(_MOST, _processors())
    step = max(1, min(wanted, count // _FEWEST))
    if step == 1:
        part(0, 1)
        return
    with ThreadPoolExecutor(step, thread_name_prefix="scattering") as pool:
        for _ in pool.map(part, range(step), [step] * step):
            pass


def _processors() -> int:
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
