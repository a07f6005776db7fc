"""Results of runs in the user's cache: each file name is a hash of everything the result depends on.

Files are written atomically and contain no code; the least recently used are removed first.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import re
import warnings
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple, TypeVar, cast

import platformdirs

from hcss_twin.core.catalog import Catalog, SecludedCatalog
from hcss_twin.core.errors import CacheWarning, HcssError
from hcss_twin.core.files import Writing
from hcss_twin.core.records import read_record, write_record
from hcss_twin.core.result_cache import ResultCache
from hcss_twin.core.stages import done_once
from hcss_twin.core.trust import distrust, make_private, withhold

__all__ = ["kept_result"]

TABLES = ("tables", ".npz")
"""Radiance tables of scenes: cache folder and file suffix."""

PLANS = ("plans", ".npz")
"""Scene analyses."""

REFERENCES = ("references", ".npz")
"""Columns computed for certificates."""

OPTICS = ("optics", ".nc")
"""Bulk properties of cloud particles."""

FORMAT = 2
"""Incremented when the meaning of the stored values changes."""

DEFAULT_LIMIT_MB = 1000.0

RECENT = 8
"""Results that stay in the memory of a process with several scenes: a scene asks for about as many."""

_KEY = re.compile(r"[0-9a-f]{64}")
"""Name of a file without its suffix: a SHA-256."""

_T = TypeVar("_T")


class CacheError(HcssError):
    """The cache settings are invalid."""


def cache_root() -> Path | None:
    """Return the cache folder: HCSS_CACHE_DIR, or hcss-twin in the user's cache folder; None if there is neither.

    The operating system defines the user's cache folder: on Linux XDG_CACHE_HOME or ~/.cache.
    """
    folder = os.environ.get("HCSS_CACHE_DIR")
    if folder:
        return Path(folder)
    try:
        return platformdirs.user_cache_path("hcss-twin", appauthor=False, opinion=False)
    except RuntimeError:  # a system user without a home folder
        return None


def limit_bytes() -> int:
    """Return the size limit of each kind: HCSS_CACHE_MB megabytes, by default 1000; 0 disables the cache.

    Raises
    ------
    CacheError
        If the variable is not a non-negative number.
    """
    text = os.environ.get("HCSS_CACHE_MB", "")
    try:
        megabytes = float(text) if text else DEFAULT_LIMIT_MB
    except ValueError:
        megabytes = -1.0
    if not 0.0 <= megabytes < 1e12:
        raise CacheError(f"HCSS_CACHE_MB is '{text}'; allowed: a number of megabytes, 0 or more")
    return int(megabytes * 1e6)


def in_use(folder: Path | None) -> Path | None:
    """Return a cache folder that may be read and written.

    It is None if there is none, if the size limit is 0, or, with a CacheWarning, if its place is taken by a file, or
    other users could have written to it: cached results determine the values of cubes.
    """
    if folder is None or limit_bytes() == 0:
        return None
    usable = _is_free(folder) and _trusted(folder) and _trusted(folder.parent)
    return folder if usable else None


def _is_free(folder: Path) -> bool:
    """Whether a folder is there, or can be made; if a file has its name, or that of one above it, warn."""
    there = next((each for each in (folder, *folder.parents) if each.exists()), folder)
    if there.is_dir() or not there.exists():
        return True
    message = f"the cache is not used: {there} is no folder; set HCSS_CACHE_DIR to a folder, or HCSS_CACHE_MB to 0"
    warnings.warn(message, CacheWarning, stacklevel=2)
    return False


def _trusted(path: Path) -> bool:
    """Whether no other user can have written a folder or file of the cache; if one can, warn, once for each path."""
    why = distrust(path)
    if why:
        message = (
            f"the cache is not used: {why}; remove that permission, or set HCSS_CACHE_DIR to a folder of your own, or "
            "HCSS_CACHE_MB to 0"
        )
        warnings.warn(message, CacheWarning, stacklevel=2)
    return not why


def cached_file(folder: Path, name: str) -> Path | None:
    """Return a file in a folder of the cache that no other user can have written; None if there is none."""
    path = folder / name
    return path if path.is_file() and _trusted(path) else None


def result_key(parts: Mapping[str, Any], memory: ResultCache) -> str:
    """Return a hash of the inputs of a result and of the versions of this package and its libraries."""
    code = {"format": FORMAT, "libraries": memory.versions(), "engine": memory.fingerprint()}
    return hashlib.sha256(json.dumps({**parts, **code}, sort_keys=True, default=str).encode()).hexdigest()


def kept_result(parts: Mapping[str, Any], catalog: Catalog, compute: Callable[[], _T], classes: tuple[type, ...]) -> _T:
    """Return what an earlier run found out, bit for bit, or compute it and keep it in the user's cache.

    For small results that are dear to compute, such as tables that a provider makes of a scene.

    Parameters
    ----------
    parts : mapping
        All that the result depends on, for JSON; versions of this package and of its libraries are added.
    catalog : Catalog
        Reader of files. Files that ``compute`` reads are checked before the result is used again.
    compute : callable
        Returns the result.
    classes : tuple of type
        Dataclasses that may occur in the result; the class of the result itself comes first.
    """
    return recall_or_compute(PLANS, result_key(parts, catalog.shelf), catalog, compute, classes)


def recall_or_compute(
    kind: tuple[str, str], key: str, catalog: Catalog, compute: Callable[[], _T], classes: tuple[type, ...]
) -> _T:
    """Return the cached result of an earlier run, bit for bit, or compute it and store it.

    Parameters
    ----------
    kind : (str, str)
        Folder and suffix, for example ``TABLES``.
    key : str
        Hash of all inputs, including the files in ``catalog.used``. Further files that ``compute`` reads are
        stored with the result: the result is reused only if they are unchanged, and they are then recorded as
        read.
    catalog : Catalog
        With a secluded catalog the cache is neither read nor written.
    classes : tuple of type
        Dataclasses that may occur in the result; the class of the result itself comes first.
    """
    if isinstance(catalog, SecludedCatalog):
        return compute()
    if catalog.shelf.air is None:
        return _stored(kind, key, catalog, compute, classes)[0]
    recent, name = catalog.shelf.recent, (*kind, key, catalog.base)
    known = recent.pop(name, None)
    if known is None or not catalog.unchanged(known[1]):
        known = _stored(kind, key, catalog, compute, classes)
    recent[name] = known
    while len(recent) > RECENT:
        recent.popitem(last=False)
    return cast(_T, known[0])


def _stored(
    kind: tuple[str, str], key: str, catalog: Catalog, compute: Callable[[], _T], classes: tuple[type, ...]
) -> tuple[_T, Mapping[str, str]]:
    """Return a result from the user's cache, or computed and stored there, and the files that it was made from."""
    store, folder, before = Store(*kind), str(catalog.base.resolve()), catalog.used
    path = store.find(key)
    if path is not None:
        with contextlib.suppress(Exception):  # if the file is unusable, the result is recomputed
            kept_key, base, names, digests, kept = read_record(path, classes)
            files = dict(zip(names, digests, strict=True))
            # A scenario in another folder refers to other files.
            if kept_key == key and isinstance(kept, classes[0]) and base in ("", folder) and catalog.unchanged(files):
                return cast(_T, kept), files
    with done_once():
        result = compute()
        read = {name: digest for name, digest in catalog.used.items() if name not in before}
        base = folder if any(Path(name).is_absolute() for name in read) else ""
        record = (key, base, tuple(read), tuple(read.values()), result)
        store.keep(key, lambda draft: write_record(draft, record, classes))
    return result, read


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
        Name of the folder in the cache.
    suffix : str
        File suffix.
    """

    def __init__(self, kind: str, suffix: str) -> None:
        root = cache_root()
        self.folder: Path | None = None if root is None else root / kind
        self._suffix = suffix

    def find(self, key: str) -> Path | None:
        """Return the file of a key and mark it as used now; None if there is none."""
        folder = in_use(self.folder)
        if folder is None:
            return None
        path = cached_file(folder, f"{key}{self._suffix}")
        if path is not None:
            with contextlib.suppress(OSError):  # removed by another process, or root's
                os.utime(path)
        return path

    def keep(self, key: str, write: Callable[[Path], None]) -> None:
        """Write the file of a key and remove the least recently used files beyond the limit; ``write`` gets its path.

        A cache that cannot be written only costs time; several processes may write at once.
        """
        folder, limit = in_use(self.folder), limit_bytes()
        if folder is None:
            return
        with contextlib.suppress(OSError, CacheError):
            make_private(folder)
            Writing.remove_orphans(folder)
            with Writing(folder / f"{key}{self._suffix}", CacheError) as draft:
                write(draft)
                withhold(draft)
            total = 0
            for file in self.kept():
                total += file.size
                if total > limit:
                    _remove(file.path)

    def kept(self) -> list[CachedFile]:
        """Return all files, most recently used first; files of other names are somebody's own."""
        files = []
        for path in [] if self.folder is None else self.folder.glob(f"*{self._suffix}"):
            if not _KEY.fullmatch(path.name.removesuffix(self._suffix)):
                continue
            with contextlib.suppress(OSError):  # removed by another process
                about = path.stat()
                files.append(CachedFile(path, about.st_size, about.st_mtime))
        return sorted(files, key=lambda file: -file.last_used_s)

    def clear(self) -> list[CachedFile]:
        """Remove all files and return them."""
        return [file for file in self.kept() if _remove(file.path)]


def _remove(path: Path) -> bool:
    with contextlib.suppress(OSError):
        path.unlink()
        return True
    return False
