"""The cloud benchmark runs, also where other packages are missing."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

import hcss_twin

ROOT = Path(hcss_twin.__file__).parents[1]
SCRIPT = ROOT / "benchmarks" / "clouds.py"
pytestmark = pytest.mark.skipif(not SCRIPT.exists(), reason="not in an installed package")


def run(*arguments):
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    command = [sys.executable, str(SCRIPT), *arguments]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_every_contender_is_timed_or_named_as_missing():
    printed = run("--pixels", "64", "--frames", "2", "--rounds", "1", "--type", "cumulus")
    for name in ("scipy map_coordinates", "FastNoiseLite", "GSTools", "numpy standard_normal", "2 threads"):
        assert sum(name in line for line in printed.splitlines()) == 1, printed
    own = next(line for line in printed.splitlines() if line.startswith("| ours, field V, 1 thread |"))
    cells = [cell.strip() for cell in own.strip("|").split("|")]
    assert float(cells[1]) > 0.0
    assert cells[3] == "1"
