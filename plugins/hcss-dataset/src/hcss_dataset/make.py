"""Making a data set: missing shards on workers, then the files over all of them."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hcss_dataset.distribution import Distribution, draws_of
from hcss_dataset.errors import DatasetError
from hcss_dataset.images import versions_of
from hcss_dataset.rendering import Studio
from hcss_dataset.shards import SHARDS, Layout, ShardTask, make_shard
from hcss_twin.core.files import Writing
from hcss_twin.engine.parts import Workers
from hcss_twin.providers import Problem, ScenarioError

ABOUT = "dataset.json"
Progress = Callable[[Iterable[Any], int], Iterator[Any]]


@dataclass(frozen=True)
class Made:
    """What a run made.

    Attributes
    ----------
    frames : int
        Made in this run.
    seconds, processor_s : float
        Wall time of the run, and processor time of all shards together.
    missing : int
        Shards that the data set still lacks.
    refused : int
        Draws that were refused in all whole shards, and drawn again.
    """

    folder: Path
    frames: int
    seconds: float
    processor_s: float
    missing: int
    refused: int

    def as_dict(self) -> dict[str, Any]:
        """Return plain values for JSON."""
        return {**vars(self), "folder": str(self.folder)}


def make_dataset(
    source: str | Path | Mapping[str, Any],
    folder: str | Path,
    frames: int,
    workers: int = 1,
    shard: int | None = None,
    scheduler: str | None = None,
    progress: Progress | None = None,
) -> Made:
    """Make the missing shards of a data set, and the files over all shards when none is missing.

    Parameters
    ----------
    source : path or mapping
        File of the data set, or its keys.
    frames : int
        Of the whole data set.
    workers : int
        Processes on this machine.
    shard : int, optional
        Make this shard only.
    scheduler : str, optional
        Address of a Dask scheduler whose workers, which see the folder, make the shards.
    progress : callable, optional
        Wraps the iterable of shards, given their number.

    Raises
    ------
    ScenarioError
        If the file of the data set is wrong.
    DatasetError
        If the folder holds another data set, or a file cannot be written.
    """
    distribution, folder = Distribution.load(source), Path(folder).absolute()
    studio = Studio(distribution)
    per_draw = studio.frames_per_draw()
    try:
        layout = Layout(folder, distribution, draws_of(frames, per_draw), per_draw)
    except ValueError as error:
        raise ScenarioError([Problem("--frames", str(error))], distribution.origin) from error
    if shard is not None and shard not in layout.shards:
        message = f"{shard}; allowed: 0 to {layout.shards[-1]} for {frames} frames"
        raise ScenarioError([Problem("--shard", message)], distribution.origin)
    _claim(layout, studio)
    wanted = [number for number in layout.missing() if shard in (None, number)]
    Writing.remove_orphans(folder / SHARDS)
    plain = source if isinstance(source, Mapping) else str(Path(source).absolute())
    tasks = [ShardTask(plain, (str(folder), layout.draws, per_draw), number) for number in wanted]
    began, made, seconds = time.perf_counter(), 0.0, 0.0
    with Workers.of(min(workers, max(len(tasks), 1)), scheduler) as crew:
        results: Iterable[Any] = crew.in_order(make_shard, iter(tasks))
        for _, result in results if progress is None else progress(results, len(tasks)):
            made, seconds = made + result["frames"], seconds + result["seconds"]
    missing, refused = layout.missing(), 0
    if not missing:
        from hcss_dataset.layout import finish

        refused = finish(layout)
    return Made(folder, int(made), time.perf_counter() - began, seconds, len(missing), refused)


def _claim(layout: Layout, studio: Studio) -> None:
    """Write what the data set is, or check that the folder holds the same one."""
    distribution, path = layout.distribution, layout.folder / ABOUT
    about = {
        "format": 1,
        "title": distribution.title,
        "licence": distribution.licence,
        "digest": distribution.digest,
        "frames": layout.draws * layout.per_draw,
        "frames_per_sequence": layout.per_draw,
        "sequences": layout.draws,
        "distribution": dict(distribution.raw),
        "versions": {**studio.shelf.versions(), **versions_of(distribution.form)},
    }
    if path.is_file():
        there = json.loads(path.read_text(encoding="utf-8"))
        for name, what in (("digest", "distribution"), ("frames", "number of frames"), ("versions", "versions")):
            if there.get(name) != about[name]:
                raise DatasetError(
                    f"{layout.folder} holds a data set of another {what}: its shards would not go with new ones; "
                    "allowed: another folder with -o"
                )
        return
    layout.folder.mkdir(parents=True, exist_ok=True)
    with Writing(path, DatasetError) as draft:
        draft.write_text(json.dumps(about, indent=1) + "\n", encoding="utf-8")
