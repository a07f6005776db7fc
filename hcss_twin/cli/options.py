"""Common parts of commands: options, the scenario and its changes, output files, and interruption."""

from __future__ import annotations

import contextlib
import json
import math
import os
import sys
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Any, TextIO

import click

from hcss_twin.core.files import is_device

if TYPE_CHECKING:
    from click.shell_completion import CompletionItem

    from hcss_twin.core.stages import StageTimes

__all__ = ["Existing", "Number", "Output", "Shared", "Stop"]


class Existing(click.Path):
    """A file or folder that exists, where click allows pipes, sockets and devices, too.

    Parameters
    ----------
    file_okay, dir_okay : bool
        Whether it may be a file, and a folder.
    """

    def __init__(self, file_okay: bool = True, dir_okay: bool = True) -> None:
        super().__init__(exists=True, file_okay=file_okay, dir_okay=dir_okay, path_type=Path)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Refuse them: a reader would wait for ever, or never find an end."""
        path: Any = super().convert(value, param, ctx)
        if is_device(path):
            self.fail(f"'{path}' is a pipe, socket or device; allowed: on disk", param, ctx)
        return path


class ScenarioName(click.types.StringParamType):
    """Name of a shipped scenario, or a TOML file."""

    @staticmethod
    def shipped() -> list[str]:
        """Return the names of the shipped scenarios."""
        from hcss_twin.core.catalog import Catalog

        return Catalog().names("scenarios", ".toml")

    def get_missing_message(self, param: click.Parameter, ctx: click.Context | None) -> str:
        """List the names, and say what to try first."""
        return (
            f"Name a shipped scenario ({', '.join(self.shipped())}), or a TOML file of your own; for example: "
            f"{ctx.command_path if ctx else 'hcss run'} trade-cumulus"
        )

    def shell_complete(self, ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
        """Return names that begin like what is typed; the shell adds files."""
        from click.shell_completion import CompletionItem

        names = [CompletionItem(name) for name in self.shipped() if name.startswith(incomplete)]
        return [*names, CompletionItem(incomplete, type="file")]


class Number(click.FloatRange):
    """Finite number within limits: of a number that is none, comparisons with limits say nothing."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Refuse nan and inf."""
        number = super().convert(value, param, ctx)
        if not math.isfinite(number):
            self.fail(f"{number} given; allowed: finite numbers", param, ctx)
        return number


