"""Reading a data set: with numpy alone if its images are PNG."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_dataset.errors import DatasetError
from hcss_dataset.images import SUFFIXES, decoded
from hcss_dataset.shards import CLEAN, IMAGE, SHARDS, member


@dataclass(frozen=True)
class LabelledFrame:
    """A frame of a data set; images are read when they are asked for.

    Attributes
    ----------
    labels : dict
        What is known of the frame and of its targets.
    """

    folder: Path
    labels: dict[str, Any]

    @property
    def image(self) -> NDArray[np.uint16]:
        """Numbers of the sensor (B, y, x); the first row is the southern one."""
        return self._read(IMAGE)

    @property
    def clean(self) -> NDArray[np.uint16]:
        """The same frame without targets and noise (B, y, x)."""
        return self._read(CLEAN)

    def radiance(self, numbers: NDArray[np.uint16]) -> NDArray[np.float64]:
        """Return the radiance (B, y, x) of numbers of this frame, W m-2 sr-1."""
        step, offset = (
            np.array(self.labels[name])[:, None, None] for name in ("radiance_per_number", "radiance_at_number_0")
        )
        result: NDArray[np.float64] = offset + step * numbers
        return result

    def mask(self, target: int) -> NDArray[np.bool_]:
        """Return the mask (y, x) of a target, by its place in ``labels["targets"]``."""
        rows, columns = self.labels["rows"], self.labels["columns"]
        coded = self.labels["targets"][target]["mask"]
        runs = [rows * columns] if coded is None else coded["counts"]
        values = np.arange(len(runs)) % 2 == 1
        return np.repeat(values, runs).reshape(columns, rows).T

    def _read(self, kind: str) -> NDArray[np.uint16]:
        bands = self.labels["bands"]
        path = self.folder / SHARDS / self.labels["file"]
        images, places = [], self.labels["images"]
        try:
            with path.open("rb") as file:
                for band in bands:
                    names = (member(kind, band, len(bands), suffix) for suffix in SUFFIXES.values())
                    name = next(name for name in names if name in places)
                    begin, size = places[name]
                    file.seek(begin)
                    images.append(decoded(file.read(size), name))
        except (OSError, ValueError) as error:
            raise DatasetError(f"{path}: frame {self.labels['key']}: {error}") from error
        return np.stack(images)


class Frames(Sequence[LabelledFrame]):
    """The frames of a data set in the order of draws and time.

    Parameters
    ----------
    folder : path
        Of the data set, whole or unfinished.
    split : str, optional
        Only frames of ``train``, ``val`` or ``test``.

    Raises
    ------
    DatasetError
        If there is no data set.
    """

    def __init__(self, folder: str | Path, split: str | None = None) -> None:
        self.folder = Path(folder)
        indices = sorted((self.folder / SHARDS).glob("[0-9]*.jsonl"))
        if not indices:
            raise DatasetError(f"{self.folder}: no data set; allowed: a folder that `hcss dataset` has written")
        self._records = [record for path in indices for record in _records(path)]
        if split is not None:
            self._records = [record for record in self._records if record["split"] == split]

    def __len__(self) -> int:
        return len(self._records)

    def __getitem__(self, number: Any) -> Any:
        if isinstance(number, slice):
            return [LabelledFrame(self.folder, record) for record in self._records[number]]
        return LabelledFrame(self.folder, self._records[number])

    def __iter__(self) -> Iterator[LabelledFrame]:
        return (LabelledFrame(self.folder, record) for record in self._records)


def _records(path: Path) -> Iterator[dict[str, Any]]:
    try:
        with path.open(encoding="utf-8") as lines:
            next(lines)
            yield from map(json.loads, lines)
    except (OSError, ValueError, StopIteration) as error:
        raise DatasetError(f"{path} is no index of a shard: {error}") from error
