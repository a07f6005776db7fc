"""The software environment: versions of the libraries, and compilation of kernels."""

from __future__ import annotations

import platform
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from importlib import metadata
from typing import Any

LIBRARIES = ("numpy", "numba", "scipy", "xarray", "netCDF4", "pvlib", "pydantic", "pluggy")


def versions() -> dict[str, str]:
    """Return the versions of this package, of Python and of the libraries that have a share in the numbers."""
    found = {"hcss-twin": _loaded("hcss-twin"), "python": platform.python_version()}
    found.update((name, _loaded(name)) for name in LIBRARIES)
    return found


def installed_version(distribution: str) -> str:
    """Return the version of a distribution, or ``not installed``."""
    try:
        return metadata.version(distribution)
    except metadata.PackageNotFoundError:
        return "not installed"


@cache
def _loaded(distribution: str) -> str:
    """Version of what this process has loaded, whatever is installed later; reading it takes a millisecond."""
    return installed_version(distribution)


COMPILING = "compiling kernels that no run on this machine needed before, to be kept (up to half a minute) ..."


@contextmanager
def announce_compilation(tell: Callable[[str], object]) -> Iterator[None]:
    """Call ``tell`` with one line when the first of our kernels is compiled in this block, and never otherwise.

    The compiler itself says so: kernels taken from its cache are none, whichever folder that is in, and those of a
    newer version or another processor are.
    """
    from numba.core import event

    class Listener(event.Listener):  # type: ignore[misc]  # numba has no types
        told = False

        def on_start(self, event: Any) -> None:
            module = event.data["dispatcher"].py_func.__module__
            if not self.told and module.partition(".")[0] == __name__.partition(".")[0]:
                self.told = True
                tell(COMPILING)

        def on_end(self, event: Any) -> None:
            pass

    with event.install_listener("numba:compile", Listener()):
        yield
