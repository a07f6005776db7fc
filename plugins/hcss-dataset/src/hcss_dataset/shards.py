"""Shards of a data set: tar files of WebDataset, one for each split, and an index that says that they are whole.

A shard holds some consecutive draws. Its bytes depend on the distribution and its number alone, so any process or
machine can make it, and what is missing can be made later. The index gets its name last.
"""

from __future__ import annotations

import hashlib
import io
import json
import tarfile
import time
from collections.abc import Iterator, Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hcss_dataset.distribution import SPLITS, Distribution
from hcss_dataset.errors import DatasetError
from hcss_dataset.images import SUFFIXES, encoded
from hcss_dataset.rendering import Frame, Studio
from hcss_twin.core.files import Writing

SHARDS = "shards"
IMAGE, CLEAN = "image", "clean"


@dataclass(frozen=True)
class Layout:
    """How the frames of a data set are shared out.

    Attributes
    ----------
    folder : Path
        Of the data set.
    draws, per_draw : int
        Number of sequences, and of frames in each.
    """

    folder: Path
    distribution: Distribution
    draws: int
    per_draw: int

    @property
    def per_shard(self) -> int:
        """Draws in a shard."""
        return max(1, self.distribution.shard // self.per_draw)

    @property
    def shards(self) -> range:
        """Numbers of the shards."""
        return range(-(-self.draws // self.per_shard))

    def draws_of(self, shard: int) -> range:
        """Return the draws of a shard."""
        first = shard * self.per_shard
        return range(first, min(first + self.per_shard, self.draws))

    def index(self, shard: int) -> Path:
        """Return the path of the index of a shard."""
        return self.folder / SHARDS / f"{shard:06d}.jsonl"

    def tar(self, shard: int, split: str) -> Path:
        """Return the path of the frames of a shard in a split."""
        return self.folder / SHARDS / f"{split}-{shard:06d}.tar"

    def missing(self) -> list[int]:
        """Return the shards that are not whole."""
        return [shard for shard in self.shards if not self.is_whole(shard)]

    def is_whole(self, shard: int) -> bool:
        """Whether a shard has its index and files of the sizes that the index states."""
        path = self.index(shard)
        if not path.is_file():
            return False
        head = json.loads(path.read_text(encoding="utf-8").partition("\n")[0])
        files = ((self.folder / SHARDS / name, size) for name, size in head["bytes"].items())
        return all(file.is_file() and file.stat().st_size == size for file, size in files)

    def records(self, shards: Iterator[int] | range | None = None) -> Iterator[dict[str, Any]]:
        """Yield the record of each frame, in order."""
        for shard in self.shards if shards is None else shards:
            with self.index(shard).open(encoding="utf-8") as lines:
                next(lines)
                yield from map(json.loads, lines)

    def heads(self) -> list[dict[str, Any]]:
        """Return what the index of each shard says of the whole shard."""
        found = []
        for shard in self.shards:
            with self.index(shard).open(encoding="utf-8") as lines:
                found.append(json.loads(next(lines)))
        return found


@dataclass(frozen=True)
class ShardTask:
    """What a worker needs to make a shard; it is sent to other processes and machines."""

    source: str | Mapping[str, Any]
    layout: tuple[str, int, int]
    shard: int


def make_shard(task: ShardTask) -> dict[str, float]:
    """Make a shard, and return its number of frames and processor time; the studio of a process is kept."""
    folder, draws, per_draw = task.layout
    studio = _studio(task.source)
    return write_shard(studio, Layout(Path(folder), studio.distribution, draws, per_draw), task.shard)


_studios: dict[str, Studio] = {}


def _studio(source: str | Mapping[str, Any]) -> Studio:
    key = json.dumps(source, sort_keys=True, default=str)
    if key not in _studios:
        _studios.clear()
        _studios[key] = Studio(Distribution.load(source))
    return _studios[key]


def write_shard(studio: Studio, layout: Layout, shard: int) -> dict[str, float]:
    """Write the files of a shard; each appears when it is whole, and the index last."""
    began = time.process_time()
    (layout.folder / SHARDS).mkdir(parents=True, exist_ok=True)
    layout.index(shard).unlink(missing_ok=True)
    records: list[dict[str, Any]] = []
    refused = 0
    with ExitStack() as stack:
        writers = dict[str, tarfile.TarFile]()
        for draw in layout.draws_of(shard):
            sequence = studio.sequence(draw)
            refused += len(sequence.refused)
            if sequence.split not in writers:
                draft = stack.enter_context(Writing(layout.tar(shard, sequence.split), DatasetError))
                opened = tarfile.TarFile(draft, "w", format=tarfile.USTAR_FORMAT)
                writers[sequence.split] = stack.enter_context(opened)
            for frame in sequence.frames():
                number = draw * layout.per_draw + frame.labels["frame"]
                name = layout.tar(shard, sequence.split).name
                records.append(_add(writers[sequence.split], name, number, frame, layout.distribution.form))
    for split in set(SPLITS) - set(writers):
        layout.tar(shard, split).unlink(missing_ok=True)
    files = sorted(layout.tar(shard, split) for split in writers)
    head = {
        "shard": shard,
        "frames": len(records),
        "refused": refused,
        "bytes": {path.name: path.stat().st_size for path in files},
        "sha256": {path.name: _sha256(path) for path in files},
    }
    with Writing(layout.index(shard), DatasetError) as draft:
        draft.write_text("".join(json.dumps(each) + "\n" for each in (head, *records)), encoding="utf-8")
    return {"frames": len(records), "seconds": time.process_time() - began}


def key_of(number: int) -> str:
    """Return the name of a frame, which no reader takes for a number."""
    return f"f{number:08d}"


def member(kind: str, band: str, bands: int, suffix: str) -> str:
    """Return the last part of the name of an image: with the band, if there are several."""
    return f"{kind}{suffix}" if bands == 1 else f"{kind}.{band}{suffix}"


def _add(tar: tarfile.TarFile, name: str, number: int, frame: Frame, form: str) -> dict[str, Any]:
    """Add a frame to a tar file, and return its record, which says where its images are."""
    key, bands = key_of(number), frame.labels["bands"]
    labels = {"key": key, "number": number, **frame.labels}
    places = dict[str, list[int]]()
    for kind, images in ((IMAGE, frame.image), (CLEAN, frame.clean)):
        for band, image in zip(bands, images, strict=True):
            file = member(kind, band, len(bands), SUFFIXES[form])
            places[file] = _put(tar, f"{key}.{file}", encoded(image, form))
    _put(tar, f"{key}.json", json.dumps(labels).encode())
    return {**labels, "file": name, "images": places}


def _put(tar: tarfile.TarFile, name: str, content: bytes) -> list[int]:
    """Add a file without date and owner, and return where its content begins, and its size."""
    about = tarfile.TarInfo(name)
    about.size = len(content)
    begin = tar.offset + tarfile.BLOCKSIZE
    tar.addfile(about, io.BytesIO(content))
    return [begin, len(content)]


def _sha256(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
