"""A stranger's package adds commands to ``hcss``: listed without importing their code, and harmless when broken."""

import json
import re
import sys

import pytest
from click.testing import CliRunner

from hcss_twin.cli.main import cli
from hcss_twin.core.commands import CommandSpec
from hcss_twin.core.errors import HcssError
from hcss_twin.core.own_packages import COMMANDS, how_to_install

HOOK = """
from hcss_twin.core.commands import CommandSpec, hookimpl

@hookimpl
def hcss_commands():
    return [{specs}]
"""
CODE = """
import click

@click.command()
@click.argument("name")
def greet(name):
    \"\"\"Greet NAME.\"\"\"
    click.echo(f"hello {name}")

not_a_command = 3
"""


@pytest.fixture
def install(tmp_path, monkeypatch):
    """Return a function that installs a distribution whose hook module, of its own name, has this source."""
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "visitor_code.py").write_text(CODE)
    modules = {"visitor_code"}

    def install(distribution, source, group="hcss_twin.commands"):
        module = distribution.replace("-", "_")
        info = tmp_path / f"{module}-1.2.dist-info"
        info.mkdir()
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {distribution}\nVersion: 1.2\n")
        (info / "entry_points.txt").write_text(f"[{group}]\n{distribution} = {module}\n")
        (tmp_path / f"{module}.py").write_text(source)
        modules.add(module)

    yield install
    for module in modules:
        sys.modules.pop(module, None)


def specs(*names, target="visitor_code:greet"):
    return HOOK.format(specs=", ".join(f'CommandSpec("{name}", "{target}", "Greet somebody.")' for name in names))


def hcss(*arguments):
    return CliRunner().invoke(cli, arguments)


def broken():
    return {each["distribution"]: each["error"] for each in json.loads(hcss("plugins", "--json").output)["broken"]}


def test_help_lists_a_command_without_importing_its_code_and_it_runs(install):
    install("visitor", specs("greet"))
    helped = hcss("--help").output
    others = helped.split("Other:")[1]
    assert re.search(r"^  greet +Greet somebody\.$", others, re.MULTILINE)
    assert "visitor_code" not in sys.modules
    assert hcss("greet", "you").output == "hello you\n"
    assert "Greet NAME." in hcss("greet", "--help").output
    [listed] = [each for each in json.loads(hcss("plugins", "--json").output)["commands"] if each["name"] == "greet"]
    assert listed == {"name": "greet", "summary": "Greet somebody.", "distribution": "visitor"}
    assert "greet" in hcss("plugins").output


@pytest.mark.parametrize(
    ("source", "error"),
    [
        ("raise RuntimeError('no licence')", "RuntimeError: no licence"),
        ("import sys; sys.exit('no display')", "SystemExit: no display"),
        ("import no_such_module_anywhere", "no_such_module_anywhere"),
        ("x = 1", "no hook hcss_commands found"),
        (specs("greet").replace("hcss_commands", "hcss_command"), "'hcss_command' is misspelt"),
        (specs("greet").replace("@hookimpl", ""), "lacks the @hookimpl decorator"),
        (specs("greet").replace("return [", "return None and ["), "returned None; expected a list of CommandSpec"),
        (HOOK.format(specs="'greet'"), "expected a list of CommandSpec"),
        (specs("greet", target="visitor_code"), "must look like 'package.module:Class'"),
        (specs("Greet!"), "lower-case letters"),
    ],
)
def test_a_broken_plugin_is_listed_with_its_error_and_the_others_work(install, source, error):
    install("broken-visitor", source)
    install("good", specs("wave"))
    assert error in broken()["broken-visitor"]
    helped = hcss("--help").output
    assert "wave" in helped
    assert "1 broken: see hcss plugins" in helped
    assert hcss("wave", "you").output == "hello you\n"
    assert hcss("scenarios").exit_code == 0
    unknown = hcss("greet")
    assert unknown.exit_code == 2
    assert "broken-visitor 1.2" in unknown.output


