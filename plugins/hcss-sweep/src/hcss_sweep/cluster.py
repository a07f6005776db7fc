"""Compute points on an existing Dask cluster.

Import this module only if Dask is installed.
"""

from __future__ import annotations

import os
import secrets
from collections.abc import Iterator
from contextlib import suppress
from importlib import metadata
from itertools import islice
from pathlib import Path
from threading import Lock
from typing import Any

from distributed import Worker, WorkerPlugin, as_completed, get_worker
from distributed.scheduler import KilledWorker

from hcss_sweep.errors import SweepError
from hcss_sweep.points import DIED_TWICE, PointOutcome, PointTask, Schedule, compute
from hcss_twin.core.result_cache import ResultCache
from hcss_twin.engine.cluster import Cluster

IN_HAND = 2
"""Points assigned to a worker: one being computed and one queued."""


def worker_versions() -> dict[str, str]:
    """Return the versions that must be those of all workers: what affects the numbers, and this package."""
    try:
        own = metadata.version("hcss-sweep")
    except metadata.PackageNotFoundError:
        own = "not installed"
    return ResultCache().versions() | {"hcss-sweep": own}


class PointWorker(WorkerPlugin):  # type: ignore[misc]  # distributed has no types
    """State shared by the points of one process; points run one at a time, because the netCDF library is not thread
    safe.
    """

    name = "hcss-point-worker"
    # Concurrent sweeps on a cluster share the plugin of the first one, so they take turns, too.
    idempotent = True

    def setup(self, worker: Worker) -> None:
        """Create the state shared by the threads of a worker."""
        self.turn, self.cache = Lock(), ResultCache(several=True)


def compute_on_worker(task: PointTask) -> PointOutcome:
    """Compute a point when it is its turn."""
    worker = get_worker().plugins[PointWorker.name]
    with worker.turn:
        return compute(task, worker.cache)


class SweepCluster:
    """Workers that share the folder of the sweep.

    Each worker computes one point while another is queued. If a worker dies, both are lost; they are retried at the
    end, each alone on a worker, so that only a point that kills its worker fails.
    """

    def __init__(self, cluster: Cluster, folder: Path) -> None:
        self._cluster, self._client, self._folder = cluster, cluster.client, folder
        self._known: set[str] = set()
        self._require_alike(cluster.workers())
        self._client.register_plugin(PointWorker())

    def compute(self, schedule: Schedule[PointTask]) -> Iterator[PointOutcome]:
        """Yield the outcome of each point in order of completion."""
        under_way: dict[Any, tuple[int, PointTask]] = {}
        suspects: list[tuple[int, PointTask]] = []
        alone = False
        finished = as_completed(loop=self._client.loop)
        try:
            while True:
                addresses = self._cluster.workers()
                self._require_alike(addresses)
                workers = max(1, len(addresses))
                following: list[tuple[int, PointTask]] = []
                if not alone or not under_way:
                    alone = False
                    room = IN_HAND * workers - len(under_way)
                    following = list(islice(iter(schedule.next, None), max(0, room)))
                if not under_way and not following:
                    alone, following, suspects = True, suspects[:workers], suspects[workers:]
                for numbered_task in following:
                    future = self._submit(numbered_task[1])
                    under_way[future] = numbered_task
                    finished.add(future)
                if not under_way:
                    return
                self._cluster.wait(finished.has_ready)
                future = next(finished)
                index, task = under_way.pop(future)
                outcome = self._outcome(future, task)
                if outcome is None and not alone:
                    suspects.append((index, task))
                    continue
                outcome = outcome or PointOutcome(task.point, error=DIED_TWICE)
                schedule.finished(index, outcome.error is None)
                yield outcome
        finally:
            with suppress(Exception):  # the scheduler is gone
                self._client.cancel(list(under_way), force=True)

    def _submit(self, task: PointTask) -> Any:
        # Another sweep on the cluster, or a retry, may use the same point number.
        key = f"hcss-point-{secrets.token_hex(4)}-{task.point}"
        return self._client.submit(compute_on_worker, task, pure=False, key=key)

    def _outcome(self, future: Any, task: PointTask) -> PointOutcome | None:
        """Return the outcome of a point; None if its worker died."""
        if future.status in ("cancelled", "lost"):
            raise SweepError(self._cluster.lost)
        error = future.exception()
        if error is None:
            outcome: PointOutcome = future.result()
            return outcome
        if isinstance(error, KilledWorker):
            return None
        return PointOutcome(task.point, error=f"{type(error).__name__}: {error}")

    def _require_alike(self, addresses: tuple[str, ...]) -> None:
        """Check that workers have the same versions and access to the folder, each worker once.

        Raises SweepError if a worker fails the check.
        """
        new = sorted(set(addresses) - self._known)
        if not new:
            return
        mine = worker_versions()
        for address, theirs in self._client.run(worker_versions, workers=new, on_error="return").items():
            if isinstance(theirs, ImportError):
                raise SweepError(f"the worker at {address} cannot import hcss_sweep: {theirs}")
            if isinstance(theirs, OSError):  # it has just gone
                continue
            if isinstance(theirs, BaseException):
                raise SweepError(f"the worker at {address} fails: {type(theirs).__name__}: {theirs}")
            other = [
                f"{name} {theirs.get(name)}, here {version}"
                for name, version in mine.items()
                if theirs.get(name) != version
            ]
            if other:
                raise SweepError(
                    f"the worker at {address} has other versions, which may round differently: {'; '.join(other)}"
                )
        sees = self._client.run(os.path.isdir, str(self._folder), workers=new, on_error="return")
        for address, there in sees.items():
            if there is False:
                raise SweepError(
                    f"the worker at {address} does not see the folder {self._folder}; allowed: a folder that this "
                    "machine and all workers share under the same path"
                )
        self._known.update(new)
