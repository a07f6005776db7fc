"""Points computed one after the other in this process."""

from __future__ import annotations

from collections.abc import Iterator

from hcss_twin.shelf import Shelf
from hcss_twin.sweeps.record import Outcome
from hcss_twin.sweeps.schedule import Schedule
from hcss_twin.sweeps.work import Task, compute


def compute_here(schedule: Schedule[Task]) -> Iterator[Outcome]:
    """Yield the outcome of each point."""
    shelf = Shelf()
    while (following := schedule.next()) is not None:
        index, task = following
        outcome = compute(task, shelf)
        schedule.finished(index, outcome.error is None)
        yield outcome
