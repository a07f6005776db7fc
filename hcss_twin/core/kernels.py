"""Compiled loops over pixels: numba's ``njit`` with the options and the cache of this package."""

from __future__ import annotations

import hashlib
import os
import stat
import sys
import time
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from importlib import import_module
from mmap import mmap
from types import CodeType, FunctionType
from typing import TYPE_CHECKING, Any, NamedTuple

from numba import njit
from numba.core import environment, event, sigutils
from numba.core.caching import FunctionCache
from numba.core.compiler_lock import global_compiler_lock
from numba.core.runtime import rtsys
from numpy import generic, ndarray

if TYPE_CHECKING:
    from multiprocessing.process import BaseProcess

__all__ = ["kernel"]

MOST_COPIES = 2
"""Copies of a process that compile; more would wait for the largest kernel."""


class _KernelCache(FunctionCache):  # type: ignore[misc]  # numba has no types
    """Cache that loads machine code without the tables of the compiler.

    Numba prepares its compiler before it loads compiled code, which takes several tenths of a second, most of it for
    scipy.linalg. Compiled code needs only the memory management; the compiler prepares itself when it is needed.
    """

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        rtsys.initialize(target_context)
        found = self._kept(sig, target_context)
        if found is None and _copies is not None and _copies.compiled(self._py_func):
            found = self._kept(sig, target_context)  # none, if the copy compiled it for other arguments
        return found

    def _kept(self, sig: Any, target_context: Any) -> Any:
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
    return str(kernel()(_compile_all).stats.cache_path or "")


class Ahead(NamedTuple):
    """A kernel that a process compiles before it is called.

    Attributes
    ----------
    module, function : str
        Where it is.
    types : str
        Types of its arguments, as numba's signatures have them.
    seconds : float
        What the compilation takes, with that of the kernels that it calls.
    """

    module: str
    function: str
    types: str
    seconds: float

    def compile(self) -> None:
        """Compile it, unless it is in the cache."""
        arguments, _ = sigutils.normalize_signature(f"void({self.types})")
        self._dispatcher.compile(arguments)

    @property
    def is_kept(self) -> bool:
        """Whether it is compiled, in this process or for some arguments in the cache."""
        dispatcher = self._dispatcher
        kept = getattr(dispatcher._cache, "_cache_file", None)
        return bool(dispatcher.overloads or (kept is not None and kept._load_index()))

    @property
    def _dispatcher(self) -> Any:
        return getattr(import_module(self.module), self.function)


_FREE, _TAKEN, _AWAITED, _DONE = range(4)
"""A kernel is compiled by nobody yet, by this process, by a copy of it, or in the cache."""


class _Copies:
    """Copies of this process that compile kernels, and which of them each one compiles."""

    def __init__(self, kernels: Sequence[Ahead], count: int, begun: Any) -> None:
        from hcss_twin.core.processes import start_copy

        self._kernels = kernels
        self._number = {(each.module, each.function): number for number, each in enumerate(kernels)}
        self._state = mmap(-1, max(len(kernels), 1))  # memory that copies share
        self._take(begun)
        self._started: list[BaseProcess] = []
        with suppress(OSError):  # no more processes
            for _ in range(count):
                self._started.append(start_copy(_compile_all, kernels, self._state))

    def _take(self, function: Any) -> int | None:
        """Let copies leave a function to this process, unless one has begun; return its number."""
        number = self._number.get((function.__module__, function.__qualname__))
        if number is not None and self._state[number] == _FREE:
            self._state[number] = _TAKEN
        return number

    def compiled(self, function: Any) -> bool:
        """Whether a copy has compiled a function, which is awaited if it is about to; if not, none will.

        Meanwhile this process compiles others.
        """
        number = self._take(function)
        if number is None:
            return False
        while self._state[number] == _AWAITED and self.is_alive():
            other = self._state.find(bytes([_FREE]))
            if other < 0:
                time.sleep(0.01)
            else:
                self._state[other] = _TAKEN
                with suppress(Exception):  # its caller will meet it
                    self._kernels[other].compile()
        return self._state[number] == _DONE

    def is_alive(self) -> bool:
        """Whether any copy still compiles."""
        return any(process.is_alive() for process in self._started)

    def end(self) -> None:
        """End the copies without waiting for their work."""
        for process in self._started:
            process.terminate()
            process.join()


_copies: _Copies | None = None
"""The copies of this process."""


def _compile_all(kernels: Sequence[Ahead], state: mmap) -> None:
    """Compile kernels in a copy; the original will meet errors and warnings itself."""
    _close_files()
    # The copy never goes on with what the original was compiling, and its threads need the lock.
    while global_compiler_lock.is_locked():
        global_compiler_lock.release()
    warnings.simplefilter("ignore")
    for number, each in enumerate(kernels):
        if state[number] != _FREE:
            continue
        state[number] = _AWAITED
        try:
            each.compile()
            state[number] = _DONE
        except Exception:
            state[number] = _TAKEN


def _close_files() -> None:
    """Close the files that the original has open: HDF5 locks a file until every process that has it has closed it."""
    for number in map(int, os.listdir("/proc/self/fd")):
        with suppress(OSError):  # what listed them
            if number > 2 and stat.S_ISREG(os.fstat(number).st_mode):
                os.close(number)


class _FirstCompilation(event.Listener):  # type: ignore[misc]  # numba has no types
    """Starts the copies when the first kernel is compiled."""

    def __init__(self, listed: Callable[[], Sequence[Ahead]]) -> None:
        self._listed, self._is_first = listed, True

    def on_start(self, event: Any) -> None:
        from hcss_twin.core.processes import can_copy

        global _copies
        count = min(MOST_COPIES, len(os.sched_getaffinity(0)) - 1) if self._is_first and can_copy() else 0
        self._is_first = False
        if count and _copies is None and kernels_folder():
            _copies = _Copies(self._listed(), count, event.data["dispatcher"].py_func)

    def on_end(self, event: Any) -> None:
        pass


@contextmanager
def compiling_meanwhile(listed: Callable[[], Sequence[Ahead]]) -> Iterator[None]:
    """Let copies of this process compile kernels as soon as the block compiles its first one.

    They hand them over in numba's cache: what a copy is about to compile, the block waits for. Where a process cannot
    be copied, no folder may be written, no other processor is free, or all kernels of the block are compiled, nothing
    happens. The copies end with the block.

    Parameters
    ----------
    listed : callable
        Returns the kernels, in the order in which they are needed.
    """
    global _copies
    before = _copies
    try:
        with event.install_listener("numba:compile", _FirstCompilation(listed)):
            yield
    finally:
        if before is None and _copies is not None:
            _copies.end()
            _copies = None


def wait_for_kernels() -> None:
    """Wait for the copies of :func:`compiling_meanwhile`, so that other processes find the kernels."""
    while _copies is not None and _copies.is_alive():
        time.sleep(0.01)
