"""Processes of a sweep: as many as save time, none left behind, and a death costs at most the point that caused it."""

import os
import sys
import time
from types import SimpleNamespace

import psutil
import pytest
from hcss_sweep import local_workers
from hcss_sweep.points import PointOutcome, Schedule

from hcss_twin.core import processes

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="copied processes have the function that is patched")


def computed(monkeypatch, count, work, warm_up_s=0.0, most=2):
    """Outcomes of points whose ``work(number)`` replaces the simulation; their file is the process that did it."""

    def compute(task, cache):
        work(task.point)
        return PointOutcome(task.point, file=str(os.getpid()))

    monkeypatch.setattr(processes, "can_copy", lambda: True)  # in spite of the threads of pytest-xdist
    monkeypatch.setattr(local_workers, "compute", compute)
    monkeypatch.setattr(local_workers, "WARM_UP_S", warm_up_s)
    tasks = [SimpleNamespace(point=number) for number in range(count)]
    return local_workers.compute_in_processes(Schedule(tasks, lambda task: str(task.point)), most)


def test_long_points_are_shared_by_processes(monkeypatch):
    outcomes = list(computed(monkeypatch, 6, lambda _: time.sleep(0.2)))
    assert sorted(outcome.point for outcome in outcomes) == list(range(6))
    assert len({outcome.file for outcome in outcomes}) == 2


def test_points_that_take_less_than_a_start_stay_in_one_process(monkeypatch):
    outcomes = list(computed(monkeypatch, 20, lambda _: None, warm_up_s=60.0))
    assert len({outcome.file for outcome in outcomes}) == 1


def test_a_point_whose_process_dies_is_computed_once_more_alone(monkeypatch, tmp_path):
    mark = tmp_path / "died"

    def work(number):
        if number == 1 or (number == 2 and not mark.exists()):
            if number == 2:
                mark.touch()
            os._exit(9)

    outcomes = list(computed(monkeypatch, 5, work))
    assert sorted(outcome.point for outcome in outcomes) == list(range(5))
    assert {outcome.point for outcome in outcomes[-2:]} == {1, 2}
    assert [outcome.point for outcome in outcomes if outcome.error == local_workers.DIED_TWICE] == [1]


def test_processes_end_with_the_sweep(monkeypatch):
    outcomes = computed(monkeypatch, 50, lambda _: time.sleep(0.1))
    seen = {int(next(outcomes).file) for _ in range(4)}
    outcomes.close()
    assert len(seen) == 2
    assert not any(psutil.pid_exists(process) for process in seen)
