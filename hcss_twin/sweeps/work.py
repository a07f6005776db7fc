"""Computing one point, in whatever process: a scenario in, a finished cube in the folder and an outcome out."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from hcss_twin.core.errors import HcssError, ScenarioError
from hcss_twin.core.result_cache import ResultCache
from hcss_twin.engine.certificate.certificate import Certificate
from hcss_twin.engine.simulate import run
from hcss_twin.plan.make_plan import make_plan
from hcss_twin.scenario.scenario import Scenario
from hcss_twin.sweeps.folder import Outcome, sha256_of

DATE = "SOURCE_DATE_EPOCH"
"""Environment variable that fixes the date of creation, and with it every byte of a cube."""


@dataclass(frozen=True)
class Task:
    """What a worker needs to know; it is sent to other processes and machines.

    Attributes
    ----------
    point : int
    scenario : Scenario
    path : str
        Absolute path of the cube.
    date : str or None
        ``SOURCE_DATE_EPOCH`` of the process that the sweep was started in.
    """

    point: int
    scenario: Scenario
    path: str
    date: str | None


def compute(task: Task, shelf: ResultCache) -> Outcome:
    """Compute a point and write its cube; whatever is wrong with the point becomes its error.

    Only an interrupt is let through.

    Parameters
    ----------
    shelf : ResultCache
        What the points of one process share.
    """
    start, path = time.perf_counter(), Path(task.path)
    found: list[Certificate] = []
    error: str | None = None
    try:
        with _date(task.date):
            run(make_plan(task.scenario, shelf=shelf), path, report=found.append)
        size, digest = path.stat().st_size, sha256_of(path)
    except ScenarioError as cause:  # what only the plan finds out
        return Outcome(task.point, seconds=_since(start), error="; ".join(map(str, cause.problems)))
    except HcssError as cause:
        return Outcome(task.point, seconds=_since(start), error=str(cause))
    except Exception as cause:  # a fault of one point must not end the others
        return Outcome(task.point, seconds=_since(start), error=f"{type(cause).__name__}: {cause}")
    for certificate in found:
        if not certificate.passed:
            error = f"certificate {certificate.lines[0]}"
    return Outcome(task.point, path.name, size, digest, _since(start), error)


def _since(start: float) -> float:
    return round(time.perf_counter() - start, 4)


@contextmanager
def _date(fixed: str | None) -> Iterator[None]:
    """Let the process have the date of creation that the sweep was started with."""
    before = os.environ.get(DATE)
    if fixed is not None:
        os.environ[DATE] = fixed
    try:
        yield
    finally:
        if fixed is not None and before is None:
            del os.environ[DATE]
        elif before is not None:
            os.environ[DATE] = before
