"""Times of the stages of a run, measured separately through the functions of the run.

Stages, whole runs and raw writes of the same bytes alternate: the speed of a shared disk or processor drifts, but
ratios within one round are stable.
"""

from __future__ import annotations

import os
import statistics
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from hcss_twin import Scenario, make_plan
from hcss_twin.core.files import Writing
from hcss_twin.engine.certificate.certificate import Certificate
from hcss_twin.engine.compile import tables_of
from hcss_twin.engine.simulate import run
from hcss_twin.engine.stream import PartMaker
from hcss_twin.engine.tables.radiance_tables import RadianceTables
from hcss_twin.plan.plan import Plan


@contextmanager
def private_cache(folder: Path) -> Iterator[None]:
    """Use an empty cache in a folder while the block runs, so that no earlier result is used and none remains."""
    settings = {"HCSS_CACHE_DIR": str(folder), "HCSS_CACHE_MB": "10000"}
    before = {name: os.environ.get(name) for name in settings}
    os.environ.update(settings)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


class Watch:
    """Progress of a run that measures what is not the computation of frames.

    Attributes
    ----------
    computing : float
        Seconds in which the run computed frames, or waited for those who do.
    ended : float
        When the last frame was there.
    """

    def __init__(self) -> None:
        self.computing, self.ended = 0.0, 0.0
        self._began = 0.0

    def __call__(self, parts: Iterable[Any], count: int) -> Iterator[Any]:
        """Yield the parts of a run."""
        self._began = before = time.perf_counter()
        for part in parts:
            self.computing += time.perf_counter() - before
            yield part
            before = time.perf_counter()
        self.ended = time.perf_counter()

    def other(self) -> float:
        """Return the seconds from the first frame until now that were not spent on the computation of frames."""
        return time.perf_counter() - self._began - self.computing


def write_raw(path: Path, plane: NDArray[Any], times: int) -> None:
    """Write an array a number of times in sequence to a preallocated file.

    Like a cube, the file is written under another name, flushed to disk, and replaces an older file atomically.

    Raises
    ------
    OSError
        If writing fails; no file remains.
    """
    draft = path.with_name(f".{path.name}.partial")
    data = np.ascontiguousarray(plane).data.cast("B")
    try:
        with draft.open("wb", buffering=0) as file:
            if hasattr(os, "posix_fallocate"):
                os.posix_fallocate(file.fileno(), 0, data.nbytes * times)
            else:
                file.truncate(data.nbytes * times)
            for _ in range(times):
                written = 0
                while written < data.nbytes:  # one call writes at most 2 GiB
                    written += file.write(data[written:])
            os.fsync(file.fileno())
        draft.replace(path)
    except BaseException:
        draft.unlink(missing_ok=True)
        raise
    Writing.flush(path.parent)


_T = TypeVar("_T")


class Rounds:
    """Times in seconds of named tasks, round by round.

    The speed of a shared machine drifts. Alternating tasks run under the same conditions, so ratios are taken within a
    round; the result is their median over rounds.
    """

    def __init__(self) -> None:
        self._seconds: dict[str, list[float]] = {}

    def time(self, name: str, call: Callable[[], _T]) -> _T:
        """Call a function and record its time as one round of ``name``."""
        start = time.perf_counter()
        result = call()
        self.add(name, time.perf_counter() - start)
        return result

    def add(self, name: str, seconds: float) -> None:
        """Record a time that was measured elsewhere."""
        self._seconds.setdefault(name, []).append(seconds)

    def last(self, name: str) -> float:
        """Time of the last round, s."""
        return self._seconds[name][-1]

    def seconds(self, name: str) -> float:
        """Median over rounds."""
        return statistics.median(self._seconds[name])

    def ratio(self, above: str, below: str) -> float:
        """Median ratio of two times, over the rounds that have both.

        Slow tasks may be timed in the first rounds only.
        """
        pairs = zip(self._seconds[above], self._seconds[below], strict=False)
        return statistics.median(one / other for one, other in pairs)

    def shortest(self, name: str) -> float:
        """Shortest time of all rounds."""
        return min(self._seconds[name])

    def shortest_ratio(self, above: str, below: str) -> float:
        """Ratio of the shortest times, which other load on the machine affects least."""
        return self.shortest(above) / self.shortest(below)


PLAN, COMPILE, KEPT = "plan", "compile tables", "tables kept earlier"
CLOUDS, LOOK_UP, WRITE = "clouds", "look-up", "write"
CERTIFICATE = "certificate"
STAGES = (PLAN, COMPILE, KEPT, CLOUDS, LOOK_UP, WRITE)
KEPT_RUN, NEW_RUN = "whole run, kept tables", "whole run, new tables"
RUNS = (NEW_RUN, KEPT_RUN)
RAW = "raw write of the same bytes"


def time_stages(rounds: Rounds, prefix: str, scenario: Scenario, folder: Path, compiled: bool) -> None:
    """Time all stages of a scenario, its whole run, and a raw write of the same bytes, as one round.

    The whole run uses cached tables and makes no certificate; a run with new tables takes longer by the difference
    between compiling and loading them. Writing is what the whole run takes beside the computation of frames, from the
    first one until the file is complete; a part of it may happen during the computation, which costs nothing.

    Parameters
    ----------
    prefix : str
        Prefix of the stage names.
    folder : Path
        Where cubes are written.
    compiled : bool
        Whether to compile tables, which must not be in the cache; otherwise they must.
    """
    plan = rounds.time(prefix + PLAN, lambda: make_plan(scenario))
    if compiled:
        rounds.time(prefix + COMPILE, lambda: tables_of(plan))
    tables = rounds.time(prefix + KEPT, lambda: tables_of(plan))
    frame = _time_frames(rounds, prefix, plan, tables)
    watch = Watch()

    def whole_run() -> float:
        run(make_plan(scenario), folder / "cube.nc", watch)
        return watch.other()

    rounds.add(prefix + WRITE, rounds.time(prefix + KEPT_RUN, whole_run))
    if compiled:
        instead = rounds.last(prefix + COMPILE) - rounds.last(prefix + KEPT)
        rounds.add(prefix + NEW_RUN, rounds.last(prefix + KEPT_RUN) + instead)
    planes = np.concatenate([np.ravel(array).view(np.uint8) for array in frame.values()])
    rounds.time(prefix + RAW, lambda: write_raw(folder / "raw.bin", planes, plan.frame_times_s.size))


def time_certificate(rounds: Rounds, prefix: str, scenario: Scenario, folder: Path) -> Certificate:
    """Run a scenario, time the check after its last frame until the file is complete, and return the certificate.

    Parameters
    ----------
    scenario : Scenario
        Its ``output.certificate`` is the number of pixels.
    """
    watch, found = Watch(), list[Certificate]()
    run(make_plan(scenario), folder / "cube.nc", watch, found.append)
    rounds.add(prefix + CERTIFICATE, time.perf_counter() - watch.ended)
    return found[0]


def _time_frames(rounds: Rounds, prefix: str, plan: Plan, tables: RadianceTables) -> dict[str, NDArray[Any]]:
    """Compute all frames and return the last one; time not spent on clouds counts as look-up."""
    maker, clouds = PartMaker(plan, tables), 0.0
    frame: dict[str, NDArray[Any]] = {}
    start = time.perf_counter()
    for index in range(plan.frame_times_s.size):
        frame, _ = maker.part(index, plan.extent)
        clouds += maker.seconds["clouds"]
    rounds.add(prefix + CLOUDS, clouds)
    rounds.add(prefix + LOOK_UP, time.perf_counter() - start - clouds)
    return frame
