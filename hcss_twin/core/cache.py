"""What is kept: name of its folder in the cache, and how its files end.

Where results are kept between runs.

Whether code is still the same: versions, and the files of packages by size and time.

Files of one kind in the cache: whole or not there, the least recently used ones removed first.

Frozen dataclasses of numbers, text and arrays as files, without code in them.
"""

from __future__ import annotations

import contextlib
import dataclasses
import hashlib
import importlib.util
import json
import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import platformdirs
from numpy.typing import NDArray

from hcss_twin.core.errors import HcssError
from hcss_twin.core.files import atomic_write

TABLES = ("tables", ".npz")
"""Compiled tables of scenes."""

PLANS = ("plans", ".npz")
"""What plans found out about scenes."""

REFERENCES = ("references", ".npz")
"""Columns that certificates were made from."""

OPTICS = ("optics", ".nc")
"""Bulk properties of cloud particles."""


def cache_root() -> Path | None:
    """Return the cache folder: HCSS_CACHE_DIR, or hcss-twin in the user's cache folder; None for users without one.

    The user's cache folder is that of the operating system: on Linux XDG_CACHE_HOME or ~/.cache.
    """
    own = os.environ.get("HCSS_CACHE_DIR")
    if own:
        return Path(own)
    try:
        return platformdirs.user_cache_path("hcss-twin", appauthor=False, opinion=False)
    except RuntimeError:  # a user of the system without a home folder
        return None


def top_level(target: str) -> str:
    """Return the top-level package of ``package.module:name``."""
    return target.partition(":")[0].partition(".")[0]


def package_fingerprint(module: str) -> str:
    """Return a hash of the files of the package a module belongs to, by name, size and time of change.

    Parameters
    ----------
    module : str
        For example ``hcss_twin.models.sea.rough_sea``: its top-level package counts.
    """
    found = importlib.util.find_spec(module.partition(".")[0])
    if found is None:
        return "absent"
    digest = hashlib.sha256()
    if found.submodule_search_locations is None:
        files = [found.origin] if found.origin else []
    else:
        files = sorted(
            os.path.join(folder, name)
            for root in found.submodule_search_locations
            for folder, _, names in os.walk(root)
            if os.path.basename(folder) != "__pycache__"
            for name in names
        )
    for path in files:
        with suppress(FileNotFoundError):  # a link that leads nowhere
            about = os.stat(path)
            digest.update(f"{path}\0{about.st_size}\0{about.st_mtime_ns}\n".encode())
    return digest.hexdigest()


DEFAULT_LIMIT_MB = 1000.0


@dataclass(frozen=True)
class Kept:
    """One file of the cache."""

    path: Path
    size: int
    last_used_s: float


class CacheError(HcssError):
    """The cache cannot be used as asked."""


def limit_bytes() -> int:
    """Return the most a kind may occupy: HCSS_CACHE_MB megabytes, 1000 without it; 0 keeps nothing.

    Raises
    ------
    CacheError
        If the variable is not a number, 0 or more.
    """
    text = os.environ.get("HCSS_CACHE_MB", "")
    try:
        megabytes = float(text) if text else DEFAULT_LIMIT_MB
    except ValueError:
        megabytes = -1.0
    if not 0.0 <= megabytes < 1e12:
        raise CacheError(f"HCSS_CACHE_MB is '{text}'; allowed: a number of megabytes, 0 or more")
    return int(megabytes * 1e6)


