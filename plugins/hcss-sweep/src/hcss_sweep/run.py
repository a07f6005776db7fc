"""Run a sweep: from its file to a folder of cubes."""

from __future__ import annotations

import os
from collections.abc import Callable, Generator, Iterable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hcss_sweep.design import Design
from hcss_sweep.errors import SweepError
from hcss_sweep.folder import INDEX, PointRecord, SweepFolder, cube_name
from hcss_sweep.points import (
    DATE,
    PointOutcome,
    PointTask,
    Schedule,
    SweepPoint,
    compute_here,
    digest_of,
    plugin_code,
    points_of,
    points_with_curves,
    require_one_layout,
    shared_tables,
)
from hcss_twin import Scenario, make_plan
from hcss_twin.core.arguments import checked
from hcss_twin.core.result_cache import ResultCache
from hcss_twin.engine.cluster import Cluster
from hcss_twin.providers import ScenarioError

Progress = Callable[[Iterable[Any], int], Iterable[Any]]


@dataclass(frozen=True)
class SweepResult:
    """Result of a sweep in its folder.

    ``points`` are all points by number; ``computed`` are the numbers of the points computed in this run; ``dataset`` is
    the file with all points, if there is one.
    """

    folder: Path
    points: tuple[PointRecord, ...]
    computed: tuple[int, ...]
    dataset: Path | None

    @property
    def failed(self) -> tuple[PointRecord, ...]:
        """Points without a cube, or with a cube that misses the requested accuracy."""
        return tuple(record for record in self.points if record.state == "failed")

    def cube(self, point: int) -> Path:
        """Return the path of a point's cube.

        Raises SweepError if the point has no cube.
        """
        record = self.points[point]
        if record.file is None:
            raise SweepError(f"point {point} has no cube: {record.error}")
        return self.folder / record.file

    def as_dict(self) -> dict[str, Any]:
        """Return JSON-compatible values for ``--json``."""
        return {
            "folder": str(self.folder),
            "index": str(self.folder / INDEX),
            "points": len(self.points),
            "done": sum(record.state == "done" for record in self.points),
            "computed": list(self.computed),
            "failed": [record.as_dict() for record in self.failed],
            "dataset": None if self.dataset is None else str(self.dataset),
        }


@checked
def sweep(
    source: str | Path | Mapping[str, Any] | Scenario,
    folder: str | Path,
    *,
    over: Mapping[str, Any] | None = None,
    overrides: Mapping[str, Any] | None = None,
    workers: int = 1,
    scheduler: str | None = None,
    wait_workers_s: float | None = None,
    dataset: str | Path | None = None,
    force: bool = False,
    progress: Progress | None = None,
) -> SweepResult:
    """Compute all cubes of a sweep that are missing from a folder.

    Parameters
    ----------
    source : str, Path, mapping or Scenario
        Name of a shipped sweep or scenario, a file, a mapping of its keys, or a scenario.
    folder : path
        Folder for the cubes and their index: new, empty, or that of an earlier run of this sweep.
    over : mapping, optional
        Swept keys and their values, as in ``[sweep]``.
    overrides : mapping, optional
        Dotted key to value, the same in all points.
    workers : int
        Most processes on this machine; 1 computes in the current process. With more, as many start as save time, and
        a script needs ``if __name__ == "__main__":``.
    scheduler : str, optional
        Address of a Dask scheduler whose workers are used instead; they must share the folder.
    wait_workers_s : float, optional
        Longest time that the scheduler may be without workers, s; by default the sweep waits for them, and says so.
    dataset : path, optional
        NetCDF file to write with all points, with the swept keys as leading dimensions.
    force : bool
        Remove the results of an earlier sweep in the folder.
    progress : callable, optional
        Wraps the iterable of finished points; called with it and the number of points.

    Returns
    -------
    SweepResult
        Lists failed points with their errors; they raise no exception.

    Raises
    ------
    ScenarioError
        With the problems of all points, before the computation.
    SweepError
        If the folder or the workers cannot be used, or the dataset cannot be written.
    """
    design = Design.load(source, overrides, over)
    points = points_of(design)
    path = Path(folder)
    wanted = Path(dataset) if dataset is not None else path / design.dataset if design.dataset else None
    if wanted is not None:
        require_one_layout(design, points)
    if workers < 1:
        raise SweepError(f"workers = {workers}; allowed: 1 or more")
    if scheduler is not None and workers != 1:
        raise SweepError(f"{workers} workers with the scheduler {scheduler}, which has its own; allowed: one of them")
    if wait_workers_s is not None and (scheduler is None or not wait_workers_s >= 0.0):
        raise SweepError(f"wait_workers_s = {wait_workers_s:g}; allowed: 0 or more, with a scheduler")
    digest = digest_of(points)
    about = {
        "title": design.title,
        "keys": [axis.key for axis in design.axes],
        "combine": design.combine,
        "shape": list(design.shape),
    }
    sweep_folder = SweepFolder(path, digest, about, points)
    if wanted is not None:
        from hcss_sweep.dataset import require_replaceable

        require_replaceable(wanted, path, digest, force)
    computed: list[int] = []
    with sweep_folder.open(ResultCache().versions() | plugin_code(point.scenario for point in points), force):
        missing = [point for point in points if not sweep_folder.records[point.number].is_settled]
        schedule = _schedule(sweep_folder, points, missing)
        # Closed before the folder, so that no worker writes to it any more.
        with closing(_outcomes(schedule, workers, scheduler, path, len(missing), wait_workers_s)) as outcomes:
            for outcome in outcomes if progress is None else progress(outcomes, len(missing)):
                sweep_folder.note(outcome)
                computed.append(outcome.point)
        if wanted is not None:
            from hcss_sweep.dataset import write_dataset

            write_dataset(wanted, design, digest, path, sweep_folder.records)
    return SweepResult(path, tuple(sweep_folder.records), tuple(sorted(computed)), wanted)


