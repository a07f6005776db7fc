"""Files that commands write: what would go wrong is found out before the work, and they appear when they are whole.

The bar over frames or tiles, and how Ctrl-C ends a command between them.

The scenario and its changes on the command line, the same for all commands that take one.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from types import FrameType
from typing import Any

import click


def require_writable(paths: Iterable[Path | None], force: bool, remedy: str = "give another name") -> None:
    """Refuse to begin where a result could not be written.

    Parameters
    ----------
    paths : iterable of Path or None
        None: not asked for.
    force : bool
        Existing files may be replaced.
    remedy : str
        What to do about an existing one, beside ``--force``.

    Raises
    ------
    click.ClickException
        If a file exists, or its folder does not.
    """
    for path in paths:
        if path is None:
            continue
        if path.exists() and not force:
            raise click.ClickException(f"{path} exists; {remedy}, or --force")
        folder = path.absolute().parent
        if not folder.is_dir():
            raise click.ClickException(f"cannot write {path}: there is no folder {folder}")


def write_text(path: Path, text: str) -> None:
    """Write a line or more; raises HcssError if it cannot be written."""
    from hcss_twin.core.errors import HcssError
    from hcss_twin.core.files import atomic_write

    with atomic_write(path, HcssError) as draft:
        draft.write_text(text + "\n", encoding="utf-8")


def require_two_files(given: Mapping[str, Path | None]) -> None:
    """Refuse one file under two options.

    Parameters
    ----------
    given : mapping of str to Path or None
        By the name of the option; None: not asked for.

    Raises
    ------
    click.UsageError
        Naming both options.
    """
    seen: dict[Path, str] = {}
    for option, path in given.items():
        if path is None:
            continue
        if path.absolute() in seen:
            raise click.UsageError(f"{seen[path.absolute()]} and {option} are both {path}; allowed: two files")
        seen[path.absolute()] = option


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


def set_option(command: Any) -> Any:
    """Add ``--set``, which may be given again and again."""
    return click.option(
        "--set", "assignments", multiple=True, metavar="KEY=VALUE", help="Replace one key, for example view.zenith=40."
    )(command)


def scenario_options(command: Any) -> Any:
    """Add the scenario and ``--set``."""
    return click.argument("scenario")(set_option(command))


def load(scenario: str, assignments: Iterable[str]) -> Any:
    """Read a scenario with its changes; raises ScenarioError and click's BadParameter."""
    from hcss_twin.scenario.overrides import parse_assignment
    from hcss_twin.scenario.scenario import Scenario

    try:
        overrides = dict(parse_assignment(text) for text in assignments)
    except ValueError as error:
        raise click.BadParameter(str(error), param_hint="--set") from error
    return Scenario.load(scenario, overrides)
