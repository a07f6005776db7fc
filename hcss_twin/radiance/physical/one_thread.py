"""One thread for products of matrices.

Those of this model are so small that several threads wait for each other longer than they compute, above all where
other programs use the processors, too; and in another number of threads the last bits of a product are others.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import AbstractContextManager
from functools import cache, wraps
from typing import Any, ParamSpec, TypeVar

_P = ParamSpec("_P")
_T = TypeVar("_T")


def in_one_thread(function: Callable[_P, _T]) -> Callable[_P, _T]:
    """Have the process multiply matrices in one thread while a function runs; loops of our own keep theirs.

    Functions that several threads call take turns. It holds for libraries that numpy and scipy have loaded when such a
    function runs first.
    """

    @wraps(function)
    def limited(*args: _P.args, **kwargs: _P.kwargs) -> _T:
        # The number belongs to the process: the first of two threads to end would give it back under the other.
        with _turn(), _libraries().limit(limits=1, user_api="blas"):
            return function(*args, **kwargs)

    return limited


@cache
def _turn() -> AbstractContextManager[bool]:
    return threading.RLock()


@cache
def _libraries() -> Any:
    """Find the libraries: some milliseconds, once."""
    # imported here: runs that find their tables should not wait for it
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()
