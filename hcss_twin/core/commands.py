"""Commands that plugins add to ``hcss``: the hook, and the listing of commands without importing their code.

A plugin names a module in the entry point group ``hcss_twin.commands``. The module has a function ``hcss_commands``,
marked with ``hookimpl``, and is imported when the commands are listed: it should import nothing but this module.
"""

from __future__ import annotations

import re
import sys
import time
from collections import defaultdict
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass
from importlib import import_module
from importlib.metadata import EntryPoint
from typing import Any, TypeVar

import pluggy

from hcss_twin.core.errors import HcssError, Problem, ProviderError, choose_from
from hcss_twin.core.plugins import (
    FAILURES,
    OWN_DISTRIBUTION,
    BrokenPlugin,
    Origin,
    Remark,
    describe,
    prints_to_stderr,
    slow_import,
)

PROJECT = "hcss_twin"
"""Project name shared by hook markers, plugin managers and entry point groups."""

GROUP = "hcss_twin.commands"

_Function = TypeVar("_Function", bound=Callable[..., Any])

hookspec: Callable[[_Function], _Function] = pluggy.HookspecMarker(PROJECT)
hookimpl = pluggy.HookimplMarker(PROJECT)
"""Decorator that marks a function of a plugin as the hook of the same name."""

_NAME = re.compile(r"[a-z0-9][a-z0-9-]*")
_TARGET = re.compile(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)*:[A-Za-z_]\w*", re.ASCII)


def check_name(name: object) -> None:
    """Raise ValueError unless a name consists of lower-case letters, digits and inner hyphens."""
    if not isinstance(name, str) or not _NAME.fullmatch(name):
        raise ValueError(f"name {name!r}: allowed are lower-case letters, digits, and inner hyphens")


def check_target(field: str, name: str, value: object) -> None:
    """Raise ValueError unless ``value`` looks like ``package.module:Object``."""
    if not isinstance(value, str) or not _TARGET.fullmatch(value):
        raise ValueError(f"{field} {value!r} of '{name}': must look like 'package.module:Class'")


def check_summary(name: str, summary: object) -> None:
    """Raise ValueError unless a summary is one line of text."""
    if not isinstance(summary, str) or not summary.strip() or "\n" in summary:
        raise ValueError(f"summary {summary!r} of '{name}': must be one line of text")


@dataclass(frozen=True)
class CommandSpec:
    """Name and location of one command.

    Attributes
    ----------
    name : str
        What users write after ``hcss``: lower-case letters, digits and hyphens; or a group of ``hcss`` and the command
        in it, such as ``atmosphere import``.
    target : str
        ``"package.module:object"`` of a :class:`click.Command`; imported only when the command is run.
    summary : str
        One line for ``hcss --help``.

    Raises
    ------
    ValueError
        If a field is malformed.
    """

    name: str
    target: str
    summary: str

    def __post_init__(self) -> None:
        for word in self.name.split(" ", 1) if isinstance(self.name, str) else [self.name]:
            check_name(word)
        check_target("target", self.name, self.target)
        check_summary(self.name, self.summary)


@hookspec
def hcss_commands() -> Sequence[CommandSpec]:
    """Return specs of commands for ``hcss``."""
    raise NotImplementedError


@dataclass(frozen=True)
class PluginCommand:
    """A command of a plugin."""

    spec: CommandSpec
    origin: Origin

    def load(self) -> Any:
        """Import the command.

        Raises
        ------
        HcssError
            If it cannot be imported or is not a click command.
        """
        import click

        module, _, name = self.spec.target.partition(":")
        label = f"command '{self.spec.name}' of {self.origin}"
        try:
            with prints_to_stderr():
                command = getattr(import_module(module), name)
        except FAILURES as error:
            raise HcssError(f"{label}: import of '{self.spec.target}' failed: {describe(error, module)}") from error
        if not isinstance(command, click.Command):
            raise HcssError(f"{label}: '{self.spec.target}' is {type(command).__name__}, allowed: a click.Command")
        return command


def collect(
    plugins: Iterable[tuple[Origin, EntryPoint | BaseException]], core: Collection[str], groups: Collection[str] = ()
) -> tuple[dict[str, PluginCommand], list[BrokenPlugin], list[Remark]]:
    """Return the commands of plugins by name, the unusable plugins, and remarks on slow imports.

    A command with a name of the core, or of two plugins, or in an unknown group, is rejected; the other commands of
    these plugins remain.

    Parameters
    ----------
    plugins : iterable of (Origin, EntryPoint or BaseException)
        As :func:`hcss_twin.core.plugins.installed` yields them for :data:`GROUP`.
    core : collection of str
        Names of the core's commands.
    groups : collection of str
        Names of the core's groups that plugins extend.
    """
    claims: dict[str, list[PluginCommand]] = defaultdict(list)
    broken: list[BrokenPlugin] = []
    remarks: list[Remark] = []

    def refuse(origin: Origin, error: str, cause: BaseException | None = None) -> None:
        broken.append(BrokenPlugin(origin.entry_point, origin.distribution, origin.version, error, (), cause))

    for origin, entry_point in plugins:
        try:
            if isinstance(entry_point, BaseException):
                raise entry_point
            begin = time.perf_counter()
            with prints_to_stderr():
                plugin = entry_point.load()
                found = _specs(plugin)
            remarks += slow_import(origin, entry_point.value, time.perf_counter() - begin)
            for spec in found:
                claims[spec.name].append(PluginCommand(spec, origin))
        except FAILURES as error:
            where = "" if isinstance(entry_point, BaseException) else entry_point.value
            refuse(origin, str(error) if isinstance(error, ProviderError) else describe(error, where), error)
    commands = {}
    for name, claimants in claims.items():
        group = name.rpartition(" ")[0]
        for command in claimants:
            if group and group not in groups:
                refuse(command.origin, f"command '{name}': no group '{group}'; {choose_from(group, groups)}")
                continue
            others = [str(claimant.origin) for claimant in claimants if claimant is not command]
            others = [OWN_DISTRIBUTION, *others] if name in core else others
            if others:
                refuse(command.origin, f"command '{name}' is also provided by {' and '.join(others)}")
            else:
                commands[name] = command
    return commands, broken, remarks


def _specs(plugin: Any) -> list[CommandSpec]:
    """Call the hook of one plugin; a separate manager prevents plugins from wrapping each other's hooks."""
    manager = pluggy.PluginManager(PROJECT)
    hook = hcss_commands.__name__
    manager.add_hookspecs(sys.modules[__name__])
    manager.register(plugin)
    if not manager.hook.hcss_commands.get_hookimpls():
        guess = Problem.closest(hook, [name for name in dir(plugin) if name.startswith("hcss")])
        hint = f"; '{guess}' is misspelt or lacks the @hookimpl decorator" if guess else ""
        raise ProviderError(f"no hook {hook} found in {plugin!r}{hint}")
    results = manager.hook.hcss_commands()
    # pluggy drops a returned None silently.
    specs = results[0] if results else None
    if not isinstance(specs, Sequence) or not all(isinstance(spec, CommandSpec) for spec in specs):
        raise ProviderError(f"hook {hook} returned {specs!r}; expected a list of CommandSpec")
    return list(specs)
