"""Installed plugins: entry points of a group, read per distribution so that a broken one does not affect the others.

``hcss --help`` imports this module, so it uses the standard library only.
"""

from __future__ import annotations

import contextlib
import importlib.metadata
import re
import sys
import traceback
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, Literal

from hcss_twin.core.errors import HcssError, ProviderDefect

OWN_DISTRIBUTION = "hcss-twin"
"""Distribution that contains the default providers."""

FAILURES = (Exception, SystemExit)
"""Exceptions of a plugin that do not stop the program; a keyboard interrupt does."""


@dataclass(frozen=True)
class Origin:
    """Distribution of a plugin."""

    entry_point: str
    distribution: str
    version: str

    def __str__(self) -> str:
        return f"{self.distribution} {self.version}".strip()


@dataclass(frozen=True)
class PluginObject:
    """The object of an entry point."""

    origin: Origin
    entry_point: importlib.metadata.EntryPoint

    def load(self) -> Any:
        """Import the object."""
        return self.entry_point.load()


@dataclass(frozen=True)
class BrokenPlugin:
    """A plugin, or part of one, that cannot be used.

    Attributes
    ----------
    entry_point, distribution, version : str
        Origin of the plugin.
    error : str
        Cause, as text.
    offered : tuple of (Kind, str)
        Providers that it was to define, as far as known.
    cause : BaseException or None
        The original exception, for chaining.
    """

    entry_point: str
    distribution: str
    version: str
    error: str
    offered: tuple[tuple[str, str], ...] = ()
    cause: BaseException | None = field(default=None, compare=False, repr=False)

    def __str__(self) -> str:
        return f"{self.distribution} {self.version} (entry point '{self.entry_point}'): {self.error}"


@dataclass(frozen=True)
class Remark:
    """What ``hcss plugins`` says of a plugin that works.

    Attributes
    ----------
    topic : {"optional hook", "unknown hook", "slow import"}
        A hook that this version lacks, marked as optional or not, or an import above :data:`SLOW_IMPORT_S`.
    """

    origin: Origin
    topic: Literal["optional hook", "unknown hook", "slow import"]
    text: str

    def __str__(self) -> str:
        return f"{self.origin} (entry point '{self.origin.entry_point}'): {self.text}"


SLOW_IMPORT_S = 0.3
"""Seconds of an import of a plugin's hooks above which ``hcss plugins`` names it."""


def slow_import(origin: Origin, module: str, seconds: float) -> tuple[Remark, ...]:
    """Return a remark on an import that took too long."""
    if seconds <= SLOW_IMPORT_S:
        return ()
    text = (
        f"the import of '{module}' took {seconds:.1f} s, for which commands of hcss wait; allowed: {SLOW_IMPORT_S:g} "
        "s. The module with the hooks should import no other module of the plugin"
    )
    return (Remark(origin, "slow import", text),)


def describe(error: BaseException, where: str = "") -> str:
    """Describe an exception in one line.

    ``where``, the name of a module or object of the plugin, adds file and line in its package.
    """
    text = " ".join(str(error).split())
    named = f"{type(error).__name__}: {text}" if text else type(error).__name__
    return named + (place(error, package_of(where)) if where else "")


def place(error: BaseException, package: str) -> str:
    """Return file, line and function of the innermost call in a package, as an addition to a message, or nothing."""
    if isinstance(error, SyntaxError) and error.filename is not None:
        return f", at {error.filename}:{error.lineno}"
    found = ""
    for frame, line in traceback.walk_tb(error.__traceback__):
        if _package_of(frame.f_globals) == package:
            function = "" if frame.f_code.co_name == "<module>" else f" in {frame.f_code.co_name}()"
            found = f", at {frame.f_code.co_filename}:{line}{function}"
    return found


@contextlib.contextmanager
def naming_plugin(what: str, where: str) -> Iterator[None]:
    """Turn an accident in the code of a plugin into an error that names it, with file and line.

    Parameters
    ----------
    what : str
        Whose code runs, and which function.
    where : str
        Name of a module or object of the plugin.

    Raises
    ------
    ProviderDefect
    """
    try:
        yield
    except HcssError:
        raise
    except FAILURES as error:
        raise ProviderDefect(f"{what} raised {describe(error, where)}") from error


def plugin_at_fault(error: BaseException) -> str:
    """Return the distribution and version of the plugin that raised an error, with its file and line.

    Nothing if it was not a plugin: if, of the calls in this package and in plugins, the innermost is of this package.
    """
    plugins = {package_of(entry.value): origin for origin, entry in _all_entry_points()}
    own, innermost = package_of(__name__), ""
    plugins.pop(own, None)
    for frame, _ in traceback.walk_tb(error.__traceback__):
        package = _package_of(frame.f_globals)
        innermost = package if package == own or package in plugins else innermost
    return f"{plugins[innermost]}: {describe(error, innermost)}" if innermost in plugins else ""


def package_of(target: str) -> str:
    """Return the package of ``package.module:Object``, or of a module."""
    return target.partition(":")[0].partition(".")[0]


def _package_of(module: dict[str, Any]) -> str:
    return package_of(str(module.get("__name__", "")))


@contextlib.contextmanager
def prints_to_stderr() -> Iterator[None]:
    """Send to stderr what the import of a plugin prints: answers of commands are for other programs."""
    with contextlib.redirect_stdout(sys.stderr):
        yield


def normalised(distribution: str) -> str:
    """Return the normalised distribution name (PEP 503)."""
    return re.sub(r"[-_.]+", "-", distribution).lower()


def installed(group: str) -> Iterator[tuple[Origin, importlib.metadata.EntryPoint | BaseException]]:
    """Yield each entry point of a group, or the error raised while reading it.

    Distributions are read one by one, because a single malformed ``entry_points.txt`` makes
    ``importlib.metadata.entry_points()`` fail for all. If a distribution is on the path twice, the first is
    used, as for imports.
    """
    seen: set[str] = set()
    for distribution in importlib.metadata.distributions():
        try:
            text = distribution.read_text("entry_points.txt")
        except FAILURES:
            continue  # unreadable metadata of a package that may be unrelated
        if not text or group not in text:
            continue
        name, version = _identity(distribution)
        if normalised(name) in seen:
            continue
        seen.add(normalised(name))
        try:
            selected = sorted(distribution.entry_points.select(group=group), key=lambda entry_point: entry_point.name)
        except FAILURES as error:
            yield Origin("entry_points.txt", name, version), error
            continue
        for entry_point in selected:
            yield Origin(entry_point.name, name, version), entry_point


def _all_entry_points() -> Iterator[tuple[Origin, importlib.metadata.EntryPoint]]:
    """Yield the entry points of all groups of this package."""
    for distribution in importlib.metadata.distributions():
        with contextlib.suppress(*FAILURES):  # metadata of a package that may be unrelated
            for entry_point in distribution.entry_points:
                if re.fullmatch(r"hcss_twin(\..*)?", entry_point.group):
                    yield Origin(entry_point.name, *_identity(distribution)), entry_point


def _identity(distribution: importlib.metadata.Distribution) -> tuple[str, str]:
    try:
        metadata = distribution.metadata
        return str(metadata["Name"] or "unnamed-distribution"), str(metadata["Version"] or "(no version)")
    except FAILURES:
        return "unnamed-distribution", "(no version)"
