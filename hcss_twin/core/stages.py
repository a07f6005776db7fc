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

    Attributes
    ----------
    seconds : dict of Stage to float
    once_s : dict of Stage to float
        Of these, what made results that are in the user's cache now.
    start_s : float
        Start of the process, before planning; 0 if there was none.
    """

    def __init__(self) -> None:
        self.seconds = dict[Stage, float]()
        self.once_s = dict[Stage, float]()
        self.start_s = 0.0
        self._began = 0.0

    def begin(self, stage: Stage) -> None:
        """Remember the time."""
        self._began = _processor_s()
        if stage == "planning":
            self.start_s, self._began = self._began, 0.0

    def end(self, stage: Stage) -> None:
        """Add what the stage took."""
        self.seconds[stage] = self.seconds.get(stage, 0.0) + _processor_s() - self._began

    def without_start(self) -> StageTimes:
        """Return the times of the other stages, of a process that was not started for them."""
        others = StageTimes()
        others.seconds, others.once_s = dict(self.seconds), dict(self.once_s)
        others.seconds.pop("planning", None)
        return others


def _processor_s() -> float:
    of_all = os.times()
    return of_all.user + of_all.system + of_all.children_user + of_all.children_system


_watchers: ContextVar[tuple[Watcher, ...]] = ContextVar("watchers", default=())
_current: ContextVar[Stage | None] = ContextVar("current", default=None)
_once: ContextVar[bool] = ContextVar("once", default=False)


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


@contextmanager
def done_once() -> Iterator[None]:
    """Mark the block as work whose result stays in the user's cache; one within another is part of it."""
    current, outer = _current.get(), _once.get()
    token, began = _once.set(True), _processor_s()
    try:
        yield
    finally:
        _once.reset(token)
        if current is not None and not outer:
            for times in _watchers.get():
                if isinstance(times, StageTimes):
                    times.once_s[current] = times.once_s.get(current, 0.0) + _processor_s() - began


def time_text(seconds: float) -> str:
    """Return a time in words: two or more digits in seconds, from two minutes on minutes."""
    if seconds < 10.0:
        return f"{seconds:.1f} s"
    return f"{seconds:.0f} s" if seconds < 120.0 else f"{seconds / 60.0:.0f} min"
