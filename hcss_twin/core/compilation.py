"""Telling that kernels are compiled, which a run on a machine does for those that no run before it has needed.

A first scene needs most of them; one with waves, two layers or a sensor needs others, and so does another type of
number.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

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
