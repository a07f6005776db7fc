"""Stages of a run, for whoever shows its progress or measures its time: the engine names them and knows no watcher."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Literal, Protocol

Stage = Literal["planning", "tables", "frames", "certificate", "sensor"]

STAGES: tuple[Stage, ...] = ("planning", "tables", "frames", "certificate", "sensor")
"""In the order of a run."""


class Watcher(Protocol):
    """Is told when a stage begins and ends."""

    def begin(self, stage: Stage) -> None:
        """A stage begins."""

    def end(self, stage: Stage) -> None:
        """It ends, also by an exception."""


class StageTimes:
    """A watcher that measures the processor time of each stage; planning includes the start of the process.

    Processes that this one has started and awaited count, too.
    """

    def __init__(self) -> None:
        self.seconds = dict[Stage, float]()
        self._began = 0.0

    def begin(self, stage: Stage) -> None:
        """Remember the time."""
        self._began = 0.0 if stage == "planning" else _processor_s()

    def end(self, stage: Stage) -> None:
        """Add what the stage took."""
        self.seconds[stage] = self.seconds.get(stage, 0.0) + _processor_s() - self._began


def _processor_s() -> float:
    of_all = os.times()
    return of_all.user + of_all.system + of_all.children_user + of_all.children_system


_watchers: ContextVar[tuple[Watcher, ...]] = ContextVar("watchers", default=())
_current: ContextVar[Stage | None] = ContextVar("current", default=None)


@contextmanager
def watched(watcher: Watcher) -> Iterator[None]:
    """Tell a watcher about the stages that begin in the block."""
    token = _watchers.set((*_watchers.get(), watcher))
    try:
        yield
    finally:
        _watchers.reset(token)


@contextmanager
def stage(name: Stage) -> Iterator[None]:
    """Mark the block as a stage; one within another is part of it, such as the planning of a sensor's surroundings."""
    watchers = _watchers.get() if _current.get() is None else ()
    token = _current.set(name) if watchers else None
    for watcher in watchers:
        watcher.begin(name)
    try:
        yield
    finally:
        for watcher in watchers:
            watcher.end(name)
        if token is not None:
            _current.reset(token)


def time_text(seconds: float) -> str:
    """Return a time in words: two or more digits in seconds, from two minutes on minutes."""
    if seconds < 10.0:
        return f"{seconds:.1f} s"
    return f"{seconds:.0f} s" if seconds < 120.0 else f"{seconds / 60.0:.0f} min"