class Output(click.Path):
    """Name of an output file.

    Parameters
    ----------
    dir_okay : bool
        Whether it may be that of a folder.
    allow_dash : bool
        Whether it may be a hyphen, for stdout.
    """

    def __init__(self, dir_okay: bool = True, allow_dash: bool = False) -> None:
        super().__init__(dir_okay=dir_okay, allow_dash=allow_dash, path_type=Path)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Refuse names of folders, which as a path lose their last slash, and a hyphen that is not stdout."""
        text = str(value)
        if text.endswith(("/", os.sep)) and not (
            self.dir_okay and (Path(text).is_dir() or text[:-1].endswith(".zarr"))
        ):
            self.fail(f"'{text}' given, a folder that does not exist; allowed: the name of a file", param, ctx)
        if text in ("", "-") and not (text and self.allow_dash):
            self.fail(f"'{text}' given; allowed: the name of a file", param, ctx)
        return super().convert(value, param, ctx)

    @staticmethod
    def require_writable(
        paths: Iterable[Path | None], force: bool, remedy: str = "give another name with -o", *, form: str
    ) -> None:
        """Check before the computation that results can be written; None means no file.

        Parameters
        ----------
        paths : iterable of Path or None
            The outputs.
        force : bool
            Whether existing files may be replaced; files that the command reads never are.
        remedy : str
            Alternative to ``force``, for the message.
        form : str
            What is written, of ``core.files.FORMS``.

        Raises
        ------
        click.ClickException, CubeError
            If a file exists without ``force``, its name or its folder does not do, or it is read by the command.
        """
        from hcss_twin.core.errors import CubeError
        from hcss_twin.core.files import Writing, require_not_read

        for path in paths:
            if path is None:
                continue
            is_store = form == "Zarr"  # a folder; its writer knows which ones it may replace
            if not is_store:
                Writing(path, CubeError).check()
            if os.path.lexists(path) and not force:
                raise click.ClickException(f"{path} exists; {remedy}, or --force")
            require_not_read(path, _read_by_command(), CubeError)
            if not is_store:
                Writing(path, CubeError, form).check()
            folder = path.absolute().parent
            if not folder.is_dir():
                raise click.ClickException(f"cannot write {path}: there is no folder {folder}")
            if not os.access(folder, os.W_OK):
                raise click.ClickException(f"cannot write {path}: the folder {folder} is read-only")

    @staticmethod
    def require_different(given: Mapping[str, Path | None]) -> None:
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
                raise click.UsageError(
                    f"{seen[path.absolute()]} and {option} are both {path}; allowed: different files"
                )
            seen[path.absolute()] = option


_answers: TextIO | None = None
"""Where answers in JSON go while everything else that is printed goes to stderr."""


@contextlib.contextmanager
def only_answers() -> Iterator[None]:
    """Let :meth:`Shared.write_json` alone write to stdout: what plugins, libraries and workers print goes to stderr."""
    global _answers
    if _answers is not None:  # the outermost command has begun
        yield
        return
    given, kept = sys.stdout, None
    with contextlib.suppress(OSError, ValueError, AttributeError):  # stdout is no file, or closed
        given.flush()
        if given.fileno() == 1 and sys.stderr.fileno() == 2:
            kept = os.dup(1)  # libraries in C and processes of this one write to number 1
            os.dup2(2, 1)
    _answers = given if kept is None else os.fdopen(kept, "w", encoding="utf-8", errors="backslashreplace")
    sys.stdout = sys.stderr
    try:
        yield
    finally:
        _answers.flush()
        sys.stdout = given
        if kept is not None:
            os.dup2(kept, 1)
            _answers.close()
        _answers = None


def _answers_only(context: click.Context, _option: click.Parameter, value: Any) -> Any:
    """Keep stdout for the answer, if the option asks for one there."""
    if value is True or str(value) == "-":
        context.with_resource(only_answers())
    return value


def _indices(_context: click.Context, _option: click.Parameter, given: tuple[str, ...]) -> dict[str, int]:
    """Parse indices such as ``scene=3``."""
    found: dict[str, int] = {}
    for text in given:
        name, _, number = text.partition("=")
        if not name or not number.isdigit() or name in found:
            raise click.BadParameter(f"'{text}' given, allowed: each dimension once, with an index, such as scene=3")
        found[name] = int(number)
    return found


def _metres(_context: click.Context, _option: click.Parameter, text: str | None) -> float | None:
    """Read a length such as ``1 km``; a plain number is in metres."""
    from pydantic_core import PydanticCustomError

    from hcss_twin.core.units import QuantityParser

    if text is None:
        return None
    try:
        size = QuantityParser("length")(text)
    except PydanticCustomError as error:
        raise click.BadParameter(error.message()) from error
    if not isinstance(size, float) or not 0.0 < size < float("inf"):
        raise click.BadParameter(f"{text} given, allowed: greater than 0")
    return size


class Shared:
    """Options that mean the same in all commands, as decorators.

    Attributes
    ----------
    at
        ``--at DIMENSION=INDEX``, as the parameter ``at``: indices by dimension.
    changes
        ``--set KEY=VALUE``, as the parameter ``assignments``, which :meth:`load` takes.
    force
        ``--force``, which :meth:`Output.require_writable` takes.
    json
        ``--json``, as the parameter ``as_json``: the command prints nothing but its answer, with :meth:`write_json`.
    json_file
        ``--json FILE``, as the parameter ``json_file``, which may be ``-``.
    scenario
        The argument ``SCENARIO``, of which shells complete the names.
    """

    at = click.option(
        "--at",
        multiple=True,
        metavar="DIMENSION=INDEX",
        callback=_indices,
        help="Which image of a NetCDF variable with several, for example time=3, from 0; repeat for each dimension.",
    )
    changes = click.option(
        "--set",
        "assignments",
        multiple=True,
        metavar="KEY=VALUE",
        help="Change a key, for example view.zenith=40; repeat.",
    )
    force = click.option("--force", is_flag=True, help="Replace existing files.")
    json = click.option("--json", "as_json", is_flag=True, callback=_answers_only, help="Print the result as JSON.")
    json_file = click.option(
        "--json",
        "json_file",
        type=Output(dir_okay=False, allow_dash=True),
        callback=_answers_only,
        help="JSON file for all numbers; - prints them instead of the table.",
    )

    scenario = click.argument("scenario", type=ScenarioName())

    @staticmethod
    def length(*names: str, help: str) -> Any:
        """Return an option with these names that takes a length such as ``1 km``; plain numbers are in metres."""
        return click.option(*names, metavar="LENGTH", callback=_metres, help=help)

    @staticmethod
    def assigned(texts: Iterable[str], option: str = "--set") -> dict[str, Any]:
        """Parse KEY=VALUE values of an option; raises click's BadParameter."""
        from hcss_twin.scenario.overrides import parse_assignment

        try:
            return dict(parse_assignment(text) for text in texts)
        except ValueError as error:
            raise click.BadParameter(str(error), param_hint=option) from error

    @staticmethod
    def load(scenario: str, assignments: Iterable[str]) -> Any:
        """Read a scenario with its changes, and print what they remove; raises ScenarioError and BadParameter."""
        from hcss_twin.scenario.scenario import Scenario

        loaded = Scenario.load(scenario, Shared.assigned(assignments))
        for note in loaded.notes:
            click.echo(f"note: {note}", err=True)
        return loaded

    @staticmethod
    def write_json(value: Any, path: Path | None = None, indent: int | None = None) -> None:
        """Print the answer of a command as JSON, or write it to a file.

        Parameters
        ----------
        value
            Of numbers, texts, lists and dictionaries.
        path : Path, optional
            The file; None or ``-``: print it.
        indent : int, optional
            Spaces by which what is within something else is indented; default: all on one line.

        Raises
        ------
        HcssError
            If the file cannot be written.
        """
        text = json.dumps(value, indent=indent)
        if path is None or str(path) == "-":
            click.echo(text, file=_answers)
            return
        from hcss_twin.core.errors import HcssError
        from hcss_twin.core.files import Writing

        with Writing(path, HcssError, "JSON") as draft:
            draft.write_text(text + "\n", encoding="utf-8")


