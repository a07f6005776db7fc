"""Groups of wavenumbers, whose light is independent, on several processors at once."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

MOST = 4
"""Groups at once at most: each needs some 100 bytes for every voxel of a square."""

Item = TypeVar("Item")
Result = TypeVar("Result")


def at_once(work: Callable[[Item], Result], items: Sequence[Item]) -> list[Result]:
    """Return what ``work`` gives for each item, in their order; kernels run side by side.

    Results do not depend on the number of processors.
    """
    available = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    threads = min(available, MOST, len(items))
    if threads < 2:
        return [work(each) for each in items]
    with ThreadPoolExecutor(threads, thread_name_prefix="light") as pool:
        return list(pool.map(work, items))
