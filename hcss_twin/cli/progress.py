"""Progress of a run: bars with the time left on a terminal, by ``rich``; plain lines in logs, if a run takes long.

Nothing of ``rich`` is imported unless a bar is shown.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, TypeVar

import click

from hcss_twin.core.stages import Stage, watched

if TYPE_CHECKING:
    from rich.progress import TaskID

_T = TypeVar("_T")

LONG_S = 10.0
"""Stages of which a log tells, and the time between two lines about one."""


class Progress:
    """Shows the stages of a run.

    Parameters
    ----------
    check : callable
        Raises KeyboardInterrupt after a signal; called between frames.
    expected : mapping of Stage to float, optional
        What stages take that begin before more is known, s.
    """

    def __init__(self, check: Callable[[], None], expected: Mapping[Stage, float] | None = None) -> None:
        self._check = check
        self._expected = expected or {}

    def expect(self, seconds: Mapping[Stage, float]) -> None:
        """Take what stages are predicted to take, once it is known."""
        self._expected = seconds

    def begin(self, stage: Stage) -> None:
        """A stage begins."""

    def end(self, stage: Stage) -> None:
        """It ends."""

    def each(self, items: Iterable[_T], count: int) -> Iterator[_T]:
        """Yield items, which are frames, or tiles of large ones."""
        for item in items:
            self._check()
            yield item


class LoggedProgress(Progress):
    """Plain lines for stages that take long."""

    def expect(self, seconds: Mapping[Stage, float]) -> None:
        """Tell once how long the run takes, if it is long."""
        super().expect(seconds)
        if (total := sum(seconds.values())) >= LONG_S:
            parts = ", ".join(f"{name} {_time(taken)}" for name, taken in seconds.items() if taken >= 0.05 * total)
            click.echo(f"about {_time(total)}: {parts}", err=True)

    def begin(self, stage: Stage) -> None:
        """Tell of a long stage."""
        if (expected := self._expected.get(stage, 0.0)) >= LONG_S:
            click.echo(f"{stage}: about {_time(expected)}", err=True)

    def each(self, items: Iterable[_T], count: int) -> Iterator[_T]:
        """Tell how many frames are computed, and the time left."""
        began = told = time.monotonic()
        for number, item in enumerate(super().each(items, count)):
            yield item
            now = time.monotonic()
            if now - told >= LONG_S and number + 1 < count:
                left = (now - began) / (number + 1) * (count - number - 1)
                click.echo(f"{number + 1} of {count}, about {_time(left)} left", err=True)
                told = now


class BarProgress(Progress):
    """A bar for each stage, which vanishes at the end."""

    def __init__(self, check: Callable[[], None], expected: Mapping[Stage, float] | None = None) -> None:
        super().__init__(check, expected)
        from rich.console import Console
        from rich.progress import BarColumn, ProgressColumn, Task, TextColumn
        from rich.progress import Progress as Bars
        from rich.text import Text

        class Left(ProgressColumn):
            """Time left: of the frames, or of what the stage is predicted to take."""

            def render(self, task: Task) -> Text:
                expected = task.fields["expected"]
                left = task.time_remaining if task.total else expected and pace() * expected - (task.elapsed or 0.0)
                if task.finished:
                    return Text(_time(task.finished_time or 0.0))
                if left is None:
                    return Text(f"{task.elapsed or 0.0:.0f} s")
                return Text(f"about {_time(left)} left" if left > 0.0 else "longer than predicted")

        began, began_processor = time.monotonic(), time.process_time()

        def pace() -> float:
            """Return the time that passes in a second of processor time: what is predicted, on a busy machine."""
            used = time.process_time() - began_processor
            return max((time.monotonic() - began) / used, 1.0) if used > 1.0 else 1.0

        columns = TextColumn("{task.description:<12}"), BarColumn(), TextColumn("{task.fields[count]}"), Left()
        self.bars = Bars(*columns, console=Console(stderr=True), transient=True)
        self._task: TaskID | None = None

    def begin(self, stage: Stage) -> None:
        """Add a bar without a length."""
        self._task = self.bars.add_task(stage, total=None, expected=self._expected.get(stage), count="")

    def end(self, stage: Stage) -> None:
        """Fill the bar."""
        if self._task is not None:
            self.bars.update(self._task, total=1.0, completed=1.0)

    def each(self, items: Iterable[_T], count: int) -> Iterator[_T]:
        """Fill the bar of the stage with the frames."""
        task = self._task
        for number, item in enumerate(super().each(items, count)):
            yield item
            if task is not None:
                self.bars.update(task, total=count, completed=number + 1, count=f"{number + 1} of {count}")


@contextmanager
def shown_progress(
    check: Callable[[], None], quiet: bool = False, expected: Mapping[Stage, float] | None = None
) -> Iterator[Progress]:
    """Show the stages of what is computed in the block: on a terminal, in a log, or not at all."""
    if quiet:
        progress = Progress(check)
        yield progress
        return
    if not sys.stderr.isatty():
        progress = LoggedProgress(check, expected)
        with watched(progress):
            yield progress
        return
    bars = BarProgress(check, expected)
    with bars.bars, watched(bars):
        yield bars


def _time(seconds: float) -> str:
    if seconds < 1.0:
        return f"{seconds:.1f} s"
    return f"{seconds:.0f} s" if seconds < 120.0 else f"{seconds / 60.0:.0f} min"
