"""The folder of a sweep: its cubes, the record of each point, and the identity of the sweep."""

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

from pydantic import TypeAdapter

from hcss_sweep.errors import SweepError
from hcss_sweep.points import PointOutcome, SweepPoint, certified_share, sha256_of
from hcss_twin.core.files import Writing
from hcss_twin.core.reading import Reading
from hcss_twin.engine.certificate.certificate import Certificate
from hcss_twin.providers import CubeError

PointState = Literal["pending", "done", "failed"]


@dataclass(frozen=True)
class PointRecord:
    """One row of the index: the number of a point, its state, and its swept keys with their JSON values.

    ``file``, ``bytes`` and ``sha256`` describe the cube in the sweep's folder, which keeps cubes with failed
    certificates. ``seconds`` is the time to compute the point, ``error`` the reason for a failure. ``certified`` is the
    largest error of the pixels checked, relative to the accuracy asked for; None if none was.
    """

    point: int
    values: Mapping[str, Any]
    state: PointState = "pending"
    file: str | None = None
    bytes: int | None = None
    sha256: str | None = None
    seconds: float | None = None
    error: str | None = None
    certified: float | None = None

    @property
    def is_settled(self) -> bool:
        """Whether the point needs no recomputation: it is done, or its cube misses the requested accuracy."""
        return self.state != "pending" and self.file is not None

    def as_dict(self) -> dict[str, Any]:
        """Return plain values."""
        return {**asdict(self), "values": dict(self.values)}

    def with_outcome(self, outcome: PointOutcome) -> PointRecord:
        """Return the record updated with the outcome of the computation."""
        return replace(self, state="failed" if outcome.error else "done", **asdict(outcome))


INDEX = "index.json"
LOG = "points.jsonl"

FORMAT = 1
"""Version of the index, increased when the meaning of a field changes."""

_INDEX_EVERY_S = 2.0
"""Minimum interval between updates of the index, which is rewritten as a whole."""


def cube_name(point: int, count: int) -> str:
    """Return the file name of a point's cube; names sort by point number."""
    return f"point-{point:0{max(4, len(str(count - 1)))}d}.nc"


def is_cube_name(name: str) -> bool:
    """Whether this can be the file name of a point."""
    return name.startswith("point-")


