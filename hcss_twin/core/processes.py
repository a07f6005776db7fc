"""Worker processes that leave Ctrl-C to the process that started them, and never outlive it.

This module imports nothing of the package: a worker is safe before it loads the modules of its work, which takes
seconds.
"""

from __future__ import annotations

import logging
import multiprocessing
import os
import signal
import sys
import threading
import warnings
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import resource_tracker
from multiprocessing.context import SpawnContext, SpawnProcess
from multiprocessing.process import BaseProcess
from typing import Any

from hcss_twin.core.errors import CacheWarning


@contextmanager
def _signals_held() -> Iterator[None]:
    """Block signals while a process starts, so that none runs handlers of this process in the new one.

    The new process inherits the block; :func:`_follow_the_parent` lifts it for SIGTERM.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGTERM})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


class _Worker(SpawnProcess):
    """A process that starts with blocked signals: interrupted while it starts, it would print a traceback."""

    def start(self) -> None:
        if os.name == "posix":
            resource_tracker.ensure_running()  # started with the process, it would unblock Ctrl-C
        with _signals_held():
            super().start()


class _Context(SpawnContext):
    """Starts new processes, because a fork would copy locks held by threads, and knows them."""

    def __init__(self) -> None:
        super().__init__()
        self.started: list[_Worker] = []

    def Process(self, *args: Any, **options: Any) -> _Worker:  # type: ignore[override]  # a class in the base class
        worker = _Worker(*args, **options)
        self.started.append(worker)
        return worker


@contextmanager
def worker_pool(workers: int) -> Iterator[ProcessPoolExecutor]:
    """Yield a pool of processes; after an exception, they are ended without waiting for their work."""
    context = _Context()
    pool = ProcessPoolExecutor(workers, mp_context=context, initializer=_follow_the_parent)
    try:
        yield pool
    except BaseException:
        for each in context.started:
            each.terminate()
        raise
    finally:
        pool.shutdown(cancel_futures=True)


def start_worker(work: Callable[..., None], *given: Any) -> BaseProcess:
    """Start a process that calls ``work(*given)`` and never outlives this one: a copy, or else a new process.

    Raises
    ------
    OSError
        If the system starts no more processes.
    """
    if can_copy():
        return start_copy(work, *given)
    worker = _Worker(target=_work, args=(work, given), daemon=True)
    worker.start()
    return worker


def can_copy() -> bool:
    """Whether this process can be copied: on Linux, while no other thread may hold a lock."""
    return sys.platform == "linux" and threading.active_count() == 1 and not multiprocessing.current_process().daemon


def start_copy(work: Callable[..., None], *given: Any) -> BaseProcess:
    """Start a copy of this process, with all its modules, in milliseconds; otherwise as :func:`start_worker`."""
    copy = multiprocessing.get_context("fork").Process(target=_work, args=(work, given), daemon=True)
    with _signals_held(), warnings.catch_warnings():
        # Python warns of threads of BLAS, too, which prepares them for this itself.
        warnings.simplefilter("ignore", DeprecationWarning)
        copy.start()
    return copy


def _work(work: Callable[..., None], given: tuple[Any, ...]) -> None:
    _follow_the_parent()
    work(*given)


def _follow_the_parent() -> None:
    """Ignore Ctrl-C, which the parent handles, and end as soon as the parent has ended, for whatever reason.

    A killed parent cannot stop its workers, and each worker keeps open the queue on which the others wait: without
    this, all of them would wait forever.
    """
    warnings.simplefilter("ignore", CacheWarning)  # the parent has said it
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGTERM})
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_end_after, args=(parent,), daemon=True, name="parent").start()


def _end_after(parent: BaseProcess) -> None:
    parent.join()
    os._exit(1)


@contextmanager
def silenced(logger: str) -> Iterator[None]:
    """Keep a library from printing errors that its caller reports itself, such as a lost connection."""
    log = logging.getLogger(logger)
    level = log.level
    log.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        log.setLevel(level)
