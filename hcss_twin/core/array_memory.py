"""Arrays that several scenes in one process share, such as solved clouds, up to a number of bytes."""

from __future__ import annotations

import hashlib
from collections import OrderedDict
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from hcss_twin.core.arrays import Array

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
        if _bytes(arrays) > self._limit:
            return arrays
        self._arrays[key] = arrays
        self._size += _bytes(arrays)
        while self._size > self._limit:
            self._size -= _bytes(self._arrays.popitem(last=False)[1])
        return arrays


@dataclass(frozen=True)
class OwnMemory:
    """The part of a memory for one object's arrays.

    Attributes
    ----------
    content : bytes
        Equal for objects whose arrays are equal.
    small : dict
        Small arrays, by keys of the user's choice, who limits their number.
    """

    memory: ArrayMemory
    content: bytes
    small: dict[Any, Array]

    def get_or_compute(self, parts: Iterable[bytes], compute: Callable[[], tuple[Array, ...]]) -> tuple[Array, ...]:
        """Return the arrays of a key, given in parts, computed on first use."""
        digest = hashlib.sha256(self.content)
        for part in parts:
            digest.update(len(part).to_bytes(8, "big"))
            digest.update(part)
        return self.memory.get_or_compute(digest.digest(), compute)


def _bytes(arrays: tuple[Array, ...]) -> int:
    return sum(each.nbytes for each in arrays)
