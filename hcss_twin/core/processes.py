"""Worker processes that leave Ctrl-C to the process that started them, and never outlive it.

This module imports nothing of the package: a worker is safe before it loads the modules of its work, which takes
seconds.
"""

from __future__ import annotations

import logging
import multiprocessing
import os
import pickle
import signal
import sys
import threading
import warnings
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, Executor, Future, ThreadPoolExecutor
from contextlib import contextmanager, suppress
from multiprocessing import Pipe, resource_tracker
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess
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


class _PipePool(Executor):
    """Processes that get their work through pipes, each from a thread of this process.

    ``ProcessPoolExecutor`` needs semaphores, which systems without a writable ``/dev/shm`` do not have.
    """

    def __init__(self, workers: int) -> None:
        self._threads = ThreadPoolExecutor(workers, thread_name_prefix="worker")
        self._own = threading.local()
        self._started: list[tuple[_Worker, Connection]] = []
        self._ended = threading.Event()

    def submit(self, work: Callable[..., Any], /, *given: Any, **options: Any) -> Future[Any]:
        return self._threads.submit(self._in_process, work, given, options)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        self._threads.shutdown(wait=wait, cancel_futures=cancel_futures)
        for process, pipe in self._started:
            with suppress(OSError):
                pipe.send(None)
            process.join()
            pipe.close()

    def terminate(self) -> None:
        """End the processes without waiting for their work."""
        self._ended.set()
        for process, _ in self._started:
            process.terminate()

    def _in_process(self, work: Callable[..., Any], given: tuple[Any, ...], options: dict[str, Any]) -> Any:
        worker = getattr(self._own, "worker", None)
        if worker is None:
            worker = self._own.worker = self._start()
        process, pipe = worker
        try:
            pipe.send((work, given, options))
            succeeded, result = pipe.recv()
        except (EOFError, OSError) as error:
            self._own.worker = None
            process.join()
            raise BrokenExecutor(ended(process.exitcode)) from error
        if not succeeded:
            raise result
        return result

    def _start(self) -> tuple[_Worker, Connection]:
        if self._ended.is_set():
            raise BrokenExecutor("it was stopped")
        ours, theirs = Pipe()
        process = _Worker(target=_serve, args=(theirs,))
        try:
            process.start()
        except OSError as error:
            ours.close()
            raise BrokenExecutor(f"it did not start: {error}") from error
        finally:
            theirs.close()
        self._started.append((process, ours))
        if self._ended.is_set():  # while it started
            process.terminate()
        return process, ours


def ended(code: int | None) -> str:
    """Say how a process has ended, from its exit code."""
    if code is not None and code < 0:
        with suppress(ValueError):
            return f"killed by {signal.Signals(-code).name}"
    return f"exit code {code}"


def _serve(pipe: Connection) -> None:
    """Do the work that arrives, until None does or the other end of the pipe is closed."""
    _follow_the_parent()
    with suppress(EOFError, OSError):
        while (received := pipe.recv()) is not None:
            work, given, options = received
            try:
                answer: tuple[bool, Any] = True, work(*given, **options)
            except Exception as error:  # the parent raises it
                answer = False, error
            try:
                pipe.send(answer)
            except (pickle.PicklingError, TypeError, AttributeError) as error:
                pipe.send((False, RuntimeError(f"cannot send {type(answer[1]).__name__}: {error}")))


@contextmanager
def worker_pool(workers: int) -> Iterator[Executor]:
    """Yield a pool of processes; after an exception, they are ended without waiting for their work."""
    pool = _PipePool(workers)
    try:
        yield pool
    except BaseException:
        pool.terminate()
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
