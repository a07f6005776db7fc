"""Common parts of commands: options, the scenario and its changes, output files, and interruption."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from types import FrameType
from typing import Any

import click

from hcss_twin.core.files import is_device


class _Existing(click.Path):
    """A file or folder, where click allows pipes, sockets and devices, too."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        path: Any = super().convert(value, param, ctx)
        if is_device(path):
            self.fail(f"'{path}' is a pipe, socket or device; allowed: on disk", param, ctx)
        return path


EXISTING = _Existing(exists=True, path_type=Path)
EXISTING_FILE = _Existing(exists=True, dir_okay=False, path_type=Path)
EXISTING_FOLDER = _Existing(exists=True, file_okay=False, path_type=Path)
NEW = click.Path(path_type=Path)
NEW_FILE = click.Path(dir_okay=False, path_type=Path)
FOLDER = click.Path(file_okay=False, path_type=Path)

json_option = click.option("--json", "as_json", is_flag=True, help="Print the result as JSON.")
force_option = click.option("--force", is_flag=True, help="Replace existing files.")
json_file_option = click.option(
    "--json",
    "json_file",
    type=click.Path(dir_okay=False, allow_dash=True, path_type=Path),
    help="JSON file for all numbers; - prints them instead of the table.",
)
set_option = click.option(
    "--set", "assignments", multiple=True, metavar="KEY=VALUE", help="Change a key, for example view.zenith=40; repeat."
)


def scenario_options(command: Any) -> Any:
    """Add the arguments SCENARIO and ``--set``."""
    return click.argument("scenario")(set_option(command))


def assigned(texts: Iterable[str], option: str = "--set") -> dict[str, Any]:
    """Parse KEY=VALUE values of an option; raises click's BadParameter."""
    from hcss_twin.scenario.overrides import parse_assignment

    try:
        return dict(parse_assignment(text) for text in texts)
    except ValueError as error:
        raise click.BadParameter(str(error), param_hint=option) from error


def load(scenario: str, assignments: Iterable[str]) -> Any:
    """Read a scenario with its changes, and print what they remove; raises ScenarioError and click's BadParameter."""
    from hcss_twin.scenario.scenario import Scenario

    loaded = Scenario.load(scenario, assigned(assignments))
    for note in loaded.notes:
        click.echo(f"note: {note}", err=True)
    return loaded


def metres(_context: click.Context, _option: click.Parameter, text: str | None) -> float | None:
    """Read a length such as ``1 km``; a plain number is in metres."""
    if text is None:
        return None
    from pydantic_core import PydanticCustomError

    from hcss_twin.scenario.units import parse_quantity

    try:
        size = parse_quantity(text, "length")
    except PydanticCustomError as error:
        raise click.BadParameter(error.message()) from error
    if not isinstance(size, float) or not 0.0 < size < float("inf"):
        raise click.BadParameter(f"{text} given, allowed: greater than 0")
    return size


def require_writable(paths: Iterable[Path | None], force: bool, remedy: str = "give another name with -o") -> None:
    """Check before the computation that results can be written; None means no file.

    Raises
    ------
    click.ClickException
        If a file exists without ``force`` (``remedy`` is the alternative), or its folder does not exist.
    """
    from hcss_twin.core.files import is_device

    for path in paths:
        if path is None:
            continue
        if path.exists() and not force:
            raise click.ClickException(f"{path} exists; {remedy}, or --force")
        if is_device(path):
            raise click.ClickException(f"cannot write {path}: it is a device, pipe or socket; {remedy}")
        folder = path.absolute().parent
        if not folder.is_dir():
            raise click.ClickException(f"cannot write {path}: there is no folder {folder}")


def require_two_files(given: Mapping[str, Path | None]) -> None:
    """Raise UsageError if two options name the same file.

    Parameters
    ----------
    given : mapping of str to Path or None
        By the name of the option.
    """
    seen: dict[Path, str] = {}
    for option, path in given.items():
        if path is None:
            continue
        if path.absolute() in seen:
            raise click.UsageError(f"{seen[path.absolute()]} and {option} are both {path}; allowed: different files")
        seen[path.absolute()] = option


def write_text(path: Path, text: str) -> None:
    """Write a text file; raises HcssError if it cannot be written."""
    from hcss_twin.core.errors import HcssError
    from hcss_twin.core.files import atomic_write

    with atomic_write(path, HcssError) as draft:
        draft.write_text(text + "\n", encoding="utf-8")


def with_size(path: Path) -> str:
    """Return the name and size of a file."""
    return f"{path}  {path.stat().st_size / 1e6:.1f} MB"


_IMPORT_CALLBACK = ("cb", "<frozen importlib._bootstrap>")
"""Called for weak references when a module's lock ends."""


class Stop:
    """Handler of SIGINT and SIGTERM.

    It raises an exception, which unwinds the writer, and records the signal: an exception swallowed by a C library
    callback is raised again before the next frame. Within the kernel compiler and the callbacks of imports it only
    records the signal: an exception would abort the process in the former, and be printed and ignored in the latter.
    """

    def __init__(self) -> None:
        self.signal = 0

    def __call__(self, number: int, frame: FrameType | None) -> None:
        """Handle a signal."""
        self.signal = number
        while frame is not None:
            code = frame.f_code
            if "llvmlite" in code.co_filename or (code.co_name, code.co_filename) == _IMPORT_CALLBACK:
                return
            frame = frame.f_back
        raise KeyboardInterrupt

    def check(self) -> None:
        """Raise KeyboardInterrupt if a signal was received."""
        if self.signal:
            raise KeyboardInterrupt


def progress(stop: Stop, frames: Iterable[Any], count: int, label: str = "computing") -> Iterator[Any]:
    """Show a progress bar if stderr is a terminal, and stop between frames after a signal."""
    if not sys.stderr.isatty():
        for frame in frames:
            stop.check()
            yield frame
        return
    with click.progressbar(frames, length=count, label=label, file=sys.stderr, show_pos=True) as bar:
        for frame in bar:
            stop.check()
            yield frame
