"""Parts of frames: whole frames where they are small, tiles where they are large, computed here or by an executor.

Which tiles a frame has follows from the plan alone, and not from who computes them: the certificate draws its pixels
tile by tile, and chunks of the cube are tiles.
"""

from __future__ import annotations

import itertools
import json
import math
import multiprocessing
import signal
from collections import deque
from collections.abc import Iterator, Sequence
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from threading import Lock
from typing import Any

from hcss_twin.core.errors import HcssError, ProviderError
from hcss_twin.engine.certificate.certificate_pixels import FrameSample, PixelSample
from hcss_twin.engine.certificate.part_sample import DrawnPixels
from hcss_twin.engine.compile import tables_of
from hcss_twin.engine.stream import Frame, PartMaker, summaries_of
from hcss_twin.engine.tables.radiance_tables import RadianceTables
from hcss_twin.plan.make_plan import make_plan
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.windows import Window, cut, length, relative
from hcss_twin.scenario.scenario import Scenario

LARGEST_FRAME_BYTES = 2**28
"""Frames with more bytes in the cube are made by tiles."""

TILE_BYTES = 2**26
"""Of the variables of one tile, at most."""

TILE_PIXELS = 2**21
"""Of one tile, at most."""


def tile_shape(plan: Plan) -> tuple[int, int] | None:
    """Return the rows and columns of tiles, those at the far edges apart; None where frames are made whole.

    Tiles are nearly square, so that slant paths leave them as little as possible and readers of a window read little
    else.
    """
    rows, columns = plan.pixels
    frame_bytes = plan.uncompressed_bytes // plan.frame_times_s.size
    if frame_bytes <= LARGEST_FRAME_BYTES:
        return None
    bytes_per_pixel = math.ceil(frame_bytes / (rows * columns))
    side = max(1, math.isqrt(min(TILE_PIXELS, TILE_BYTES // bytes_per_pixel)))
    # A long and narrow image is cut along its length only.
    height = _evenly(rows, max(side, side * side // columns))
    return height, _evenly(columns, max(side, side * side // height))


def tiles(plan: Plan) -> list[Window]:
    """Return the tiles (rows, columns) of each frame, in pixels of the image, row by row."""
    shape = tile_shape(plan)
    return [plan.extent] if shape is None else list(cut(plan.extent, *shape))


def _evenly(size: int, most: int) -> int:
    """Largest part of a length that is cut into as few nearly equal ones as possible, each of at most ``most``."""
    return math.ceil(size / math.ceil(size / most))


@contextmanager
def executor_of(workers: int, scheduler: str | None = None) -> Iterator[tuple[Executor | None, int]]:
    """Give an executor and its number of workers for the time of a run; none where the caller does the work.

    Parameters
    ----------
    workers : int
        Processes of this machine; 1 is none but the caller's.
    scheduler : str, optional
        Address of the scheduler of a Dask cluster, used instead.

    Raises
    ------
    HcssError
        If the cluster cannot be reached or ``distributed`` is not installed.
    """
    if scheduler is not None:
        with _cluster(scheduler) as cluster:
            yield cluster
    elif workers == 1:
        yield None, 1
    else:
        # A fork would copy threads' locks; a new process has none.
        context = multiprocessing.get_context("spawn")
        pool = ProcessPoolExecutor(workers, mp_context=context, initializer=_leave_signals_to_the_parent)
        try:
            yield pool, workers
        finally:
            pool.shutdown(cancel_futures=True)


@contextmanager
def _cluster(scheduler: str) -> Iterator[tuple[Executor, int]]:
    try:
        from distributed import Client
    except ImportError as error:
        raise HcssError(f"--scheduler {scheduler}: needs the package 'distributed', which is not installed") from error
    try:
        client = Client(scheduler)
    except (OSError, ValueError) as error:
        raise HcssError(f"--scheduler {scheduler}: {error}") from error
    with client:
        count = len(client.scheduler_info(-1)["workers"])
        if count == 0:
            raise HcssError(f"--scheduler {scheduler}: the cluster has no workers")
        yield client.get_executor(), count


def _leave_signals_to_the_parent() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)


AHEAD = 2
"""Parts that each worker has in hand or waiting."""


@dataclass(frozen=True)
class Task:
    """One part of one frame, for any process that has this package: plain values only.

    Attributes
    ----------
    scenario : str
        As :meth:`Scenario.to_json` writes it.
    base : str
        Folder of its relative paths.
    frame : int
    rows, columns : (int, int)
        First and end, in pixels of the image.
    before : int
        Pixels of the frame in tiles before this one.
    """

    scenario: str
    base: str
    frame: int
    rows: tuple[int, int]
    columns: tuple[int, int]
    before: int


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


def make_part(task: Task, summaries: Sequence[Any] | None = None) -> tuple[Frame, DrawnPixels | None]:
    """Make one part of a frame, whoever asks, with the same bits.

    Plan and tables are made, or found among those kept on the disk, with the first part of a scenario, and serve the
    next ones in the same process.

    Parameters
    ----------
    task : Task
    summaries : sequence, optional
        Those of :func:`hcss_twin.engine.stream.summaries_of` for the frame; made anew where they are not given.

    Returns
    -------
    arrays : dict of str to ndarray
        The requested variables of the part.
    drawn : DrawnPixels or None
        What the certificate may check of it.
    """
    plan, maker, turn = _maker(task.scenario, task.base)
    sample = PixelSample(plan) if plan.needs_radiance and plan.scenario.output.certificate else None
    with turn:
        return _made(plan, maker, sample, task, summaries)


@lru_cache(maxsize=1)
def _maker(scenario: str, base: str) -> tuple[Plan, PartMaker, Lock]:
    """Return what makes parts of a scenario, and a lock for schedulers whose workers have several threads."""
    plan = make_plan(Scenario.from_dict(json.loads(scenario), base=Path(base)))
    return plan, PartMaker(plan, tables_of(plan) if plan.needs_radiance else None), Lock()


def _made(
    plan: Plan, maker: PartMaker, sample: PixelSample | None, task: Task, summaries: Sequence[Any] | None
) -> tuple[Frame, DrawnPixels | None]:
    extent = slice(*task.rows), slice(*task.columns)
    place = relative(extent, plan.extent)
    draws = None if sample is None else sample.of_part(task.frame, task.before, _corner(place))
    arrays, radiance = maker.part(task.frame, extent, draws, summaries)
    return arrays, None if draws is None else draws.drawn(radiance)


def stream_parts(
    plan: Plan,
    tables: RadianceTables | None,
    sample: PixelSample | None = None,
    executor: Executor | None = None,
    workers: int = 1,
    frames: Sequence[int] | None = None,
) -> Iterator[Part]:
    """Yield all parts of all frames in order; memory depends neither on their number nor on the size of frames.

    Parameters
    ----------
    tables : RadianceTables or None
        None where no requested variable needs radiance.
    sample : PixelSample, optional
        Draws pixels of the frames as they are made.
    executor : Executor, optional
        Makes the parts in its workers, as many as ``workers``; without it they are made here.
    frames : sequence of int, optional
        Numbers of the frames wanted, from 0, by default all.

    Raises
    ------
    ProviderError
        If a provider breaks its contract, or a worker ends before its part is made.
    """
    numbers = range(plan.frame_times_s.size) if frames is None else frames
    cut = tiles(plan)
    tasks = ((task, len(cut)) for frame in numbers for task in _tasks(plan, cut, frame))
    results: Iterator[tuple[Task, int, tuple[Frame, DrawnPixels | None]]]
    if executor is None:
        maker = PartMaker(plan, tables)
        results = ((task, count, _made(plan, maker, sample, task, None)) for task, count in tasks)
    else:
        results = _in_order(plan, executor, workers, tasks)
    gathered: FrameSample | None = None
    for position, (task, count, (arrays, drawn)) in enumerate(results):
        if position % count == 0:
            gathered = None if sample is None else sample.of_frame(task.frame)
        if gathered is not None and drawn is not None:
            gathered.add(drawn)
            if position % count == count - 1:
                gathered.finish()
        place = relative((slice(*task.rows), slice(*task.columns)), plan.extent)
        yield Part(task.frame, None if count == 1 else place, arrays)


def parts_of(plan: Plan) -> int:
    """Number of parts of all frames."""
    return plan.frame_times_s.size * len(tiles(plan))


def _tasks(plan: Plan, cut: Sequence[Window], frame: int) -> Iterator[Task]:
    scenario, base = plan.scenario.to_json(), str(plan.scenario.base)
    sizes = [length(rows) * length(columns) for rows, columns in cut]
    for (rows, columns), before in zip(cut, itertools.accumulate(sizes, initial=0), strict=False):
        yield Task(scenario, base, frame, (rows.start, rows.stop), (columns.start, columns.stop), before)


def _in_order(
    plan: Plan, executor: Executor, workers: int, tasks: Iterator[tuple[Task, int]]
) -> Iterator[tuple[Task, int, tuple[Frame, DrawnPixels | None]]]:
    """Yield what workers make in the order of the tasks, with a few of them ahead."""
    waiting: deque[tuple[Task, int, Future[Any]]] = deque()
    summary: tuple[int, Sequence[Any]] = (-1, ())
    try:
        for task, count in tasks:
            if summary[0] != task.frame:
                summary = task.frame, summaries_of(plan, float(plan.frame_times_s[task.frame]))
            waiting.append((task, count, executor.submit(make_part, task, summary[1])))
            while len(waiting) >= AHEAD * workers:
                yield _result(waiting)
        while waiting:
            yield _result(waiting)
    except BrokenProcessPool as error:
        raise ProviderError(
            f"a worker process ended before its part of the scene was made ({error}): it may have been killed, for "
            "example because memory ran out; fewer workers need less"
        ) from error
    finally:
        for _, _, future in waiting:
            future.cancel()


def _result(waiting: deque[tuple[Task, int, Future[Any]]]) -> tuple[Task, int, tuple[Frame, DrawnPixels | None]]:
    task, count, future = waiting[0]
    made = future.result()
    waiting.popleft()
    return task, count, made


def _corner(place: Window) -> tuple[int, int]:
    return place[0].start, place[1].start
