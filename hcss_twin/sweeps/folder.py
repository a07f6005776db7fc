"""The folder of a sweep: its cubes, what is known of each point, and which sweep it belongs to."""

from __future__ import annotations

import contextlib
import json
import os
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, Literal

from hcss_twin.core.errors import CubeError, SweepError
from hcss_twin.core.files import atomic_write
from hcss_twin.sweeps.points import PointOutcome, SweepPoint, sha256_of

PointState = Literal["pending", "done", "failed"]


@dataclass(frozen=True)
class PointRecord:
    """One row of the index.

    Attributes
    ----------
    point : int
        Number, from 0.
    values : mapping
        The swept keys with their values, SI numbers or what JSON has for others.
    file, bytes, sha256 : str, int, str or None
        Of the cube in the sweep's folder; one whose certificate failed stays there.
    seconds : float or None
        Time to compute the point.
    error : str or None
        Why it failed.
    """

    point: int
    values: Mapping[str, Any]
    state: PointState = "pending"
    file: str | None = None
    bytes: int | None = None
    sha256: str | None = None
    seconds: float | None = None
    error: str | None = None

    @property
    def is_settled(self) -> bool:
        """Whether computing it again would give the same: it is done, or its cube misses its accuracy."""
        return self.state != "pending" and self.file is not None

    def as_dict(self) -> dict[str, Any]:
        """Return plain values."""
        return {**asdict(self), "values": dict(self.values)}

    def with_outcome(self, outcome: PointOutcome) -> PointRecord:
        """Return it with what came of computing it."""
        return replace(self, state="failed" if outcome.error else "done", **asdict(outcome))


INDEX = "index.json"
LOG = "points.jsonl"

FORMAT = 1
"""Of the index; raised when its fields change their meaning."""

_INDEX_EVERY_S = 2.0
"""The log has every point at once; the index, which is written whole, follows."""


def cube_name(point: int, count: int) -> str:
    """Return the name of a point's cube; names sort like points."""
    return f"point-{point:0{max(4, len(str(count - 1)))}d}.nc"


def is_cube_name(name: str) -> bool:
    """Whether a point may have a file of this name."""
    return name.startswith("point-")


