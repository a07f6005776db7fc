"""Compiled loops over pixels: numba's ``njit`` with the options and the cache of this package."""

from __future__ import annotations

import hashlib
import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import CodeType, FunctionType
from typing import Any

from numba import njit
from numba.core import environment, event
from numba.core.caching import FunctionCache
from numba.core.compiler_lock import global_compiler_lock
from numba.core.runtime import rtsys
from numpy import generic, ndarray

__all__ = ["kernel"]

COMPILES = "compiles kernels"
"""Name of a process of :func:`compiling_meanwhile`."""

LONGEST_S = 30.0
"""Time in which the kernels of clouds are compiled on a busy machine."""


class _KernelCache(FunctionCache):  # type: ignore[misc]  # numba has no types
    """Cache that loads machine code without the tables of the compiler.

    Numba prepares its compiler before it loads compiled code, which takes several tenths of a second, most of it for
    scipy.linalg. Compiled code needs only the memory management; the compiler prepares itself when it is needed.
    """

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        rtsys.initialize(target_context)
        with _without_modules(), self._guard_against_spurious_io_errors():
            return self._load_overload(sig, target_context)

    def _index_key(self, sig: Any, codegen: Any) -> tuple[Any, ...]:
        """Return numba's key, which knows the file of the kernel only, with what is compiled into it from others."""
        used = hashlib.sha256("\n".join(_compiled_in(self._py_func, [])).encode()).hexdigest()
        return (*super()._index_key(sig, codegen), used)


def _compiled_in(function: Any, known: list[Any]) -> Iterator[str]:
    """Yield constants and code that a function takes from globals, those of the functions that it calls included."""
    known.append(function)
    codes = [function.__code__]
    for code in codes:  # that of comprehensions, too, whose representation has an address
        codes += [each for each in code.co_consts if isinstance(each, CodeType)]
        yield code.co_code.hex() + repr([each for each in code.co_consts if not isinstance(each, CodeType)])
        for name in code.co_names:
            value = function.__globals__.get(name)
            value = getattr(value, "py_func", value)
            if isinstance(value, FunctionType) and value not in known:
                yield from _compiled_in(value, known)
            elif isinstance(value, int | float | complex | str | tuple | generic):
                yield f"{name} = {value!r}"
            elif isinstance(value, ndarray):
                yield f"{name} = {value.dtype} {value.shape} {value.tobytes().hex()}"


@contextmanager
def _without_modules() -> Iterator[None]:
    """Load compiled code without importing the modules that define its functions.

    Numba imports them (its own array functions take 60 ms) for code that looks up globals at run time; compiled loops
    never do.
    """
    rebuild = environment._rebuild_env
    environment._rebuild_env = _environment
    try:
        yield
    finally:
        environment._rebuild_env = rebuild


def _environment(module: str, constants: list[Any], name: str) -> Any:
    known = environment.lookup_environment(name)
    if known is None:
        loaded = sys.modules.get(module)
        known = environment.Environment({"__name__": module} if loaded is None else vars(loaded))
        known.consts[:] = constants
        known.env_name = name
        environment.Environment._memo[name] = known
    return known


def kernel(*, inner: bool = False, **options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Compile a function at its first call on a machine; it releases the interpreter's lock while it runs.

    Divisions by zero are not looked for (as in numpy): numba compiles its own functions, such as ``empty``, once for
    each way of treating them.

    Parameters
    ----------
    inner : bool
        Whether only kernels call the function: the wrapper for the interpreter, which may take as long to compile as
        the function, is left out, and a call by the interpreter would end the process.
    **options
        More options of :func:`numba.njit`.
    """

    def compiled(function: Callable[..., Any]) -> Any:
        without = {"no_cfunc_wrapper": True, "no_cpython_wrapper": inner, "error_model": "numpy"}
        dispatcher: Any = njit(nogil=True, **without, **options)(function)
        private = hasattr(FunctionCache, "_load_overload") and hasattr(environment, "_rebuild_env")
        with suppress(RuntimeError):  # no folder may be written: each process compiles
            if private:
                dispatcher._cache = _KernelCache(function)
            else:  # a version of numba with another cache
                dispatcher.enable_caching()
        return dispatcher

    return compiled


def kernels_folder() -> str:
    """Return where compiled kernels are kept; empty if no folder may be written, so that each process compiles."""
    return str(kernel()(_silently).stats.cache_path or "")


@contextmanager
def compiling_meanwhile(work: Callable[[], object]) -> Iterator[None]:
    """Let a copy of this process do ``work`` as soon as the block compiles a kernel, to compile those of ``work``, too.

    Only its kernels matter, which are kept in numba's cache; :func:`wait_for_kernels` waits for them. Where a process
    cannot be copied, or all kernels of the block are compiled, nothing happens.
    """
    with event.install_listener("numba:compile", _FirstCompilation(work)):
        yield


class _FirstCompilation(event.Listener):  # type: ignore[misc]  # numba has no types
    """Starts the copy. A class in a function would keep ``work``, and so a whole scene, until garbage is collected."""

    def __init__(self, work: Callable[[], object]) -> None:
        self._work, self._is_first = work, True

    def on_start(self, event: Any) -> None:
        from hcss_twin.core.processes import can_copy, start_copy

        if self._is_first and can_copy():
            with suppress(OSError):  # no more processes
                start_copy(_silently, self._work).name = COMPILES
        self._is_first = False

    def on_end(self, event: Any) -> None:
        pass


def _silently(work: Callable[[], object]) -> None:
    """Do ``work`` in a copy; the original will meet its errors and warnings itself."""
    # The copy never goes on with what the original was compiling, and its threads need the lock.
    while global_compiler_lock.is_locked():
        global_compiler_lock.release()
    warnings.simplefilter("ignore")
    with suppress(Exception):
        work()


def wait_for_kernels() -> None:
    """Wait for the process that :func:`compiling_meanwhile` has started, unless it takes longer than to compile."""
    started = sys.modules.get("multiprocessing")
    for process in started.active_children() if started else ():
        if process.name == COMPILES:
            process.join(LONGEST_S)
            process.terminate()
