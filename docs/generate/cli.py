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

SCENARIO is the name of a shipped scenario (`hcss scenarios`) or a TOML file ([scenario reference](scenario.md)), CUBE a
file written by `hcss run` ([cube reference](cube.md)). `hcss COMMAND --help` shows the same text.

| exit code | meaning |
|---|---|
| 0 | success |
| 1 | failure, including a failed certificate, a difference in `hcss verify`, a failed law in `hcss check` |
| 2 | wrong scenario or command line |
| 130, 143 | interrupted, terminated |

Two options are not listed below: `--force` replaces existing files, and `--json` prints the result as JSON for scripts
(it is listed where it takes a value). `hcss plugins` lists the commands of installed plugins.
The tab key completes commands and scenario names after `eval "$(_HCSS_COMPLETE=bash_source hcss)"` (also `zsh_source`,
`fish_source`). Commands of hcss-dataset, hcss-explore,
hcss-follow, hcss-light, hcss-payload and hcss-skies are described in their READMEs.
"""

_SEVERAL = 3
"""Options with the same text from which they refer to the command that has them first."""

_SHARED = ("Print the result as JSON.", "Replace existing files.")


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
        usage = " ".join(piece for piece in pieces if piece != "[OPTIONS]")
        yield f"## `{words}`\n\n`{' '.join(filter(None, (words, usage)))}`\n\n{inspect.cleandoc(command.help or '')}\n"
        options = [each for each in command.params if isinstance(each, click.Option) and each.help not in _SHARED]
        if options:
            yield from _options(options, words, first)
            yield ""


def _options(options: list[click.Option], words: str, first: dict[str, str]) -> Iterator[str]:
    """Yield a line for each option, and one for those that a command before has, if it has several of them."""
    texts = {f"* {_names(each)}: {each.help}{_default(each)}": each.opts[0] for each in options}
    shared: dict[str, list[str]] = {}
    for text in texts:
        if (where := first.setdefault(text, words)) != words:
            shared.setdefault(where, []).append(text)
    told = {text for several in shared.values() if len(several) >= _SEVERAL for text in several}
    yield from (text for text in texts if text not in told)
    for where, several in shared.items():
        if len(several) >= _SEVERAL:
            yield f"* {', '.join(f'`{texts[text]}`' for text in several)}: as for `{where}`."


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
