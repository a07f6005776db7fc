"""Peak memory is that of the program itself, not of the larger one that started it."""

import subprocess
import sys

import numpy as np
import pytest

from hcss_twin.benchmarking.peak_memory import peak_memory_mb

ASK = "from hcss_twin.benchmarking.peak_memory import peak_memory_mb; print(peak_memory_mb())"


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="the kernel's high-water mark")
def test_a_small_program_started_by_a_large_one_is_small():
    before = peak_memory_mb()
    large = np.ones(30_000_000)
    assert peak_memory_mb() > before + 100 or before > 340
    found = float(subprocess.run([sys.executable, "-c", ASK], check=True, capture_output=True).stdout)
    del large
    assert found < 150
