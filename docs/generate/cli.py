"""Reference of the command line: usage, help and options of every command."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from typing import Any

import click
from hcss_paper.command import reproduce

from hcss_twin.cli.main import cli

PAGE = "reference/cli.md"

_INTRODUCTION = """# Command line

{GENERATED}

`hcss COMMAND --help` says the same in a terminal. SCENARIO is the name of a shipped scenario (`hcss scenarios`) or a
TOML file ([scenario reference](scenario.md)); CUBE is a file that `hcss run` wrote ([cube reference](cube.md)).

| exit code | means |
|---|---|
| 0 | done |
| 1 | failed; also a cube whose certificate fails, and one that `hcss verify` finds different |
| 2 | the scenario or the command line is wrong |
| 130, 143 | interrupted, terminated |

`--json` prints the results for scripts. Plugins can add commands; `hcss reproduce` needs the plugin `hcss-paper`.
"""


def commands(group: click.Group = cli, words: tuple[str, ...] = ("hcss",)) -> Iterator[tuple[str, click.Command]]:
    """Every command that does something, with all its words, sorted by name."""
    for name, command in sorted(group.commands.items()):
        if isinstance(command, click.Group):
            if command.invoke_without_command:
                yield " ".join((*words, name)), command
            yield from commands(command, (*words, name))
        elif not command.hidden:
            yield " ".join((*words, name)), command


def lines(generated: str) -> Iterator[str]:
    """Yield the page."""
    yield _INTRODUCTION.replace("{GENERATED}", generated)
    every = [*commands(), ("hcss reproduce", reproduce)]
    yield "| command | does |\n|---|---|"
    for words, command in every:
        anchor = words.replace(" ", "-")
        yield f"| [`{words}`](#{anchor}) | {_first_sentence(command)} |"
    for words, command in every:
        yield f"\n## `{words}`\n"
        yield f"```text\n{_usage(words, command)}\n```\n"
        yield _help(command)
        options = [each for each in command.params if isinstance(each, click.Option) and not each.hidden]
        if options:
            yield "\n| option | default | meaning |\n|---|---|---|"
            for option in options:
                yield f"| {_names(option)} | {_default(option)} | {_escaped(option.help or '')} |"


def _first_sentence(command: click.Command) -> str:
    first = _help(command).split("\n\n")[0].replace("\n", " ")
    return _escaped(re.split(r"(?<=\.)\s", first + " ")[0].rstrip(" ."))


def _help(command: click.Command) -> str:
    # A paragraph marked by click as not to be rewrapped is shown as it is.
    paragraphs = inspect.cleandoc(command.help or "").split("\n\n")
    return "\n\n".join(
        f"```text\n{text.removeprefix(chr(8)).strip(chr(10))}\n```" if text.startswith("\b") else text
        for text in paragraphs
    )


def _usage(words: str, command: click.Command) -> str:
    context = click.Context(command, info_name=words)
    return " ".join((words, *command.collect_usage_pieces(context)))


def _names(option: click.Option) -> str:
    names = ", ".join(f"`{name}`" for name in (*option.opts, *option.secondary_opts))
    if option.is_flag or option.count:
        return names
    value = option.metavar or " ".join([_choices(option.type) or option.type.name.upper()] * option.nargs)
    return f"{names} {_escaped(f'`{value}`')}"


def _choices(kind: Any) -> str:
    if isinstance(kind, click.Choice):
        return "|".join(map(str, kind.choices))
    if isinstance(kind, (click.IntRange, click.FloatRange)):
        low = "" if kind.min is None else f"{kind.min:g} {'<' if kind.min_open else '<='} "
        high = "" if kind.max is None else f" {'<' if kind.max_open else '<='} {kind.max:g}"
        return f"{low}number{high}"
    return ""


def _default(option: click.Option) -> str:
    default: Any = option.default
    if option.required:
        return "**required**"
    if option.secondary_opts:
        return f"`{(option.opts if default else option.secondary_opts)[0]}`"
    # What click uses for "no default" differs between its versions.
    plain = isinstance(default, (str, int, float)) and not option.is_flag and not option.multiple
    return f"`{default}`" if plain and default != "" else ""


def _escaped(text: str) -> str:
    return " ".join(text.split()).replace("|", r"\|")
