"""Times of the stages of a run, measured separately through the functions of the run.

Stages, whole runs and raw writes of the same bytes alternate: the speed of a shared disk or processor drifts, but
ratios within one round are stable.
"""

from __future__ import annotations

import dataclasses
import os
import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from hcss_twin import Scenario, make_plan
from hcss_twin.core.cache import TABLES, Store
from hcss_twin.core.files import Writing
from hcss_twin.cube.writer import CubeWriter
from hcss_twin.engine.certificate.certificate import Certificate
from hcss_twin.engine.certificate.certificate_pixels import PixelSample
from hcss_twin.engine.certificate.certify import certify
from hcss_twin.engine.compile import tables_of
from hcss_twin.engine.simulate import cube_header, run
from hcss_twin.engine.stream import stream
from hcss_twin.engine.tables.over_views import plans_over_views
from hcss_twin.engine.tables.radiance_tables import RadianceTables
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import CloudGenerator


@dataclass
class Clock:
    """Seconds spent so far."""

    seconds: float = 0.0


class _Timed:
    """A generator wrapper that measures its run time."""

    def __init__(self, generator: CloudGenerator, clock: Clock) -> None:
        self._generator, self._clock = generator, clock
        self.declares = generator.declares

    def __getattr__(self, name: str) -> Any:
        return getattr(self._generator, name)

    def thickness_m(self, time_s: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        """Return the thickness of a window."""
        start = time.perf_counter()
        try:
            return self._generator.thickness_m(time_s, rows, columns)
        finally:
            self._clock.seconds += time.perf_counter() - start


def with_timed_clouds(plan: Plan, clock: Clock) -> Plan:
    """Return a plan that produces the same frames and times its cloud generators."""
    generators = tuple(_Timed(generator, clock) for generator in plan.assembly.generators)
    return dataclasses.replace(plan, assembly=dataclasses.replace(plan.assembly, generators=generators))


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
    between compiling and loading them.

    Parameters
    ----------
    prefix : str
        Prefix of the stage names.
    folder : Path
        Where cubes are written.
    compiled : bool
        Whether to compile tables; otherwise they are in the cache.
    """
    output = folder / "cube.nc"
    plan = rounds.time(prefix + PLAN, lambda: make_plan(scenario))
    if compiled:
        for toward in (plan, *plans_over_views(plan)):
            Store(*TABLES).forget(RadianceTables.key_of(toward))
        rounds.time(prefix + COMPILE, lambda: tables_of(plan))
    tables = rounds.time(prefix + KEPT, lambda: tables_of(plan))
    frame = _time_frames(rounds, prefix, plan, tables)
    rounds.time(prefix + WRITE, lambda: _write(plan, tables, frame, output))
    rounds.time(prefix + KEPT_RUN, lambda: run(make_plan(scenario), output))
    if compiled:
        instead = rounds.last(prefix + COMPILE) - rounds.last(prefix + KEPT)
        rounds.add(prefix + NEW_RUN, rounds.last(prefix + KEPT_RUN) + instead)
    planes = np.concatenate([np.ravel(array).view(np.uint8) for array in frame.values()])
    rounds.time(prefix + RAW, lambda: write_raw(folder / "raw.bin", planes, plan.frame_times_s.size))


def time_certificate(rounds: Rounds, prefix: str, scenario: Scenario) -> Certificate:
    """Compute the frames that a certificate checks, time the check, and return the certificate.

    Parameters
    ----------
    scenario : Scenario
        Its ``output.certificate`` is the number of pixels.
    """
    plan = make_plan(scenario)
    tables, sample = tables_of(plan), PixelSample(plan)
    drawn = list(sample.counts)
    for _ in stream(plan, tables, sample, drawn):
        pass
    return rounds.time(prefix + CERTIFICATE, lambda: certify(plan, tables, sample.frames))


def _time_frames(rounds: Rounds, prefix: str, plan: Plan, tables: RadianceTables) -> dict[str, NDArray[Any]]:
    """Compute all frames and return the last one; time not spent on clouds counts as look-up."""
    clock = Clock()
    frame: dict[str, NDArray[Any]] = {}
    start = time.perf_counter()
    for computed in stream(with_timed_clouds(plan, clock), tables):
        frame = computed
    whole = time.perf_counter() - start
    rounds.add(prefix + CLOUDS, clock.seconds)
    rounds.add(prefix + LOOK_UP, whole - clock.seconds)
    return frame


def _write(plan: Plan, tables: RadianceTables, frame: dict[str, NDArray[Any]], output: Path) -> None:
    compression = plan.scenario.output.compression or None
    with CubeWriter(output, cube_header(plan, tables), compression=compression) as writer:
        for index in range(plan.frame_times_s.size):
            writer.write_frame(index, frame)
