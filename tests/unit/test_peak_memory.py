"""Peak memory is that of the program itself, not of the larger one that started it."""

import subprocess
import sys
from pathlib import Path

import pytest

import hcss_twin

FOLDER = Path(hcss_twin.__file__).parents[1] / "benchmarks"
ASK = f"""
import sys; sys.path.insert(0, {str(FOLDER)!r})
from regression import peak_memory_mb; print(peak_memory_mb(), flush=True)
"""
LARGE = f"""
import subprocess, sys
import numpy as np
large = np.ones(40_000_000)
{ASK}
subprocess.run([sys.executable, "-c", {ASK!r}], check=True)
"""


@pytest.mark.skipif(not FOLDER.exists(), reason="not in an installed package")
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="the kernel's high-water mark")
def test_a_small_program_started_by_a_large_one_is_small():
    done = subprocess.run([sys.executable, "-c", LARGE], check=True, capture_output=True, text=True)
    large, small = map(float, done.stdout.split())
    assert large > 320
    assert small < 150
