"""Files of one kind in the cache: whole or not there, the least recently used ones removed first."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from hcss_twin.cache.folder import cache_root
from hcss_twin.drafts import draft_of
from hcss_twin.errors import HcssError

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
            with draft_of(self.folder / f"{key}{self._suffix}", CacheError) as draft:
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
