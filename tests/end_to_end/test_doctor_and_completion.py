"""What new users type: a command alone, the tab key, and ``hcss doctor``."""

import json
import os
import subprocess
import sys

import pytest
from click.testing import CliRunner

from hcss_twin.cli.main import cli
from hcss_twin.cli.options import ScenarioName
from hcss_twin.core.environment import LIBRARIES
from hcss_twin.version import __version__


@pytest.mark.parametrize("command", ["run", "plan", "validate"])
def test_a_command_without_a_scenario_lists_the_shipped_ones(command):
    done = CliRunner().invoke(cli, [command])
    assert done.exit_code == 2
    for name in ScenarioName.shipped():
        assert name in done.stderr
    assert f"{command} trade-cumulus" in done.stderr


def test_the_shell_completes_names_of_scenarios_and_files():
    typed = {"_HCSS_COMPLETE": "bash_complete", "COMP_WORDS": "hcss run cir", "COMP_CWORD": "2"}
    done = subprocess.run(
        [sys.executable, "-m", "hcss_twin"], env={**os.environ, **typed}, capture_output=True, text=True, check=False
    )
    assert done.stdout.split() == ["plain,cirrus", "plain,cirrus-over-cumulus", "file,cir"]


def test_doctor_shows_what_a_run_depends_on_and_times_a_scene(tmp_path, monkeypatch):
    monkeypatch.setenv("HCSS_CACHE_DIR", str(tmp_path))
    done = CliRunner().invoke(cli, ["doctor", "--json"])
    assert done.exit_code == 0, done.output
    facts = json.loads(done.stdout)
    assert facts["hcss_twin"].startswith(__version__)
    for library in LIBRARIES:
        assert library in facts["libraries"]
    assert str(tmp_path) in facts["cache"]
    assert "s of processor time" in facts["small scene"]
    assert "computed as specified" in facts["small scene"]
