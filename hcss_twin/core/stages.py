"""Stages of a run, for whoever shows its progress or measures its time: the engine names them and knows no watcher."""

from __future__ import annotations

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
