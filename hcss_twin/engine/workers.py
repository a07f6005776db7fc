"""Executors for the parts of a scene: processes of this machine, or a Dask cluster."""

from __future__ import annotations

import multiprocessing
import signal
from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import contextmanager

from hcss_twin.core.errors import HcssError


@contextmanager
def executor_of(workers: int, scheduler: str | None = None) -> Iterator[tuple[Executor | None, int]]:
    """Give an executor and its number of workers for the time of a run; none where the caller does the work.

    Parameters
    ----------
    workers : int
        Processes of this machine; 1 is none but the caller's.
    scheduler : str, optional
        Address of the scheduler of a Dask cluster, used instead.

    Raises
    ------
    HcssError
        If the cluster cannot be reached or ``distributed`` is not installed.
    """
    if scheduler is not None:
        with _cluster(scheduler) as cluster:
            yield cluster
    elif workers == 1:
        yield None, 1
    else:
        # A fork would copy threads' locks; a new process has none.
        context = multiprocessing.get_context("spawn")
        pool = ProcessPoolExecutor(workers, mp_context=context, initializer=_leave_signals_to_the_parent)
        try:
            yield pool, workers
        finally:
            pool.shutdown(cancel_futures=True)


@contextmanager
def _cluster(scheduler: str) -> Iterator[tuple[Executor, int]]:
    try:
        from distributed import Client
    except ImportError as error:
        raise HcssError(f"--scheduler {scheduler}: needs the package 'distributed', which is not installed") from error
    try:
        client = Client(scheduler)
    except (OSError, ValueError) as error:
        raise HcssError(f"--scheduler {scheduler}: {error}") from error
    with client:
        count = len(client.scheduler_info(-1)["workers"])
        if count == 0:
            raise HcssError(f"--scheduler {scheduler}: the cluster has no workers")
        yield client.get_executor(), count


def _leave_signals_to_the_parent() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
