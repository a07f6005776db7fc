"""The software environment: versions of the libraries, and compilation of kernels."""

from __future__ import annotations

import os
import platform
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from importlib import metadata
from itertools import count
from typing import Any

__all__ = ["announce_compilation"]

LIBRARIES = ("numpy", "numba", "scipy", "xarray", "netCDF4", "pvlib", "pydantic", "pluggy")


def versions() -> dict[str, str]:
    """Return the versions of this package, of Python and of the libraries that affect the numbers."""
    result = {"hcss-twin": _loaded("hcss-twin"), "python": platform.python_version()}
    result.update((name, _loaded(name)) for name in LIBRARIES)
    return result


def installed_version(distribution: str) -> str:
    """Return the version of a distribution, or ``not installed``."""
    try:
        return metadata.version(distribution)
    except metadata.PackageNotFoundError:
        return "not installed"


@cache
def _loaded(distribution: str) -> str:
    """Return the loaded version, even if another is installed later; reading it takes a millisecond."""
    return installed_version(distribution)


COMPILING = "compiling kernels that are kept for later runs (up to half a minute) ..."
COMPILING_EACH_TIME = (
    "compiling kernels (up to half a minute), in each process, because no folder for them may be written; set "
    "NUMBA_CACHE_DIR to one that may ..."
)


@cache
def _compilations() -> Iterator[int]:
    """Numbers of the compilations of this process, from 0."""
    return count()


def _is_first_compilation() -> bool:
    return next(_compilations()) == 0


@contextmanager
def announce_compilation(report: Callable[[str], object]) -> Iterator[None]:
    """Call ``report`` with one line when this process compiles its first kernel of this package, if in this block.

    Otherwise a user would take the pause for a hang. The compiler itself triggers the message, so it appears only for
    kernels that are missing from its cache or were compiled for another version or processor.
    """
    from numba.core import event

    process = os.getpid()  # copies of it, which compile meanwhile, say nothing

    class Listener(event.Listener):  # type: ignore[misc]  # numba has no types
        def on_start(self, event: Any) -> None:
            dispatcher = event.data["dispatcher"]
            module = dispatcher.py_func.__module__
            if (
                os.getpid() == process
                and module.partition(".")[0] == __name__.partition(".")[0]
                and _is_first_compilation()
            ):
                report(COMPILING if dispatcher.stats.cache_path else COMPILING_EACH_TIME)

        def on_end(self, event: Any) -> None:
            pass

    with event.install_listener("numba:compile", Listener()):
        yield
