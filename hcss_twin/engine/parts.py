"""Parts of frames: whole small frames or tiles of large ones, computed here or by an executor.

The tiles of a frame depend only on the plan, not on the executor, because the certificate samples pixels tile by tile
and the chunks of the cube are tiles.
"""

from __future__ import annotations

import itertools
import json
import math
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from multiprocessing.process import BaseProcess
from pathlib import Path
from threading import Lock
from typing import TYPE_CHECKING, Any, TypeVar

from hcss_twin.core.errors import HcssError, ProviderError
from hcss_twin.core.memory import naming_memory, out_of_memory
from hcss_twin.core.processes import start_worker, worker_pool
from hcss_twin.engine.clouds import summaries_of
from hcss_twin.engine.stages.stage import Frame
from hcss_twin.engine.stream import PartMaker
from hcss_twin.plan.make_plan import make_plan
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.windows import Window, cut, length, relative
from hcss_twin.scenario.scenario import Scenario

if TYPE_CHECKING:
    from hcss_twin.engine.certificate.certificate_pixels import PixelSample
    from hcss_twin.engine.certificate.part_sample import DrawnPixels
    from hcss_twin.engine.cluster import Cluster
    from hcss_twin.engine.tables.radiance_tables import RadianceTables

__all__ = ["Workers"]

LARGEST_FRAME_BYTES = 2**28
"""Frames larger than this in the cube are computed in tiles."""

TILE_BYTES = 2**26
"""Maximum size of the variables of one tile."""

TILE_PIXELS = 2**21
"""Maximum size of one tile."""


