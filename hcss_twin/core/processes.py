"""Worker processes that leave Ctrl-C to the process that started them, and never outlive it.

This module imports nothing of the package: a worker is safe before it loads the modules of its work, which takes
seconds.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import resource_tracker
from multiprocessing.context import SpawnContext, SpawnProcess


class _Worker(SpawnProcess):
    """A process that starts with blocked Ctrl-C: interrupted while it starts, it would print a traceback."""

    def start(self) -> None:
        if not hasattr(signal, "pthread_sigmask"):
            super().start()
            return
        resource_tracker.ensure_running()  # started with the process, it would unblock Ctrl-C
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            super().start()
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)


class _Context(SpawnContext):
    Process = _Worker


def worker_pool(workers: int) -> ProcessPoolExecutor:
    """Return a pool of new processes; a fork would copy locks held by threads."""
    return ProcessPoolExecutor(workers, mp_context=_Context(), initializer=_follow_the_parent)


def _follow_the_parent() -> None:
    """Ignore Ctrl-C, which the parent handles, and end as soon as the parent has ended, for whatever reason.

    A killed parent cannot stop its workers, and each worker keeps open the queue on which the others wait: without
    this, all of them would wait forever.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_end_after, args=(parent,), daemon=True, name="parent").start()


def _end_after(parent: multiprocessing.process.BaseProcess) -> None:
    parent.join()
    os._exit(1)