class Store:
    """Files of one kind.

    Parameters
    ----------
    kind : str
        Name of their folder in the cache.
    suffix : str
        How they end.
    """

    def __init__(self, kind: str, suffix: str) -> None:
        root = cache_root()
        self.folder: Path | None = None if root is None else root / kind
        self._suffix = suffix

    def find(self, key: str) -> Path | None:
        """Return the file of a key, which counts as used now; None if there is none."""
        if self.folder is None:
            return None
        path = self.folder / f"{key}{self._suffix}"
        try:
            os.utime(path)
        except OSError:
            return None
        return path

    def keep(self, key: str, write: Callable[[Path], None]) -> None:
        """Write the file of a key and remove the least recently used beyond the limit.

        A cache that cannot be written costs time and nothing else. Several processes may write at once: each file
        appears whole, under a name that says what it holds.

        Parameters
        ----------
        write : callable
            Writes to the path it is given.
        """
        limit = limit_bytes()
        if self.folder is None or limit == 0:
            return
        with contextlib.suppress(OSError, CacheError):
            self.folder.mkdir(parents=True, exist_ok=True)
            with atomic_write(self.folder / f"{key}{self._suffix}", CacheError) as draft:
                write(draft)
            self._prune(limit)

    def forget(self, key: str) -> None:
        """Remove the file of a key, if there is one."""
        if self.folder is not None:
            with contextlib.suppress(OSError):
                (self.folder / f"{key}{self._suffix}").unlink()

    def kept(self) -> list[Kept]:
        """Return all files, the most recently used first."""
        return sorted(self._files(), key=lambda each: -each.last_used_s)

    def clear(self) -> list[Kept]:
        """Remove all files and return those that were there."""
        removed = []
        for each in self.kept():
            with contextlib.suppress(OSError):
                each.path.unlink()
                removed.append(each)
        return removed

    def _files(self) -> Iterator[Kept]:
        if self.folder is None or not self.folder.is_dir():
            return
        for path in self.folder.glob(f"[!.]*{self._suffix}"):
            with contextlib.suppress(OSError):  # removed by another process
                about = path.stat()
                yield Kept(path, about.st_size, about.st_mtime)

    def _prune(self, limit: int) -> None:
        total = 0
        for each in self.kept():
            total += each.size
            if total > limit:
                with contextlib.suppress(OSError):
                    each.path.unlink()


_STRUCTURE = "structure"


def write_record(path: Path, record: Any, classes: Mapping[str, type]) -> None:
    """Write a tree of dataclasses, tuples, arrays, numbers, text and None.

    Parameters
    ----------
    path : Path
        An npz archive: every array under a number, and the tree as JSON.
    record : dataclass
    classes : mapping of str to type
        The dataclasses that may occur, by name.

    Raises
    ------
    TypeError
        If something else occurs in it.
    """
    arrays: dict[str, NDArray[Any]] = {}
    structure = json.dumps(_encode(record, {each: name for name, each in classes.items()}, arrays))
    with path.open("wb") as file:
        np.savez(file, allow_pickle=False, **{_STRUCTURE: np.array(structure)}, **arrays)


def read_record(path: Path, classes: Mapping[str, type]) -> Any:
    """Read what :func:`write_record` wrote.

    Raises
    ------
    Exception
        Of many kinds, if the file is not such a record.
    """
    with path.open("rb") as file, np.load(file, allow_pickle=False) as archive:
        return _decode(json.loads(str(archive[_STRUCTURE])), classes, archive)


def _encode(value: Any, names: Mapping[type, str], arrays: dict[str, NDArray[Any]]) -> Any:
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, np.ndarray):
        key = str(len(arrays))
        arrays[key] = value
        return {"array": key}
    if isinstance(value, tuple | list):
        return {"tuple": [_encode(each, names, arrays) for each in value]}
    if type(value) in names:
        fields = {each.name: _encode(getattr(value, each.name), names, arrays) for each in dataclasses.fields(value)}
        return {"class": names[type(value)], "fields": fields}
    raise TypeError(f"{type(value).__name__} cannot be kept in a record")


def _decode(value: Any, classes: Mapping[str, type], arrays: Mapping[str, NDArray[Any]]) -> Any:
    if not isinstance(value, dict):
        return value
    if "array" in value:
        return arrays[value["array"]]
    if "tuple" in value:
        return tuple(_decode(each, classes, arrays) for each in value["tuple"])
    made = {name: _decode(each, classes, arrays) for name, each in value["fields"].items()}
    return classes[value["class"]](**made)
