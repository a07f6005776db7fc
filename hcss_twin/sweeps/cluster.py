"""Compute points on an existing Dask cluster.

Import this module only if Dask is installed.
"""

from __future__ import annotations

import os
import re
import secrets
import socket
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from itertools import islice
from pathlib import Path
from threading import Lock
from typing import Any

from distributed import Client, Worker, WorkerPlugin, as_completed, get_worker
from distributed.scheduler import KilledWorker

from hcss_twin.core.environment import versions
from hcss_twin.core.errors import SweepError
from hcss_twin.core.processes import silenced
from hcss_twin.core.result_cache import ResultCache
from hcss_twin.sweeps.points import DIED_TWICE, PointOutcome, PointTask, Schedule, compute

IN_HAND = 2
"""Points assigned to a worker: one being computed and one queued."""

_CONNECT_S = 10
_ADDRESS = re.compile(r"(?:t(?:cp|ls)://)?([^:/\[\]]+|\[[^\]/]+\]):([0-9]{1,5})")


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
    here = get_worker().plugins[PointWorker.name]
    with here.turn:
        return compute(task, here.cache)


class Cluster:
    """Workers that share the folder of the sweep.

    Each worker computes one point while another is queued. If a worker dies, both are lost; they are retried at the
    end, each alone on a worker, so that only a point that kills its worker fails.
    """

    def __init__(self, client: Any) -> None:
        self._client = client
        client.register_plugin(PointWorker())

    def compute(self, schedule: Schedule[PointTask]) -> Iterator[PointOutcome]:
        """Yield the outcome of each point in order of completion."""
        under_way: dict[Any, tuple[int, PointTask]] = {}
        suspects: list[tuple[int, PointTask]] = []
        alone = False
        finished = as_completed(loop=self._client.loop)
        try:
            while True:
                workers = max(1, len(self._client.nthreads()))
                following: list[tuple[int, PointTask]] = []
                if not alone or not under_way:
                    alone = False
                    room = IN_HAND * workers - len(under_way)
                    following = list(islice(iter(schedule.next, None), max(0, room)))
                if not under_way and not following:
                    alone, following, suspects = True, suspects[:workers], suspects[workers:]
                for each in following:
                    future = self._submit(each[1])
                    under_way[future] = each
                    finished.add(future)
                if not under_way:
                    return
                future = next(finished)
                index, task = under_way.pop(future)
                outcome = _outcome(future, task)
                if outcome is None and not alone:
                    suspects.append((index, task))
                    continue
                outcome = outcome or PointOutcome(task.point, error=DIED_TWICE)
                schedule.finished(index, outcome.error is None)
                yield outcome
        finally:
            with suppress(OSError, TimeoutError):  # the scheduler is gone
                self._client.cancel(list(under_way), force=True)

    def _submit(self, task: PointTask) -> Any:
        # Another sweep on the cluster, or a retry, may use the same point number.
        key = f"hcss-point-{secrets.token_hex(4)}-{task.point}"
        return self._client.submit(compute_on_worker, task, pure=False, key=key)

    def require_alike(self, folder: Path) -> None:
        """Check that every worker has the same versions and access to the folder.

        Raises SweepError if a worker fails the check.
        """
        mine = versions()
        for address, theirs in self._client.run(versions).items():
            other = [f"{name} {theirs.get(name)}, here {own}" for name, own in mine.items() if theirs.get(name) != own]
            if other:
                raise SweepError(
                    f"the worker at {address} has other versions, which may round differently: {'; '.join(other)}"
                )
        for address, sees in self._client.run(os.path.isdir, str(folder)).items():
            if not sees:
                raise SweepError(
                    f"the worker at {address} does not see the folder {folder}; allowed: a folder that this machine "
                    "and all workers share under the same path"
                )


@contextmanager
def remote_cluster(scheduler: str, folder: Path) -> Iterator[Cluster]:
    """Use the workers of an existing scheduler, and leave them running.

    Raises SweepError if no scheduler answers at the address, or the workers are unsuitable.
    """
    _require_answer(scheduler)
    try:
        client = Client(scheduler, set_as_default=False, timeout=_CONNECT_S)
    except (OSError, ValueError) as error:
        raise SweepError(f"no Dask scheduler answers at {scheduler}: {error}") from error
    with silenced("distributed.client"), client:
        cluster = Cluster(client)
        cluster.require_alike(folder)
        yield cluster


def _require_answer(scheduler: str) -> None:
    """Check that a scheduler is listening, because Dask alone would keep retrying."""
    address = _ADDRESS.fullmatch(scheduler)
    if address is None:
        raise SweepError(
            f"'{scheduler}' is not the address of a Dask scheduler; allowed: tcp://HOST:PORT or tls://HOST:PORT, "
            "for example tcp://127.0.0.1:8786"
        )
    host, port = address.groups()
    try:
        socket.create_connection((host.strip("[]"), int(port)), _CONNECT_S).close()
    except (OSError, OverflowError) as error:
        raise SweepError(f"no Dask scheduler answers at {scheduler}: {error}") from error


def _outcome(future: Any, task: PointTask) -> PointOutcome | None:
    """Return the outcome of a point; None if its worker died."""
    if future.status in ("cancelled", "lost"):
        raise SweepError("the connection to the Dask scheduler is lost; run the sweep again to resume it")
    error = future.exception()
    if error is None:
        outcome: PointOutcome = future.result()
        return outcome
    if isinstance(error, KilledWorker):
        return None
    return PointOutcome(task.point, error=f"{type(error).__name__}: {error}")
