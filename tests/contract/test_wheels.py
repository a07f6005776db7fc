"""Wheels can be installed where the checkout is not: they name other packages of the repository by version."""

import re
import shutil
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest

from hcss_twin.core.own_packages import how_to_install

ROOT = Path(__file__).parents[2]


def test_no_plugin_needs_a_folder_and_advice_names_all_that_no_index_has():
    for file in ROOT.glob("plugins/*/pyproject.toml"):
        project = tomllib.loads(file.read_text())["project"]
        extras = project.get("optional-dependencies", {}).values()
        named = [*project["dependencies"], *(name for extra in extras for name in extra)]
        assert not [name for name in named if "@" in name], file
        others = {re.split(r"[>=\[]", name)[0] for name in project["dependencies"] if name.startswith("hcss-")}
        advice = how_to_install(project["name"])
        wanted = {f"./plugins/{name}" for name in (others - {"hcss-twin"}) | {project["name"]}}
        assert {word for word in advice.split() if word.startswith("./")} == wanted


@pytest.mark.skipif(shutil.which("bash") is None, reason="needs bash")
def test_wheels_for_an_index_name_versions(tmp_path):
    command = ["bash", str(ROOT / ".ci/wheels"), str(tmp_path), ".", "plugins/hcss-uncertainty"]
    subprocess.run(command, check=True, capture_output=True, env={"PYTHON": sys.executable, "PATH": "/usr/bin:/bin"})
    wheels = sorted(tmp_path.glob("*.whl"))
    assert [wheel.name.split("-")[0] for wheel in wheels] == ["hcss_twin", "hcss_uncertainty"]
    for wheel in wheels:
        with zipfile.ZipFile(wheel) as content:
            (metadata,) = (name for name in content.namelist() if name.endswith("METADATA"))
            needs = [line for line in content.read(metadata).decode().splitlines() if line.startswith("Requires-Dist")]
        assert not [line for line in needs if "file:" in line or "@" in line]
    assert any(line.startswith("Requires-Dist: hcss-sweep>=0.1") for line in needs)
