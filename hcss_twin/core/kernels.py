"""Compiled loops over pixels: numba's ``njit`` with the options and the cache of this package."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba import njit
from numba.core.caching import FunctionCache
from numba.core.runtime import rtsys


class _KernelCache(FunctionCache):  # type: ignore[misc]  # numba has no types
    """Cache that loads machine code without the tables of the compiler.

    Numba prepares its compiler before it loads compiled code, which takes several tenths of a second, most of it for
    scipy.linalg. Compiled code needs only the memory management; the compiler prepares itself when it is needed.
    """

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        rtsys.initialize(target_context)
        with self._guard_against_spurious_io_errors():
            return self._load_overload(sig, target_context)


def kernel(**options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Compile a function at its first call on a machine; it releases the interpreter's lock while it runs.

    Parameters
    ----------
    **options
        More options of :func:`numba.njit`.
    """

    def compiled(function: Callable[..., Any]) -> Any:
        dispatcher = njit(nogil=True, **options)(function)
        dispatcher._cache = _KernelCache(function)
        return dispatcher

    return compiled
