"""``hcss validate`` of a file that a package brings the check for, because the file describes more than one scene."""

import json
import sys
import types
from importlib.metadata import EntryPoint

import pytest
from click.testing import CliRunner

from hcss_twin.cli.main import cli
from hcss_twin.core.errors import HcssError, Problem, ScenarioError
from hcss_twin.core.plugins import Origin

FILE = """
time = 2024-04-20T12:30:00+10:00
place = {latitude = 35.0, longitude = 150.0}
clouds.type = "stratus"
"""


@pytest.fixture
def install(monkeypatch):
    """Return a function after which the installed checks are those of these targets by section of files."""

    def install(**targets):
        entries = [(Origin(name, "visitor", "1.2"), EntryPoint(name, target, "-")) for name, target in targets.items()]
        monkeypatch.setattr("hcss_twin.scenario.file_checks.installed", lambda group: entries)

    def check(source, overrides, shown):
        if overrides:
            raise ScenarioError([Problem("visits", f"not with {overrides}")], source)
        return "3 visits", {"visits": 3}

    module = types.ModuleType("visitor")
    module.check = check
    monkeypatch.setitem(sys.modules, "visitor", module)
    return install


@pytest.fixture
def file(tmp_path):
    def file(section):
        path = tmp_path / "a.toml"
        path.write_text(f"{FILE}[{section}]\ncount = 3\n")
        return str(path)

    return file


def validate(*arguments):
    return CliRunner().invoke(cli, ["validate", *arguments])


def test_a_file_is_checked_by_the_package_that_names_its_section(install, file):
    install(other="visitor:absent", visits="visitor:check")
    assert validate(file("visits")).output == "valid: 3 visits\n"
    assert json.loads(validate(file("visits"), "--json").output) == {"valid": True, "visits": 3}
    refused = validate(file("visits"), "--set", "seed=1", "--json")
    assert refused.exit_code == 2
    assert json.loads(refused.output)["problems"] == [{"field": "visits", "message": "not with {'seed': 1}"}]


def test_a_check_that_cannot_be_imported_is_the_fault_of_its_package(install, file):
    install(visits="visitor:absent")
    error = validate(file("visits")).exception
    assert isinstance(error, HcssError)
    assert str(error).startswith("check 'visits' of visitor 1.2 cannot be imported: AttributeError: ")


def test_files_of_sweeps_name_the_package_that_is_not_installed(install, file):
    install()
    for source in (file("sweep"), "seasons"):
        error = validate(source).exception
        assert isinstance(error, ScenarioError)
        assert "comes with hcss-sweep: pip install" in str(error)


@pytest.mark.parametrize("command", ["validate", "plan", "run"])
@pytest.mark.parametrize(
    ("section", "words"),
    [
        ("sweep", "describes many scenes, which `hcss sweep FILE"),
        ("sensors", "describes many sensors of a scene, which `hcss sweep FILE"),
        ("base", "describes a data set, which `hcss dataset FILE"),
    ],
)
def test_files_of_many_scenes_are_named_with_their_command(install, file, command, section, words):
    install()
    error = CliRunner().invoke(cli, [command, file(section)]).exception
    assert isinstance(error, ScenarioError)
    assert words in str(error)
    assert "unknown key" not in str(error)


def test_a_shipped_sweep_is_no_scenario_and_its_command_is_named(install):
    install()
    error = CliRunner().invoke(cli, ["plan", "seasons"]).exception
    assert "it is a shipped sweep, which `hcss sweep seasons -o FOLDER` computes" in str(error)


def test_sections_that_no_package_checks_are_unknown_keys(install, file):
    install(visits="visitor:check")
    error = validate(file("visit")).exception
    assert isinstance(error, ScenarioError)
    assert [problem.field for problem in error.problems] == ["visit"]