class SweepFolder:
    """The records of all points of a sweep, on disk and in memory.

    A line is appended to the log for each computed point, and the log is never rewritten. The index is written
    atomically; after a kill it may lag behind the log, which takes precedence. A complete cube with the scenario of its
    point counts as done even if it is missing from the log. ``digest`` is a hash of what the sweep computes, ``about``
    the index entries that describe the whole sweep.
    """

    def __init__(self, path: Path, digest: str, about: Mapping[str, Any], points: Sequence[SweepPoint]) -> None:
        self.path = path
        self._digest, self._about, self._points = digest, about, points
        self.records = [PointRecord(point.number, point.values) for point in points]
        self._written_s = 0.0

    @contextmanager
    def open(self, versions: Mapping[str, str], force: bool) -> Iterator[None]:
        """Lock the folder for this sweep while the block runs, and read its records.

        All versions that affect the numbers, and the code of plugins, must be those of the earlier run.
        ``force`` removes what an earlier sweep, or this one, left there. Raises SweepError if the folder holds
        another sweep or something else, another process is writing to it, or it cannot be written.
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
            Writing.remove_orphans(self.path, every=True)
            self._read_log()
            self._adopt_cubes()
            self.write_index()
            try:
                yield
            finally:
                Writing.remove_orphans(self.path, every=True)
                # An interrupt may occur between writing a cube and its log line.
                self._adopt_cubes()
                self.write_index()

    def note(self, outcome: PointOutcome) -> PointRecord:
        """Record a computed point."""
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
        """Write the index; raises SweepError if that fails."""
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
        with Writing(self.path / INDEX, SweepError) as draft:
            draft.write_text(text + "\n", encoding="utf-8")
        self._written_s = time.monotonic()

    def _read_index(self) -> dict[str, Any] | None:
        path = self.path / INDEX
        if not path.exists():
            return None
        with Reading(path, SweepError, "give another folder"):
            known = json.loads(path.read_text(encoding="utf-8"))
        types = {"format": int, "sweep": str, "keys": list, "versions": dict, "points": list}
        if (
            not isinstance(known, dict)
            or not all(isinstance(known.get(name), kind) for name, kind in types.items())
            or known["format"] != FORMAT
        ):
            raise SweepError(f"{path} is not a sweep index of this version; give another folder")
        return known

    def _require_empty(self) -> None:
        left = sorted(path.name for path in self.path.iterdir())
        if left:
            listed = ", ".join(left[:3]) + (", ..." if len(left) > 3 else "")
            raise SweepError(
                f"{self.path} is not empty and holds no sweep ({listed}); allowed: a new or empty folder, or one that "
                "holds this sweep"
            )

    def _require_same(self, known: Mapping[str, Any], versions: Mapping[str, str]) -> None:
        remedy = "allowed: another folder, or --force, which removes its cubes and starts again"
        if known["sweep"] != self._digest:
            keys = ", ".join(map(str, known["keys"]))
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
                f"{self.path} is from other versions, which may round differently: {'; '.join(changed)}; {remedy}"
            )

    def _remove(self, known: Mapping[str, Any]) -> None:
        """Remove the files written by a sweep, and no others."""
        count = len(known["points"])
        for name in (LOG, *(cube_name(number, count) for number in range(count)), INDEX):
            with contextlib.suppress(FileNotFoundError):
                (self.path / name).unlink()
        Writing.remove_orphans(self.path, every=True)

    def _read_log(self) -> None:
        path = self.path / LOG
        if not path.exists():
            return
        with Reading(path, SweepError):
            text = path.read_text(encoding="utf-8", errors="replace")
        if text and not text.endswith("\n"):  # killed while writing
            with path.open("a", encoding="utf-8") as file:
                file.write("\n")
        logged, known = TypeAdapter(PointRecord), range(len(self.records))
        for line in text.splitlines():
            with contextlib.suppress(ValueError):  # the line is damaged: its cube is checked
                record = logged.validate_json(line)
                if record.point in known and record.file in (None, cube_name(record.point, len(known))):
                    self.records[record.point] = replace(record, values=self.records[record.point].values)
        for number, record in enumerate(self.records):
            cube = None if record.file is None else self.path / record.file
            if cube is not None and not (cube.is_file() and cube.stat().st_size == record.bytes):
                self.records[number] = PointRecord(number, record.values)

    def _adopt_cubes(self) -> None:
        """Mark cubes as done that were complete but not yet logged when the sweep was killed."""
        for point, record in zip(self._points, self.records, strict=True):
            path = self.path / cube_name(point.number, len(self._points))
            if record.file is None and path.is_file() and _is_cube_of(path, point):
                try:
                    error, share = _certified(path)
                except CubeError:  # damaged: it is computed again
                    continue
                size = path.stat().st_size
                self.note(PointOutcome(point.number, path.name, size, sha256_of(path), None, error, share))


def _is_cube_of(path: Path, point: SweepPoint) -> bool:
    from hcss_twin import open_cube

    try:
        with open_cube(path) as cube:
            return bool(cube.attrs.get("hcss_scenario") == point.scenario.to_json())
    except CubeError:
        return False


def _certified(path: Path) -> tuple[str | None, float | None]:
    """Return the error of a cube whose certificate failed, and its largest error relative to its accuracy."""
    from hcss_twin import open_cube

    with open_cube(path) as cube:
        text, of = str(cube.attrs.get("hcss_certificate", "")), cube.attrs.get
        units = (
            (of(f"hcss_accuracy_requested{unit}"), of(f"hcss_accuracy_achieved{unit}")) for unit in ("_kelvin", "")
        )
        share = certified_share(*((asked, json.loads(errors)) for asked, errors in units if asked and errors))
    failed = text.startswith((Certificate.NOT_AS_SPECIFIED, "FAILED"))  # the second in earlier versions
    return f"certificate {text}" if failed else None, share


@contextmanager
def _claimed(folder: Path) -> Iterator[None]:
    """Lock the folder against other processes; the system releases the lock when the process ends for any reason."""
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
            raise SweepError(f"{folder}: another process is computing this sweep") from error
        except OSError:
            pass  # a file system without locks
        yield
    finally:
        os.close(handle)