@pytest.mark.parametrize("target", ["visitor_code:no_name", "no_such_module:greet", "visitor_code:not_a_command"])
def test_a_command_that_cannot_be_imported_fails_alone_when_it_is_run(install, target):
    install("visitor", specs("greet", target=target))
    install("good", specs("wave"))
    assert "greet" in hcss("--help").output
    error = hcss("greet", "you").exception
    assert isinstance(error, HcssError)
    assert "command 'greet' of visitor 1.2" in str(error)
    assert target in str(error)
    assert hcss("wave", "you").output == "hello you\n"


def test_a_name_of_the_core_is_refused_and_the_other_commands_of_the_plugin_remain(install):
    install("visitor", specs("run", "greet"))
    assert broken()["visitor"] == "command 'run' is also provided by hcss-twin"
    assert "SCENARIO" in hcss("run", "--help").output
    assert hcss("greet", "you").output == "hello you\n"


def test_a_name_of_two_plugins_is_refused_with_both_named(install):
    install("first", specs("greet"))
    install("second", specs("greet", "wave"))
    assert broken()["first"] == "command 'greet' is also provided by second 1.2"
    assert broken()["second"] == "command 'greet' is also provided by first 1.2"
    unknown = hcss("greet", "you")
    assert unknown.exit_code == 2
    assert "first 1.2" in unknown.output
    assert "second 1.2" in unknown.output
    assert hcss("wave", "you").output == "hello you\n"


def test_a_plugin_extends_a_group_of_the_core(install):
    install("visitor", specs("atmosphere greet", "atmosphere wave", "nowhere greet", "greet"))
    install("other", specs("atmosphere wave"))
    assert hcss("atmosphere", "greet", "you").output == "hello you\n"
    assert re.search(r"^  greet +Greet NAME\.$", hcss("atmosphere", "--help").output, re.MULTILINE)
    errors = [each["error"] for each in json.loads(hcss("plugins", "--json").output)["broken"]]
    assert "command 'atmosphere wave' is also provided by other 1.2" in errors
    assert "command 'atmosphere wave' is also provided by visitor 1.2" in errors
    assert "command 'nowhere greet': no group 'nowhere'; allowed: atmosphere" in errors
    assert hcss("greet", "you").output == "hello you\n"


def test_a_hook_in_the_group_of_providers_alone_is_told_its_group(install):
    install("visitor", specs("greet"), group="hcss_twin")
    assert "entry point group hcss_twin.commands" in broken()["visitor"]


@pytest.mark.parametrize(
    "folder",
    [
        "hcss-author",
        "hcss-bench",
        "hcss-dataset",
        "hcss-evaluate",
        "hcss-export",
        "hcss-modtran",
        "hcss-paper",
        "hcss-sweep",
        "hcss-uncertainty",
    ],
)
def test_a_command_of_a_plugin_that_is_not_installed_names_the_plugin(monkeypatch, folder):
    monkeypatch.setattr("hcss_twin.core.plugins.installed", lambda group: [])
    plugin = pytest.importorskip(f"{folder.replace('-', '_')}.plugin")
    for spec in plugin.hcss_commands():
        done = CliRunner().invoke(cli, spec.name.split())
        assert done.exit_code == 2
        assert f"It comes with {folder}" in done.output


def test_the_group_of_atmospheres_names_the_plugin_that_has_its_commands(monkeypatch):
    monkeypatch.setattr("hcss_twin.core.plugins.installed", lambda group: [])
    assert COMMANDS["atmosphere plot"] == "hcss-modtran"
    for arguments in (["atmosphere"], ["atmosphere", "--help"]):
        assert how_to_install("hcss-modtran") in " ".join(hcss(*arguments).output.split())


@pytest.mark.parametrize("change", [{"name": "a b c"}, {"target": "a.b"}, {"summary": "two\nlines"}])
def test_a_malformed_spec_is_refused(change):
    with pytest.raises(ValueError, match=next(iter(change))):
        CommandSpec(**({"name": "greet", "target": "a:b", "summary": "Greet."} | change))
