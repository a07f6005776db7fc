"""Arrays that several scenes in one process share, such as solved clouds, up to a number of bytes."""

from __future__ import annotations

import hashlib
import weakref
from collections import OrderedDict
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from types import MethodType
from typing import Any, ParamSpec, TypeVar, cast

from hcss_twin.core.arrays import Array

_P = ParamSpec("_P")
_T = TypeVar("_T")


def weakly(method: Callable[_P, _T]) -> Callable[_P, _T]:
    """Return a bound method that does not keep its object alive; other functions are returned unchanged.

    A bound method stored in its own object forms a reference cycle: all arrays of the object then stay in memory until
    the garbage collector runs, possibly many scenes later.
    """
    if not isinstance(method, MethodType):
        return method
    function, reference = method.__func__, weakref.ref(method.__self__)

    def call(*args: _P.args, **kwargs: _P.kwargs) -> _T:
        owner = reference()
        if owner is None:
            raise ReferenceError(f"{function.__qualname__}: its object is gone")
        return cast(_T, function(owner, *args, **kwargs))

    return call


def cached_method(method: Callable[_P, _T], maxsize: int) -> Callable[_P, _T]:
    """Return a method that caches its last results, to be stored in its own object."""
    return cast("Callable[_P, _T]", lru_cache(maxsize=maxsize)(weakly(method)))


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
        if all(each in self._arrays for each in keys.values()):
            for each in keys.values():
                self._arrays.move_to_end(each)
            return [self._arrays[each] for each in keys.values()]
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
    return sum(each.nbytes for each in arrays)