def tile_shape(plan: Plan) -> tuple[int, int] | None:
    """Return rows and columns of a tile (fewer at the far edges); None if frames are computed whole.

    Nearly square tiles minimise slant paths across tile borders and the extra data that readers of a window load.
    """
    rows, columns = plan.pixels
    frame_bytes = plan.uncompressed_bytes // plan.frame_times_s.size
    if frame_bytes <= LARGEST_FRAME_BYTES:
        return None
    bytes_per_pixel = math.ceil(frame_bytes / (rows * columns))
    side = max(1, math.isqrt(min(TILE_PIXELS, TILE_BYTES // bytes_per_pixel)))
    # A long, narrow image is divided along its length only.
    height = _evenly(rows, max(side, side * side // columns))
    return height, _evenly(columns, max(side, side * side // height))


def tiles(plan: Plan) -> list[Window]:
    """Return the tiles (rows, columns) of each frame, in pixels of the image, row by row."""
    shape = tile_shape(plan)
    return [plan.extent] if shape is None else list(cut(plan.extent, *shape))


def _evenly(size: int, most: int) -> int:
    """Largest part when a length is divided into as few nearly equal parts as possible, each at most ``most``."""
    return math.ceil(size / math.ceil(size / most))


NO_WORKERS_S = 60.0
"""Longest time that a run waits for workers of a cluster; unlike a sweep, it cannot be resumed."""


class ClusterExecutor(Executor):
    """The executor of a Dask cluster, which knows whether the cluster has workers."""

    def __init__(self, cluster: Cluster) -> None:
        self._inner, self.wait = cluster.client.get_executor(), cluster.wait

    def submit(self, work: Callable[..., Any], /, *given: Any, **options: Any) -> Future[Any]:
        """Start work on the cluster."""
        future: Future[Any] = self._inner.submit(work, *given, **options)
        return future


@contextmanager
def _cluster(scheduler: str) -> Iterator[tuple[Executor, int]]:
    from hcss_twin.engine.cluster import Cluster  # only for runs on one

    with Cluster.connected(scheduler, HcssError, NO_WORKERS_S) as cluster:
        count = len(cluster.workers())
        if count == 0:
            raise HcssError(f"--scheduler {scheduler}: the cluster has no workers")
        yield ClusterExecutor(cluster), count


AHEAD = 2
"""Number of running and queued parts per worker."""


_Item = TypeVar("_Item")
_Result = TypeVar("_Result")


@dataclass(frozen=True)
class Workers:
    """Processes of this machine or of a cluster, whose results are taken in order.

    Attributes
    ----------
    executor : Executor or None
        None: the caller does the work.
    count : int
        Number of workers.
    """

    executor: Executor | None = None
    count: int = 1

    @staticmethod
    def start(work: Callable[..., None], *given: Any) -> BaseProcess:
        """Start one process that calls ``work(*given)``, leaves Ctrl-C to this one and never outlives it.

        Raises
        ------
        OSError
            If the system starts no more processes.
        """
        return start_worker(work, *given)

    @staticmethod
    @contextmanager
    def of(workers: int, scheduler: str | None = None) -> Iterator[Workers]:
        """Yield the workers of a run.

        Parameters
        ----------
        workers : int
            Local processes; 1: only the calling one.
        scheduler : str, optional
            Address of the scheduler of a Dask cluster, used instead.

        Raises
        ------
        HcssError
            If the cluster cannot be reached or ``distributed`` is not installed.
        """
        if scheduler is not None:
            with _cluster(scheduler) as (executor, count):
                yield Workers(executor, count)
        elif workers == 1:
            yield Workers()
        else:
            with worker_pool(workers) as pool:
                yield Workers(pool, workers)

    def in_order(self, work: Callable[[_Item], _Result], items: Iterator[_Item]) -> Iterator[tuple[_Item, _Result]]:
        """Yield items with their results in the order of the items, submitting a few ahead.

        Parameters
        ----------
        work : callable
            A function of a module, which other processes can import.
        items : iterator
            Its arguments.

        Raises
        ------
        ProviderError
            If a worker ends before completing its item.
        """
        if self.executor is None:
            yield from ((item, work(item)) for item in items)
            return
        waiting: deque[tuple[_Item, Future[_Result]]] = deque()
        try:
            for item in items:
                waiting.append((item, self.executor.submit(work, item)))
                while len(waiting) >= AHEAD * self.count:
                    yield waiting[0][0], _result(self.executor, waiting[0][1])
                    waiting.popleft()
            while waiting:
                yield waiting[0][0], _result(self.executor, waiting[0][1])
                waiting.popleft()
        except BrokenExecutor as error:
            raise ProviderError(
                f"a worker process ended before its part of the scene was computed ({error}): it may have been "
                f"killed, for example because {out_of_memory()}"
            ) from error
        except CancelledError as error:  # only a cluster cancels what was not given up
            raise HcssError("the connection to the Dask scheduler is lost; run the command again") from error
        finally:
            for _, future in waiting:
                future.cancel()


def _result(executor: Executor, future: Future[_Result]) -> _Result:
    if isinstance(executor, ClusterExecutor):
        executor.wait(future.done)
    return future.result()


@dataclass(frozen=True)
class Task:
    """One part of one frame as plain values, for any process with this package.

    Attributes
    ----------
    scenario : str
        Output of :meth:`Scenario.to_json`.
    base : str
        Base folder of relative paths.
    rows, columns : (int, int)
        First and end index, in pixels of the image.
    before : int
        Number of pixels of the frame in earlier tiles.
    """

    scenario: str
    base: str
    frame: int
    rows: tuple[int, int]
    columns: tuple[int, int]
    before: int

    @property
    def extent(self) -> Window:
        """Rows and columns of the image."""
        return slice(*self.rows), slice(*self.columns)


@dataclass(frozen=True)
class Part:
    """A part of a frame.

    Attributes
    ----------
    frame : int
        Number of the frame.
    place : (slice, slice) or None
        Rows and columns of the cube; None for all of them.
    arrays : mapping of str to ndarray
        The requested variables, without the time dimension.
    """

    frame: int
    place: Window | None
    arrays: Frame


MadePart = tuple[Frame, "DrawnPixels | None"]
"""Variables of a part, and its certificate sample."""


@naming_memory()
def make_part(task: Task, summaries: Sequence[Any] | None = None) -> MadePart:
    """Compute one part of a frame; the result is bit-identical in any process.

    Plan and tables are made, or read from the disk cache, for the first part of a scenario, and reused for later
    parts in the same process.

    Parameters
    ----------
    summaries : sequence, optional
        Those of :func:`hcss_twin.engine.clouds.summaries_of` for the frame; computed if omitted.
    """
    plan, maker, turn = _maker(task.scenario, task.base)
    sample: PixelSample | None = None
    if plan.needs_radiance and plan.scenario.output.certificate:
        from hcss_twin.engine.certificate.certificate_pixels import PixelSample  # a mask has none

        sample = PixelSample(plan)
    with turn:
        return _made(plan, maker, sample, task, summaries)


@lru_cache(maxsize=1)
def _maker(scenario: str, base: str) -> tuple[Plan, PartMaker, Lock]:
    """Return the part maker of a scenario, and a lock for workers with several threads."""
    plan = make_plan(Scenario.from_dict(json.loads(scenario), base=Path(base)))
    tables: RadianceTables | None = None
    if plan.needs_radiance:
        from hcss_twin.engine.compile import tables_of  # a mask alone needs no radiance

        tables = tables_of(plan)
    return plan, PartMaker(plan, tables), Lock()


def _made(
    plan: Plan, maker: PartMaker, sample: PixelSample | None, task: Task, summaries: Sequence[Any] | None = None
) -> MadePart:
    rows, columns = relative(task.extent, plan.extent)
    draws = None if sample is None else sample.of_part(task.frame, task.before, (rows.start, columns.start))
    arrays, radiance = maker.part(task.frame, task.extent, draws, summaries)
    return arrays, None if draws is None else draws.drawn(radiance)


def stream_parts(
    plan: Plan,
    tables: RadianceTables | None,
    sample: PixelSample | None = None,
    executor: Executor | None = None,
    workers: int = 1,
    frames: Sequence[int] | None = None,
) -> Iterator[Part]:
    """Yield all parts of all frames in order; memory use depends neither on their number nor on the frame size.

    Parameters
    ----------
    tables : RadianceTables or None
        None if no requested variable requires radiance.
    sample : PixelSample, optional
        Samples pixels of the frames during computation.
    executor : Executor, optional
        Computes the parts in its ``workers`` workers; by default they are computed here.
    frames : sequence of int, optional
        Frame numbers from 0, by default all.

    Raises
    ------
    ProviderError
        If a provider violates its contract, or a worker ends before completing its part.
    """
    windows, tasks = tiles(plan), _tasks(plan, range(plan.frame_times_s.size) if frames is None else frames)
    results: Iterator[tuple[Task, MadePart]]
    if executor is None:
        maker = PartMaker(plan, tables)
        results = ((task, _made(plan, maker, sample, task)) for task in tasks)
    else:
        results = _in_order(plan, executor, workers, tasks)
    of_frame: list[DrawnPixels] = []
    for task, (arrays, drawn) in results:
        if sample is not None and drawn is not None:
            of_frame.append(drawn)
            if len(of_frame) == len(windows):
                sample.add_frame(task.frame, of_frame)
                of_frame = []
        yield Part(task.frame, None if len(windows) == 1 else relative(task.extent, plan.extent), arrays)


def parts_of(plan: Plan) -> int:
    """Total number of parts."""
    return plan.frame_times_s.size * len(tiles(plan))


def _tasks(plan: Plan, frames: Sequence[int]) -> Iterator[Task]:
    scenario, base, windows = plan.scenario.to_json(), str(plan.scenario.base), tiles(plan)
    sizes = [length(rows) * length(columns) for rows, columns in windows]
    for frame in frames:
        for (rows, columns), before in zip(windows, itertools.accumulate(sizes, initial=0), strict=False):
            yield Task(scenario, base, frame, (rows.start, rows.stop), (columns.start, columns.stop), before)


def _in_order(plan: Plan, executor: Executor, workers: int, tasks: Iterator[Task]) -> Iterator[tuple[Task, MadePart]]:
    """Yield the workers' results in the order of the tasks."""

    def with_summaries() -> Iterator[tuple[Task, list[Any]]]:
        frame, summaries = -1, list[Any]()
        for task in tasks:
            if task.frame != frame:
                frame, summaries = task.frame, summaries_of(plan, float(plan.frame_times_s[task.frame]))
            yield task, summaries

    for (task, _), made in Workers(executor, workers).in_order(_make_given, with_summaries()):
        yield task, made


def _make_given(given: tuple[Task, Sequence[Any]]) -> MadePart:
    return make_part(*given)
