"""Results that runs keep in the user's cache: each file has a name that says all its content depends on.

Files appear whole or not at all, hold no code, and are removed again, the least recently used ones first.
"""

from __future__ import annotations

import contextlib
import dataclasses
import hashlib
import json
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy as np
import platformdirs
from numpy.typing import NDArray

from hcss_twin.core.catalog import Catalog, SecludedCatalog
from hcss_twin.core.errors import HcssError
from hcss_twin.core.files import atomic_write
from hcss_twin.core.result_cache import ResultCache

TABLES = ("tables", ".npz")
"""Compiled tables of scenes: name of their folder in the cache, and how the files end."""

PLANS = ("plans", ".npz")
"""Analyses of scenes."""

REFERENCES = ("references", ".npz")
"""Columns that certificates are made from."""

OPTICS = ("optics", ".nc")
"""Bulk properties of cloud particles."""

FORMAT = 2
"""Raised when what is written changes its meaning."""

DEFAULT_LIMIT_MB = 1000.0

_T = TypeVar("_T")


class CacheError(HcssError):
    """The cache cannot be used as asked."""


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


def result_key(parts: Mapping[str, Any], memory: ResultCache) -> str:
    """Return a hash of what a result depends on, and of this package and its libraries."""
    code = {"format": FORMAT, "libraries": memory.versions(), "engine": memory.fingerprint(__name__)}
    return hashlib.sha256(json.dumps({**parts, **code}, sort_keys=True, default=str).encode()).hexdigest()


def recall_or_compute(
    kind: tuple[str, str], key: str, catalog: Catalog, compute: Callable[[], _T], classes: tuple[type, ...]
) -> _T:
    """Return the result that an earlier run kept, the same to the bit, or compute it and keep it.

    Parameters
    ----------
    kind : (str, str)
        For example ``TABLES``.
    key : str
        Of all that the result depends on, the files in ``catalog.used`` among it. Files that ``compute`` reads beside
        these are kept with the result: they must be unchanged, and are recorded as read again.
    catalog : Catalog
        With a secluded one nothing is recalled and nothing is kept.
    classes : tuple of type
        Dataclasses that may occur in the result; that of the result comes first.
    """
    if isinstance(catalog, SecludedCatalog):
        return compute()
    store, folder, before = Store(*kind), str(catalog.base.resolve()), catalog.used
    path = store.find(key)
    if path is not None:
        with contextlib.suppress(Exception):  # whatever is wrong with the file, its result is computed again
            base, names, digests, kept = read_record(path, classes)
            files = dict(zip(names, digests, strict=True))
            # Files of a scenario in another folder are not those of this one.
            if isinstance(kept, classes[0]) and base in ("", folder) and catalog.unchanged(files):
                result: _T = kept  # type: ignore[assignment]
                return result
    result = compute()
    read = {name: digest for name, digest in catalog.used.items() if name not in before}
    base = folder if any(Path(name).is_absolute() for name in read) else ""
    store.keep(key, lambda draft: write_record(draft, (base, tuple(read), tuple(read.values()), result), classes))
    return result


class CachedFile(NamedTuple):
    """One file of the cache."""

    path: Path
    size: int
    last_used_s: float


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
        """Write the file of a key, by a function of its path, and remove the least recently used beyond the limit.

        A cache that cannot be written costs time and nothing else; several processes may write at once.
        """
        limit = limit_bytes()
        if self.folder is None or limit == 0:
            return
        with contextlib.suppress(OSError, CacheError):
            self.folder.mkdir(parents=True, exist_ok=True)
            with atomic_write(self.folder / f"{key}{self._suffix}", CacheError) as draft:
                write(draft)
            total = 0
            for each in self.kept():
                total += each.size
                if total > limit:
                    _remove(each.path)

    def forget(self, key: str) -> None:
        """Remove the file of a key, if there is one."""
        if self.folder is not None:
            _remove(self.folder / f"{key}{self._suffix}")

    def kept(self) -> list[CachedFile]:
        """Return all files, the most recently used first."""
        files = []
        for path in [] if self.folder is None else self.folder.glob(f"[!.]*{self._suffix}"):
            with contextlib.suppress(OSError):  # removed by another process
                about = path.stat()
                files.append(CachedFile(path, about.st_size, about.st_mtime))
        return sorted(files, key=lambda each: -each.last_used_s)

    def clear(self) -> list[CachedFile]:
        """Remove all files and return those that were there."""
        return [each for each in self.kept() if _remove(each.path)]


def _remove(path: Path) -> bool:
    with contextlib.suppress(OSError):
        path.unlink()
        return True
    return False


def write_record(path: Path, record: Any, classes: tuple[type, ...]) -> None:
    """Write a tree of dataclasses, tuples, arrays, numbers, text and None as an npz archive: arrays, and JSON.

    Raises
    ------
    TypeError
        If something else occurs in it.
    """
    arrays: dict[str, NDArray[Any]] = {}
    structure = json.dumps(_encode(record, classes, arrays))
    with path.open("wb") as file:
        np.savez(file, allow_pickle=False, structure=np.array(structure), **arrays)


def read_record(path: Path, classes: tuple[type, ...]) -> Any:
    """Read what :func:`write_record` wrote; raises exceptions of many kinds if the file is not such a record."""
    with path.open("rb") as file, np.load(file, allow_pickle=False) as archive:
        return _decode(json.loads(str(archive["structure"])), {each.__name__: each for each in classes}, archive)


def _encode(value: Any, classes: tuple[type, ...], arrays: dict[str, NDArray[Any]]) -> Any:
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, np.ndarray):
        key = str(len(arrays))
        arrays[key] = value
        return {"array": key}
    if isinstance(value, tuple | list):
        return {"tuple": [_encode(each, classes, arrays) for each in value]}
    if type(value) in classes:
        fields = {each.name: _encode(getattr(value, each.name), classes, arrays) for each in dataclasses.fields(value)}
        return {"class": type(value).__name__, "fields": fields}
    raise TypeError(f"{type(value).__name__} cannot be kept in a record")


def _decode(value: Any, classes: Mapping[str, type], arrays: Mapping[str, NDArray[Any]]) -> Any:
    if not isinstance(value, dict):
        return value
    if "array" in value:
        return arrays[value["array"]]
    if "tuple" in value:
        return tuple(_decode(each, classes, arrays) for each in value["tuple"])
    fields = {name: _decode(each, classes, arrays) for name, each in value["fields"].items()}
    return classes[value["class"]](**fields)
