"""The bar over frames or tiles, and how Ctrl-C ends a command between them."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from types import FrameType
from typing import Any

import click


class Stop:
    """Handler of Ctrl-C and of the request to end.

    It raises, which unwinds the writer, and it remembers: an exception that a callback of a C library
    swallowed is raised again before the next frame. Inside the compiler of the kernels it only remembers, because
    an exception in its callbacks would end the process there and then.
    """

    def __init__(self) -> None:
        self.signal = 0

    def __call__(self, number: int, frame: FrameType | None) -> None:
        """Take a signal."""
        self.signal = number
        while frame is not None:
            if "llvmlite" in frame.f_code.co_filename:
                return
            frame = frame.f_back
        raise KeyboardInterrupt

    def check(self) -> None:
        """Raise if a signal came."""
        if self.signal:
            raise KeyboardInterrupt


def progress(stop: Stop, frames: Iterable[Any], count: int, label: str = "computing") -> Iterator[Any]:
    """Show a bar on a terminal, stay quiet in a pipe, and end between frames when asked to."""
    if not sys.stderr.isatty():
        for frame in frames:
            stop.check()
            yield frame
        return
    with click.progressbar(frames, length=count, label=label, file=sys.stderr, show_pos=True) as bar:
        for frame in bar:
            stop.check()
            yield frame
