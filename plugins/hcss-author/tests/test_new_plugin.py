"""``hcss new-plugin``: what it refuses, and that its package is complete for every kind."""

import json
import sys
import tomllib

import hcss_author
import pytest
from click.testing import CliRunner
from hcss_author.new_plugin.write import KINDS, contract_name, package_files, write_package
from installed_providers import install

from hcss_twin.cli.main import cli
from hcss_twin.core.errors import OptionError
from hcss_twin.providers.registry import Kind


def new_plugin(*arguments):
    return CliRunner().invoke(cli, ["new-plugin", *map(str, arguments)])


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_has_a_template_and_a_contract_class(kind):
    assert hasattr(hcss_author, contract_name(kind))
    files = package_files(kind, "my-own")
    assert not any("$" in path or "$" in text for path, text in files.items())
    project = tomllib.loads(files["pyproject.toml"])["project"]
    (entries,) = project["entry-points"].values()
    assert entries["my-own"].partition(":")[0].partition(".")[0] == "hcss_my_own"
    for path, text in files.items():
        if path.endswith(".py"):
            compile(text, path, "exec")


@pytest.mark.parametrize("kind", Kind)
def test_the_package_can_be_selected_and_created(kind, tmp_path, monkeypatch):
    name = f"own-{kind}"
    write_package(kind, name, tmp_path / "package")
    monkeypatch.syspath_prepend(tmp_path / "package" / "src")
    module = f"hcss_own_{kind}"
    install(monkeypatch, __import__(module), name)
    try:
        hcss_author.assert_registered(kind, name, f"hcss-{name}")
    finally:
        for module_name in [module_name for module_name in sys.modules if module_name.partition(".")[0] == module]:
            del sys.modules[module_name]


def test_the_command_names_the_files_it_wrote(tmp_path):
    folder = tmp_path / "mine"
    done = new_plugin("sea", "slush", "--folder", folder, "--json")
    assert done.exit_code == 0, done.output
    answer = json.loads(done.output)
    assert answer["folder"] == str(folder)
    assert set(answer["files"]) == {str(file) for file in folder.rglob("*") if file.is_file()}


@pytest.mark.parametrize(
    ("arguments", "parts"),
    [
        (("see", "slush"), ["KIND is 'see'", "closest is 'sea'"]),
        (("sea", "My_Slush"), ["NAME is 'My_Slush'", "closest is 'my-slush'"]),
        (("sea", "3d-sea"), ["NAME is '3d-sea'", "a letter first"]),
        (("sea", "cox-munk"), ["a sea model of hcss-twin", "not yet in use"]),
        (("sea", "slush", "--folder", "."), ["folder . exists"]),
        (("sea", "slush", "--folder", "no/where"), ["there is no folder"]),
    ],
)
def test_it_refuses_what_cannot_become_a_plugin(arguments, parts, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = new_plugin(*arguments)
    assert isinstance(done.exception, OptionError)
    for part in parts:
        assert part in str(done.exception)
    assert not list(tmp_path.iterdir())
