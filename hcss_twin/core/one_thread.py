"""Matrix products in one thread, so that results do not depend on the number of processors."""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache, wraps
from typing import Any, ParamSpec, TypeVar

_P = ParamSpec("_P")
_T = TypeVar("_T")


def in_one_thread(function: Callable[_P, _T]) -> Callable[_P, _T]:
    """Limit BLAS to one thread while a function runs; our own compiled loops keep their threads.

    The last bits of a matrix product depend on the number of threads; cubes must not. Most matrices are also so small
    that additional threads would mostly wait, especially on a busy machine.

    The limit applies to the BLAS libraries that numpy and scipy have loaded when the function starts, in all threads,
    until the last of those that call such functions has left.
    """

    @wraps(function)
    def limited(*args: _P.args, **kwargs: _P.kwargs) -> _T:
        with _limits().held("scipy.linalg" in sys.modules):
            return function(*args, **kwargs)

    return limited


class _Limits:
    """Limits of the whole process: the first caller sets them, and the last one lifts them."""

    def __init__(self) -> None:
        self._turn = threading.Lock()
        self._callers = 0
        self._set: dict[bool, Any] = {}

    @contextmanager
    def held(self, scipy: bool) -> Iterator[None]:
        with self._turn:
            if scipy not in self._set:
                self._set[scipy] = _libraries(scipy).limit(limits=1, user_api="blas")
            self._callers += 1
        try:
            yield
        finally:
            with self._turn:
                self._callers -= 1
                while self._set and not self._callers:
                    self._set.popitem()[1].restore_original_limits()


@cache
def _limits() -> _Limits:
    return _Limits()


@cache
def _libraries(scipy: bool) -> Any:
    """Return the loaded BLAS libraries; scipy has its own, which may be loaded later than numpy's."""
    # Imported here: a run that reads all its tables from the cache needs neither the import nor the search (ms).
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()
