"""What runs in the processes of a cluster; imported where Dask is installed."""

from __future__ import annotations

from threading import Lock

from distributed import Worker, WorkerPlugin, get_worker

from hcss_twin.sweeps.record import Outcome
from hcss_twin.sweeps.work import Task, compute


class OneAtATime(WorkerPlugin):  # type: ignore[misc]  # distributed has no types
    """Points of one process take turns, because the netCDF library is not thread safe."""

    name = "hcss-one-at-a-time"

    def setup(self, worker: Worker) -> None:
        """Make what the threads of a worker share."""
        self.turn = Lock()


def compute_on_worker(task: Task) -> Outcome:
    """Compute a point when its turn has come."""
    with get_worker().plugins[OneAtATime.name].turn:
        return compute(task)
