"""In-memory caches that several scenes in one process share: files and results, and large arrays up to a size."""

from __future__ import annotations

import hashlib
from collections import OrderedDict
from collections.abc import Callable, Hashable, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

from hcss_twin.core.arrays import Array
from hcss_twin.core.code_fingerprint import code_fingerprint
from hcss_twin.core.environment import versions
from hcss_twin.core.plugins import OWN_DISTRIBUTION
from hcss_twin.core.stored_files import StoredFiles

__all__ = ["ResultCache"]

LIMIT_BYTES = 100_000_000


class ArrayMemory:
    """Tuples of arrays by keys that contain everything they depend on; they are shared and must not be modified.

    Parameters
    ----------
    limit_bytes : int
        Size of all arrays; the least recently used are dropped first, and a larger tuple is not kept at all.
    """

    def __init__(self, limit_bytes: int = LIMIT_BYTES) -> None:
        self._limit = limit_bytes
        self._arrays: OrderedDict[bytes, tuple[Array, ...]] = OrderedDict()
        self._size = 0

    def get_or_compute(self, key: bytes, compute: Callable[[], tuple[Array, ...]]) -> tuple[Array, ...]:
        """Return the arrays of a key, computed on first use."""
        if key in self._arrays:
            self._arrays.move_to_end(key)
            return self._arrays[key]
        arrays = compute()
        self._keep(key, arrays)
        return arrays

    def get_or_compute_some(
        self, key: bytes, wanted: Sequence[int], compute: Callable[[], list[tuple[Array, ...]]]
    ) -> list[tuple[Array, ...]]:
        """Return some of several tuples of arrays that are computed together, and kept one by one."""
        keys = {number: key + number.to_bytes(4, "big") for number in wanted}
        if all(part_key in self._arrays for part_key in keys.values()):
            for part_key in keys.values():
                self._arrays.move_to_end(part_key)
            return [self._arrays[part_key] for part_key in keys.values()]
        every = compute()
        for number, arrays in enumerate(every):
            self._keep(key + number.to_bytes(4, "big"), arrays)
        return [every[number] for number in wanted]

    def _keep(self, key: bytes, arrays: tuple[Array, ...]) -> None:
        if _bytes(arrays) > self._limit:
            return
        self._size += _bytes(arrays) - _bytes(self._arrays.pop(key, ()))
        self._arrays[key] = arrays
        while self._size > self._limit:
            self._size -= _bytes(self._arrays.popitem(last=False)[1])


@dataclass(frozen=True)
class OwnMemory:
    """The part of a memory for one object's arrays.

    Attributes
    ----------
    memory : ArrayMemory or None
        None where only small arrays are kept.
    content : bytes
        Equal for objects whose arrays are equal.
    small : dict
        Small arrays, by keys of the user's choice, who limits their number.
    objects : dict
        Objects that parts of one scene share; they must not refer to this memory.
    """

    memory: ArrayMemory | None
    content: bytes
    small: dict[Any, Array]
    objects: dict[Any, Any] = field(default_factory=dict)

    def get_or_compute(self, parts: Iterable[bytes], compute: Callable[[], tuple[Array, ...]]) -> tuple[Array, ...]:
        """Return the arrays of a key, given in parts, computed on first use."""
        if self.memory is None:
            return compute()
        digest = hashlib.sha256(self.content)
        for part in parts:
            digest.update(len(part).to_bytes(8, "big"))
            digest.update(part)
        return self.memory.get_or_compute(digest.digest(), compute)


def _bytes(arrays: tuple[Array, ...]) -> int:
    return sum(array.nbytes for array in arrays)


_T = TypeVar("_T")

MAX = 512
"""Number of results in memory; the least recently used are dropped first."""


class ResultCache:
    """Results by keys that contain everything a result depends on; they are shared and must not be modified.

    Parameters
    ----------
    within : iterable of Path, optional
        The user's files or folders that may be read for these results; by default all. A scenario from someone else's
        cube must not read any others.
    several : bool
        Whether there will be many scenes, so that it pays to keep their air.

    Attributes
    ----------
    own_files : set of Path
        The user's files that were read, if they are restricted.
    user_files : dict of str to Path
        All files of the user that were read, shipped neither here nor by a plugin, by the names in ``Catalog.used``.
    stored : StoredFiles or None
        Files of the cube that is recomputed, which may always be read.
    arrays : ArrayMemory
        Large arrays, such as solved clouds.
    air : ArrayMemory or None
        Transmittance and emission of air, if there are several scenes.
    recent : OrderedDict
        Results from the user's cache, and the hashes of files that they depend on, of several scenes.
    latest : (hashable, object)
        The last scene, too large for many to be kept, with its key.
    """

    def __init__(self, within: Iterable[Path] | None = None, several: bool = False) -> None:
        self._results: OrderedDict[Hashable, Any] = OrderedDict()
        self._within = None if within is None else tuple(path.resolve() for path in within)
        self.own_files: set[Path] = set()
        self.user_files: dict[str, Path] = {}
        self.stored: StoredFiles | None = None
        self.arrays = ArrayMemory()
        self.air = ArrayMemory() if several else None
        self.recent: OrderedDict[Hashable, Any] = OrderedDict()
        self.latest: tuple[Hashable, Any] = (None, None)

    def may_read(self, path: Path) -> bool:
        """Return whether a file of the user may be read; if so, it is added to a restricted cache's ``own_files``."""
        if self._within is None or (self.stored is not None and self.stored.name_of(path) is not None):
            return True
        if any(path.resolve().is_relative_to(folder) for folder in self._within):
            self.own_files.add(path)
            return True
        return False

    def get_or_compute(self, name: Hashable, compute: Callable[[], _T]) -> _T:
        """Return the result of a key, computed on first use."""
        if name in self._results:
            self._results.move_to_end(name)
        else:
            self._results[name] = compute()
            if len(self._results) > MAX:
                self._results.popitem(last=False)
        result: _T = self._results[name]
        return result

    def sha256(self, path: Path) -> str:
        """Return the hash of a file, which is read again if its size, modification time or inode changed."""
        return self.get_or_compute(("sha256", *_state(path)), lambda: hashlib.sha256(path.read_bytes()).hexdigest())

    def parsed(self, path: Path, read: Callable[[Path], _T]) -> _T:
        """Return the result of applying a reader, a module-level function, to a file."""
        return self.get_or_compute((read.__module__, read.__qualname__, *_state(path)), lambda: read(path))

    def versions(self) -> dict[str, str]:
        """Return the versions of this package and its libraries at the first call."""
        return self.get_or_compute("versions", versions)

    def fingerprint(self, distribution: str = OWN_DISTRIBUTION, targets: tuple[str, ...] = ()) -> str:
        """Return the :func:`code_fingerprint` of this package, or of objects of a distribution, at the first call."""
        code = () if distribution == OWN_DISTRIBUTION else targets
        return self.get_or_compute(("fingerprint", distribution, *code), lambda: code_fingerprint(distribution, code))


def _state(path: Path) -> tuple[str, int, int, int]:
    about = path.stat()
    return str(path.resolve()), about.st_size, about.st_mtime_ns, about.st_ino