class SweepFolder:
    """The records of all points of a sweep, on disk and in memory.

    The log gets a line when a point is computed, and is never rewritten. The index is written as a whole, under a
    hidden name first; after a kill it may be a few points behind the log, which counts. A cube that is finished and has
    the scenario of its point counts as done even where the log does not know it. ``digest`` is a hash of what the sweep
    computes, ``about`` is what the index says of the sweep as a whole.
    """

    def __init__(self, path: Path, digest: str, about: Mapping[str, Any], points: Sequence[SweepPoint]) -> None:
        self.path = path
        self._digest, self._about, self._points = digest, about, points
        self.records = [PointRecord(point.number, point.values) for point in points]
        self._written_s = 0.0

    @contextmanager
    def open(self, versions: Mapping[str, str], force: bool) -> Iterator[None]:
        """Claim the folder for this sweep while the block runs, and read what is known of it.

        The versions of what contributes to the numbers must be those of an earlier run. ``force`` removes what an
        earlier sweep, or this one, left there. Raises SweepError if the folder holds another sweep or something else,
        another process is writing to it, or it cannot be written.
        """
        try:
            self.path.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise SweepError(f"cannot write to {self.path}: {error.strerror}") from error
        with _claimed(self.path):
            known = self._read_index()
            if known is None:
                self._require_empty()
            elif force:
                self._remove(known)
                known = None
            else:
                self._require_same(known, versions)
            self._versions = dict(versions if known is None else known["versions"])
            self._remove_drafts()
            self._read_log()
            self._adopt_cubes()
            self.write_index()
            try:
                yield
            finally:
                self._remove_drafts()
                # An interrupt may come between a cube and its line in the log.
                self._adopt_cubes()
                self.write_index()

    def note(self, outcome: PointOutcome) -> PointRecord:
        """Take note of a computed point."""
        record = self.records[outcome.point].with_outcome(outcome)
        self.records[outcome.point] = record
        try:
            with (self.path / LOG).open("a", encoding="utf-8") as file:
                file.write(json.dumps(record.as_dict()) + "\n")
        except OSError as error:
            raise SweepError(f"cannot write {self.path / LOG}: {error.strerror}") from error
        if time.monotonic() - self._written_s > _INDEX_EVERY_S:
            self.write_index()
        return record

    def write_index(self) -> None:
        """Write the index; raises SweepError where the disk refuses."""
        states = [record.state for record in self.records]
        text = json.dumps(
            {
                "format": FORMAT,
                "sweep": self._digest,
                **self._about,
                "versions": self._versions,
                "states": {state: states.count(state) for state in ("done", "failed", "pending")},
                "points": [record.as_dict() for record in self.records],
            },
            indent=1,
        )
        with atomic_write(self.path / INDEX, SweepError) as draft:
            draft.write_text(text + "\n", encoding="utf-8")
        self._written_s = time.monotonic()

    def _read_index(self) -> dict[str, Any] | None:
        path = self.path / INDEX
        if not path.exists():
            return None
        try:
            known = json.loads(path.read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise SweepError(f"{path} cannot be read: {error}; give another folder") from error
        names = {"format", "sweep", "versions", "points"}
        if not isinstance(known, dict) or not names <= set(known) or known["format"] != FORMAT:
            raise SweepError(f"{path} is no index of a sweep of this version; give another folder")
        return known

    def _require_empty(self) -> None:
        left = sorted(path.name for path in self.path.iterdir())
        if left:
            listed = ", ".join(left[:3]) + (", ..." if len(left) > 3 else "")
            raise SweepError(
                f"{self.path} is not empty and holds no sweep ({listed}); allowed: a new or empty folder, or one that "
                "this sweep was begun in"
            )

    def _require_same(self, known: Mapping[str, Any], versions: Mapping[str, str]) -> None:
        remedy = "allowed: another folder, or --force, which removes its cubes and starts anew"
        if known["sweep"] != self._digest:
            keys = ", ".join(known.get("keys", ()))
            mine = ", ".join(self._about["keys"])
            raise SweepError(
                f"{self.path} holds another sweep: {len(known['points'])} points over {keys}; this one has "
                f"{len(self._points)} over {mine}, or differs in another key of the scenario; {remedy}"
            )
        changed = [
            f"{name} {known['versions'].get(name, 'none')}, now {version}"
            for name, version in versions.items()
            if known["versions"].get(name) != version
        ]
        if changed:
            raise SweepError(
                f"{self.path} was begun with other versions, which may round otherwise: {'; '.join(changed)}; {remedy}"
            )

    def _remove(self, known: Mapping[str, Any]) -> None:
        """Remove what a sweep wrote, and nothing else."""
        count = len(known["points"])
        for name in (LOG, *(cube_name(number, count) for number in range(count)), INDEX):
            with contextlib.suppress(FileNotFoundError):
                (self.path / name).unlink()
        self._remove_drafts()

    def _remove_drafts(self) -> None:
        """Remove what a killed worker left half written."""
        for path in self.path.glob(".*.partial"):
            with contextlib.suppress(FileNotFoundError):
                path.unlink()

    def _read_log(self) -> None:
        path = self.path / LOG
        if not path.exists():
            return
        text = path.read_text(encoding="utf-8")
        if text and not text.endswith("\n"):  # cut off by a kill
            with path.open("a", encoding="utf-8") as file:
                file.write("\n")
        for line in text.splitlines():
            try:
                record = PointRecord(**json.loads(line))
            except (ValueError, TypeError):
                continue  # its cube is looked at
            if 0 <= record.point < len(self.records):
                self.records[record.point] = record
        for number, record in enumerate(self.records):
            if record.file is not None and not _has_size(self.path / record.file, record.bytes):
                self.records[number] = PointRecord(number, record.values)

    def _adopt_cubes(self) -> None:
        """Count cubes as done that were finished when the sweep was killed, before the log had them."""
        for point, record in zip(self._points, self.records, strict=True):
            path = self.path / cube_name(point.number, len(self._points))
            if record.file is None and path.is_file() and _is_cube_of(path, point):
                error = _certificate_error(path)
                outcome = PointOutcome(point.number, path.name, path.stat().st_size, sha256_of(path), None, error)
                self.note(outcome)


def _has_size(path: Path, size: int | None) -> bool:
    return path.is_file() and path.stat().st_size == size


def _is_cube_of(path: Path, point: SweepPoint) -> bool:
    from hcss_twin.cube.reader import scenario_text

    try:
        return scenario_text(path) == point.scenario.to_json()
    except CubeError:
        return False


def _certificate_error(path: Path) -> str | None:
    from hcss_twin.cube.reader import open_cube

    with open_cube(path) as cube:
        text = str(cube.attrs.get("hcss_certificate", ""))
    return f"certificate {text}" if text.startswith("FAILED") else None


@contextmanager
def _claimed(folder: Path) -> Iterator[None]:
    """Keep other processes out; the system ends the claim with the process, however that ends."""
    try:
        import fcntl
    except ImportError:  # no such locks on Windows
        yield
        return
    try:
        handle = os.open(folder, os.O_RDONLY)
    except OSError as error:
        raise SweepError(f"cannot read {folder}: {error.strerror}") from error
    try:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            raise SweepError(f"{folder}: another process computes this sweep now") from error
        except OSError:
            pass  # a file system without locks
        yield
    finally:
        os.close(handle)
