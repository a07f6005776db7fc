"""Every command can answer in JSON, for scripts."""

import json

import click
import pytest
from click.testing import CliRunner

from hcss_twin.cli.cubes import KINDS
from hcss_twin.cli.main import cli
from hcss_twin.core import cache

JSON_ALREADY = {"schema"}


def commands(group=cli, words=()):
    for name, command in group.commands.items():
        if isinstance(command, click.Group):
            yield from commands(command, (*words, name))
            if not command.invoke_without_command:
                continue
        yield " ".join((*words, name)), command


def answer(*arguments):
    done = CliRunner().invoke(cli, list(map(str, arguments)), catch_exceptions=False)
    assert done.exit_code == 0, done.output
    return json.loads(done.output)


@pytest.mark.parametrize(("name", "command"), [pytest.param(*each, id=each[0]) for each in commands()])
def test_a_command_has_the_option(name, command):
    options = [option for parameter in command.params for option in parameter.opts]
    assert ("--json" in options) != (name in JSON_ALREADY)


def test_the_cloud_database_is_a_list(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shipped = answer("clouds", "--json")
    assert shipped == answer("clouds", "list", "--json")
    assert {each["name"][:5] for each in shipped} == {"made-"}


def test_a_cleared_cache_is_counted(tmp_path, monkeypatch):
    monkeypatch.setenv("HCSS_CACHE_DIR", str(tmp_path))
    (tmp_path / "tables").mkdir()
    (tmp_path / "tables" / f"{64 * 'a'}.npz").write_bytes(b"1234")
    (tmp_path / "tables" / "mine.npz").write_bytes(b"of the user")
    nothing = {"files": 0, "bytes": 0}
    assert answer("cache", "clear", "tables", "--json") == {"removed": {"tables": {"files": 1, "bytes": 4}}}
    assert answer("cache", "clear", "--json") == {"removed": dict.fromkeys(KINDS, nothing)}


def test_the_kinds_of_the_cache_are_those_of_its_module():
    assert dict((cache.TABLES, cache.PLANS, cache.REFERENCES, cache.OPTICS)) == KINDS