def scenario_options(command: Any) -> Any:
    """Add the arguments SCENARIO and ``--set``."""
    return Shared.scenario(Shared.changes(command))


def _read_by_command() -> Iterator[Path]:
    """Yield the files and folders among the arguments and options of the running command, except its outputs."""
    context = click.get_current_context()
    for parameter in context.command.params:
        given = None if isinstance(parameter.type, Output) else context.params.get(parameter.name or "")
        for argument in given if isinstance(given, tuple) else (given,):
            if isinstance(argument, str | Path) and len(str(argument)) < 255 and Path(argument).exists():
                yield Path(argument)


class Announcement:
    """Prints that kernels are compiled, and remembers it: such a run says nothing of the time of others."""

    made = False

    def __call__(self, text: str) -> None:
        """Print it."""
        self.made = True
        click.echo(text, err=True)


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

    def __init__(self, is_process: bool = False) -> None:
        self.signal = 0
        self._is_process = is_process

    def comparable(self, times: StageTimes) -> StageTimes:
        """Return times of stages that say something of the machine: start and planning only of a process for it."""
        return times if self._is_process else times.without_start()

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

    def progress(self, frames: Iterable[Any], count: int, label: str = "computing") -> Iterator[Any]:
        """Show a progress bar on a terminal, or lines in a log if it takes long; stop between frames after a signal."""
        if not sys.stderr.isatty():
            from hcss_twin.cli.progress import LoggedProgress

            yield from LoggedProgress(self.check).each(frames, count)
            return
        with click.progressbar(frames, length=count, label=label, file=sys.stderr, show_pos=True) as bar:
            for frame in bar:
                self.check()
                yield frame
