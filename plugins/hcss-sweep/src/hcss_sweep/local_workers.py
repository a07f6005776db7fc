"""Compute points in processes on this machine, as many as save time."""

from __future__ import annotations

import os
import time
from collections.abc import Generator
from contextlib import suppress
from multiprocessing import Pipe
from multiprocessing.connection import Connection, wait
from typing import Any

from hcss_sweep.errors import SweepError
from hcss_sweep.points import DIED_TWICE, PointOutcome, PointTask, Schedule, compute
from hcss_twin.core.result_cache import ResultCache
from hcss_twin.engine.parts import Workers

WARM_UP_S = 0.3
"""Time that the first point of a new process takes more than those after it: kernels and tables are read."""


def compute_in_processes(schedule: Schedule[PointTask], most: int) -> Generator[PointOutcome]:
    """Yield the outcome of each point in order of completion, and end the processes when the generator is closed.

    The first process starts at once, and another one, up to ``most``, whenever it is expected to save more time than it
    needs to begin. A point whose process dies is computed once more at the end, while no other point is computed, so
    that only a point that ends its process fails.

    Raises
    ------
    SweepError
        If no process starts.
    """
    crew = _Crew(schedule, most)
    try:
        yield from crew.compute()
    finally:
        crew.end()


class _Worker:
    """A process and the point that it computes; its first message says that it is ready."""

    def __init__(self) -> None:
        self.pipe, theirs = Pipe()
        try:
            self.process = Workers.start(_serve, theirs)
        finally:
            theirs.close()
        self.since_s = time.perf_counter()
        self.is_ready = self.is_warm = False
        self.point: tuple[int, PointTask] | None = None

    def begin(self, point: tuple[int, PointTask]) -> None:
        self.point, self.since_s = point, time.perf_counter()
        with suppress(OSError):  # it has died, which its end of the pipe tells
            self.pipe.send(point[1])

    def end(self) -> None:
        self.process.terminate()
        self.process.join()
        self.pipe.close()


class _Crew:
    def __init__(self, schedule: Schedule[PointTask], most: int) -> None:
        self._schedule, self._most = schedule, most
        self._workers: list[_Worker] = []
        self._died: set[int] = set()
        self._lost: list[tuple[int, PointTask]] = []
        # Time of the last start, and of the last point that was not the first of its process.
        self._start_s = self._point_s = 0.0

    def end(self) -> None:
        for worker in self._workers:
            worker.end()

    def compute(self) -> Generator[PointOutcome]:
        while True:
            for worker in self._workers:
                following = self._following() if worker.is_ready and worker.point is None else None
                if following is not None:
                    worker.begin(following)
            while self._needs_another():
                self._start()
            if all(worker.is_ready and worker.point is None for worker in self._workers):
                return
            can_grow = len(self._workers) < self._most and self._schedule.ready > 0
            pipes: dict[Any, _Worker] = {worker.pipe: worker for worker in self._workers}
            for pipe in wait(pipes, WARM_UP_S if can_grow else None):
                outcome = self._received(pipes[pipe])
                if outcome is not None:
                    yield outcome

    def _following(self) -> tuple[int, PointTask] | None:
        following = self._schedule.next()
        if following is None and self._lost and all(worker.point is None for worker in self._workers):
            return self._lost.pop(0)
        return following

    def _needs_another(self) -> bool:
        """Whether another process is expected to save more time than it costs."""
        count = len(self._workers)
        if count == 0:
            return self._schedule.left + len(self._lost) > 0
        starting = sum(not worker.is_ready for worker in self._workers)
        if count >= self._most or self._schedule.ready <= starting:
            return False
        now = time.perf_counter()
        point_s = max([self._point_s, *(now - worker.since_s for worker in self._workers if worker.point is not None)])
        saved_s = self._schedule.left * point_s * (1 / count - 1 / (count + 1))
        return saved_s > self._start_s + WARM_UP_S

    def _start(self) -> None:
        try:
            self._workers.append(_Worker())
        except OSError as error:
            if not self._workers:
                raise SweepError(f"no worker process can be started: {error}") from error
            self._most = len(self._workers)

    def _received(self, worker: _Worker) -> PointOutcome | None:
        """Return the outcome of a point, if there is one now."""
        try:
            outcome: PointOutcome | None = worker.pipe.recv()
        except (EOFError, OSError):
            return self._without(worker)
        taken_s = time.perf_counter() - worker.since_s
        if outcome is None or worker.point is None:
            worker.is_ready, self._start_s = True, taken_s
            return None
        if worker.is_warm:
            self._point_s = taken_s
        self._schedule.finished(worker.point[0], outcome.error is None)
        worker.point, worker.is_warm = None, True
        return outcome

    def _without(self, dead: _Worker) -> PointOutcome | None:
        """Remove a dead process; return the outcome of its point after the second attempt."""
        dead.end()
        self._workers.remove(dead)
        if not dead.is_ready and not self._workers:
            raise SweepError(
                "no worker process can be started (a Python script that starts them needs "
                "'if __name__ == \"__main__\":' around its own code)"
            )
        if dead.point is None:
            return None
        index, task = dead.point
        if index not in self._died:
            self._died.add(index)
            self._lost.append(dead.point)
            return None
        self._schedule.finished(index, False)
        return PointOutcome(task.point, error=DIED_TWICE)


def _serve(pipe: Connection) -> None:
    """Compute the points that arrive, each in one thread of BLAS, until the parent ends this process."""
    from threadpoolctl import threadpool_limits

    os.environ.update(dict.fromkeys(("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1"))
    threadpool_limits(1)
    cache = ResultCache(several=True)
    pipe.send(None)
    while True:
        pipe.send(compute(pipe.recv(), cache))