MOST_PLANNED = 20
"""Points of which :func:`checked_points` makes plans, at most: one costs half a second."""


def checked_points(
    source: str | Path, overrides: Mapping[str, Any] | None = None, progress: Progress | None = None
) -> tuple[str, dict[str, int]]:
    """Check all points of a sweep without computing them, for ``hcss validate``.

    One point is planned for each set of radiance tables, evenly chosen where there are more than 20. Raises
    ScenarioError with the problems of all points, or those of the first plan that has any, with its number.
    """
    design = Design.load(source, overrides)
    points = points_of(design)
    if design.dataset:
        require_one_layout(design, points)
    firsts = [*{shared_tables(point.scenario): point for point in reversed(points)}.values()][::-1]
    planned = firsts[:: -(-len(firsts) // MOST_PLANNED)]
    cache = ResultCache(several=True)
    for point in planned if progress is None else progress(planned, len(planned)):
        try:
            make_plan(point.scenario, shelf=cache)
        except ScenarioError as error:
            raise ScenarioError(error.problems, f"{design.origin}, point {point.number}") from error
    text = f"{len(points)} points, plans of {len(planned)} of them"
    return text, {"points": len(points), "planned": len(planned)}


def _schedule(folder: SweepFolder, points: Sequence[SweepPoint], missing: list[SweepPoint]) -> Schedule[PointTask]:
    groups = {point.number: shared_tables(point.scenario) for point in points}
    compiled = {groups[record.point] for record in folder.records if record.state == "done"}
    date, count = os.environ.get(DATE), len(folder.records)
    paths = [str((folder.path / cube_name(point.number, count)).resolve()) for point in missing]
    curves = points_with_curves(points, groups)
    tasks = [
        PointTask(point.number, point.scenario, path, date, point.number in curves)
        for point, path in zip(missing, paths, strict=True)
    ]
    return Schedule(tasks, lambda task: groups[task.point], compiled)


def _outcomes(
    schedule: Schedule[PointTask],
    workers: int,
    scheduler: str | None,
    folder: Path,
    count: int,
    wait_workers_s: float | None,
) -> Generator[PointOutcome]:
    """Yield the outcomes of points in order of completion, local or from the cluster."""
    if count == 0:
        return
    if scheduler is None:
        from hcss_sweep.local_workers import compute_in_processes

        several = min(workers, count) > 1
        yield from compute_in_processes(schedule, min(workers, count)) if several else compute_here(schedule)
        return
    with Cluster.connected(scheduler, SweepError, wait_workers_s) as cluster:
        from hcss_sweep.cluster import SweepCluster  # imports Dask

        yield from SweepCluster(cluster, folder.resolve()).compute(schedule)
