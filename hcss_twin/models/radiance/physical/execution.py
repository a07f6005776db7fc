"""Execution of the model: single-threaded matrix products, and caching of results by spectrum."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import AbstractContextManager
from functools import cache, lru_cache, wraps
from typing import Any, ParamSpec, TypeVar, TypeVarTuple

import numpy as np

from hcss_twin.core.arrays import Array

_P = ParamSpec("_P")
_T = TypeVar("_T")
_Arguments = TypeVarTuple("_Arguments")


def in_one_thread(function: Callable[_P, _T]) -> Callable[_P, _T]:
    """Limit BLAS to one thread while a function runs; our own compiled loops keep their threads.

    The matrices of this model are so small that several BLAS threads would mostly wait, especially on a busy machine.
    The last bits of a product also depend on the number of threads.

    Threads that call such functions take turns. The limit holds for the libraries that numpy and scipy have loaded when
    such a function first runs.
    """

    @wraps(function)
    def limited(*args: _P.args, **kwargs: _P.kwargs) -> _T:
        # The limit applies to the process: the first of two threads to end would lift it for the other.
        with _turn(), _libraries().limit(limits=1, user_api="blas"):
            return function(*args, **kwargs)

    return limited


@cache
def _turn() -> AbstractContextManager[bool]:
    return threading.RLock()


@cache
def _libraries() -> Any:
    # Imported here: a run that reads all its tables from the cache needs neither the import nor the search (ms).
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()


def cached_by_spectrum(
    function: Callable[[Array, *_Arguments], _T], maxsize: int
) -> Callable[[Array, *_Arguments], _T]:
    """Remember the last results of a function of wavenumbers (V,) and hashable arguments.

    Arrays have no hash, so their bytes are the key; ``function`` receives a read-only copy.
    """

    @lru_cache(maxsize=maxsize)
    def from_bytes(wavenumbers: bytes, *args: *_Arguments) -> _T:
        return function(np.frombuffer(wavenumbers, dtype=np.float64), *args)

    def remembered(wavenumber_cm1: Array, *args: *_Arguments) -> _T:
        return from_bytes(wavenumber_cm1.tobytes(), *args)

    return remembered
