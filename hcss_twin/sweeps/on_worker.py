"""What runs in the processes of a cluster; imported where Dask is installed."""

from __future__ import annotations

import signal
from threading import Lock

from distributed import Worker, WorkerPlugin, get_worker

from hcss_twin.core.result_cache import ResultCache
from hcss_twin.sweeps.folder import Outcome
from hcss_twin.sweeps.work import Task, compute


class PointWorker(WorkerPlugin):  # type: ignore[misc]  # distributed has no types
    """What the points of one process share; they take turns, because the netCDF library is not thread safe.

    Parameters
    ----------
    is_ours : bool
        Whether the process was started for the sweep. Ctrl-C in a terminal reaches it too, but it is ended by who
        started it.
    """

    name = "hcss-point-worker"
    # Sweeps that meet on a cluster take turns, too: who comes first brings it, and it stays.
    idempotent = True

    def __init__(self, is_ours: bool) -> None:
        self._is_ours = is_ours

    def setup(self, worker: Worker) -> None:
        """Make what the threads of a worker share."""
        self.turn, self.shelf = Lock(), ResultCache()
        if self._is_ours:
            signal.signal(signal.SIGINT, signal.SIG_IGN)


def compute_on_worker(task: Task) -> Outcome:
    """Compute a point when its turn has come."""
    here = get_worker().plugins[PointWorker.name]
    with here.turn:
        return compute(task, here.shelf)
