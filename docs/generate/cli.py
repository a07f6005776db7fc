"""Reference of the command line: usage, help and options of every command."""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from operator import itemgetter
from typing import Any

import click

from hcss_twin.cli.main import cli
from hcss_twin.core.own_packages import COMMANDS

PAGE = "reference/cli.md"

LISTED = (
    "hcss-author",
    "hcss-bench",
    "hcss-evaluate",
    "hcss-export",
    "hcss-modtran",
    "hcss-paper",
    "hcss-sweep",
    "hcss-uncertainty",
)
"""Packages whose commands are listed; READMEs of the others list theirs."""

_INTRODUCTION = """# Command line

{GENERATED}

SCENARIO is the name of a shipped scenario (`hcss scenarios`) or a TOML file ([keys](scenario.md)), CUBE a
file of `hcss run` ([variables](cube.md)). `hcss COMMAND --help` shows the same text.

| exit code | meaning |
|---|---|
| 0 | success |
| 1 | failure, including a failed certificate, a difference in `hcss verify`, a failed law in `hcss check` |
| 2 | wrong scenario or command line |
| 130, 143 | interrupted, terminated |

Options that are described here alone:

* `--set` `KEY=VALUE`, of all commands with SCENARIO or SWEEP: Change a key, for example `view.zenith=40`; repeat.
* `--workers` `1..1024`, of `run` and `propagate`: Processes; the result is the same. Default: `1`.
* `--json`: Print the result as JSON. `--json` `FILE`, of `bench` and `evaluate`: write it to a file; - prints it.
* `--force`: Replace existing files.

The tab key completes commands and scenario names after `eval "$(_HCSS_COMPLETE=bash_source hcss)"` (also `zsh_source`,
`fish_source`). Commands of hcss-dataset, hcss-explore,
hcss-follow, hcss-light, hcss-payload and hcss-skies are described in their READMEs.
"""

_SEVERAL = 3
"""Options with the same text from which they refer to the command that has them first."""

_SHARED = (
    "Change a key, for example view.zenith=40; repeat.",
    "JSON file for all numbers; - prints them instead of the table.",
    "Print the result as JSON.",
    "Processes; the result is the same.",
    "Replace existing files.",
)
"""Options that the introduction describes."""


def commands(group: click.Group = cli, words: tuple[str, ...] = ("hcss",)) -> Iterator[tuple[str, click.Command]]:
    """Yield the full name and the object of every command that can run, sorted by name."""
    members = dict(group.commands)
    if group is cli:
        plugins = cli.plugin_commands()[0].items()
        members |= {name: command.load() for name, command in plugins if COMMANDS.get(name) in LISTED}
    for name, command in sorted(members.items()):
        if isinstance(command, click.Group):
            if command.invoke_without_command:
                yield " ".join((*words, name)), command
            yield from commands(command, (*words, name))
        else:
            yield " ".join((*words, name)), command


def lines(generated: str) -> Iterator[str]:
    """Yield the page."""
    yield _INTRODUCTION.replace("{GENERATED}", generated)
    listed: dict[int, str] = {}
    first: dict[str, str] = {}
    for words, command in sorted(commands(), key=itemgetter(0)):
        if id(command) in listed:
            yield f"## `{words}`\n\nThe same command as `{listed[id(command)]}`.\n"
            continue
        listed[id(command)] = words
        pieces = command.collect_usage_pieces(click.Context(command, info_name=words))
        arguments = [piece for piece in pieces if piece != "[OPTIONS]"]
        text = inspect.cleandoc(command.help or "")
        plain = all(each.isalpha() and each in text for each in arguments)
        usage = "" if plain else f"`{' '.join((words, *arguments))}`\n\n"
        yield f"## `{words}`\n\n{usage}{text}\n"
        options = [each for each in command.params if isinstance(each, click.Option) and each.help not in _SHARED]
        if options:
            yield from _options(options, words, first)
            yield ""


def _options(options: list[click.Option], words: str, first: dict[str, str]) -> Iterator[str]:
    """Yield a line for each option, and one for those that a command before has, if it has several of them."""
    texts = _merged({_line(each): each.opts[0] for each in options})
    shared: dict[str, list[str]] = {}
    for text in texts:
        if (where := first.setdefault(text, words)) != words:
            shared.setdefault(where, []).append(text)
    told = {text for several in shared.values() if len(several) >= _SEVERAL for text in several}
    yield from (text for text in texts if text not in told)
    for where, several in shared.items():
        if len(several) >= _SEVERAL:
            yield f"* {', '.join(f'`{texts[text]}`' for text in several)}: as for `{where}`."


def _line(option: click.Option) -> str:
    return f"* {_names(option)}: {option.help}{_default(option)}"


def _merged(texts: dict[str, str]) -> dict[str, str]:
    """Return one text for each two options that differ by REAL and SIM alone."""
    pairs = {text: text.replace("--real-", "--sim-").replace("REAL", "SIM") for text in texts}
    pairs = {real: sim for real, sim in pairs.items() if real != sim and sim in texts}
    both = {real: real.replace("`--real", f"`{texts[real]}`, `--sim", 1).replace("REAL", "REAL, SIM") for real in pairs}
    return {both.get(text, text): name for text, name in texts.items() if text not in pairs.values()}


def _names(option: click.Option) -> str:
    names = ", ".join(f"`{name}`" for name in (*option.opts, *option.secondary_opts))
    if option.is_flag:
        return names
    value = option.metavar or " ".join([_kind(option.type)] * option.nargs)
    return f"{names} `{value}`"


def _kind(kind: Any) -> str:
    if isinstance(kind, click.Choice):
        return "|".join(map(str, kind.choices))
    if isinstance(kind, (click.IntRange, click.FloatRange)):
        if kind.max is None:
            return "number" if kind.min is None else f"{'>' if kind.min_open else '>='}{kind.min:g}"
        low = "" if kind.min is None else f"{'>' if kind.min_open else ''}{kind.min:g}"
        return f"{low}..{'<' if kind.max_open else ''}{kind.max:g}"
    name: str = kind.name
    return name.upper()


def _default(option: click.Option) -> str:
    default: Any = option.default
    if option.required:
        return " **Required.**"
    if option.secondary_opts:
        return f" Default: `{(option.opts if default else option.secondary_opts)[0]}`."
    # What click uses for "no default" differs between its versions.
    plain = isinstance(default, (str, int, float)) and not option.is_flag and not option.multiple
    return f" Default: `{default}`." if plain and default != "" else ""
