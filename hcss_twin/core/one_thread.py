"""Matrix products in one thread, so that results do not depend on the number of processors."""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable
from contextlib import AbstractContextManager
from functools import cache, wraps
from typing import Any, ParamSpec, TypeVar

_P = ParamSpec("_P")
_T = TypeVar("_T")


def in_one_thread(function: Callable[_P, _T]) -> Callable[_P, _T]:
    """Limit BLAS to one thread while a function runs; our own compiled loops keep their threads.

    The last bits of a matrix product depend on the number of threads; cubes must not. Most matrices are also so small
    that additional threads would mostly wait, especially on a busy machine.

    Threads that call such functions take turns. The limit applies to the BLAS libraries that numpy and scipy have
    loaded when the function starts.
    """

    @wraps(function)
    def limited(*args: _P.args, **kwargs: _P.kwargs) -> _T:
        # The limit applies to the whole process: without turns, the first thread to finish would lift it for others.
        with _turn(), _libraries("scipy.linalg" in sys.modules).limit(limits=1, user_api="blas"):
            return function(*args, **kwargs)

    return limited


@cache
def _turn() -> AbstractContextManager[bool]:
    return threading.RLock()


@cache
def _libraries(scipy: bool) -> Any:
    """Return the loaded BLAS libraries; scipy has its own, which may be loaded later than numpy's."""
    # Imported here: a run that reads all its tables from the cache needs neither the import nor the search (ms).
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()
