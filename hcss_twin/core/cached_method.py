"""Caching of methods without reference cycles, by their arguments or by spectrum."""

from __future__ import annotations

import weakref
from collections.abc import Callable
from functools import lru_cache
from types import MethodType
from typing import ParamSpec, TypeVar, TypeVarTuple, cast

import numpy as np

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


_Arguments = TypeVarTuple("_Arguments")


def cached_by_spectrum(
    function: Callable[[Array, *_Arguments], _T], maxsize: int
) -> Callable[[Array, *_Arguments], _T]:
    """Remember the last results of a function of wavenumbers (V,) and hashable arguments.

    Arrays have no hash, so their bytes are the key; ``function`` receives a read-only copy.
    """
    weak = weakly(function)

    @lru_cache(maxsize=maxsize)
    def from_bytes(wavenumbers: bytes, *args: *_Arguments) -> _T:
        return weak(np.frombuffer(wavenumbers, dtype=np.float64), *args)

    def remembered(wavenumber_cm1: Array, *args: *_Arguments) -> _T:
        return from_bytes(wavenumber_cm1.tobytes(), *args)

    return remembered
