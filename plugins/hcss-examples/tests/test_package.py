"""The examples stay small, and their registration imports none of them."""

import subprocess
import sys
from pathlib import Path

import hcss_examples
import pytest

FILES = sorted(Path(hcss_examples.__file__).parent.glob("*.py"))


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_an_example_has_at_most_80_lines(path):
    assert len(path.read_text(encoding="utf-8").splitlines()) <= 80


def test_registration_imports_no_provider():
    code = "import sys, hcss_examples as e; e.hcss_register_elements(); print([m for m in sys.modules if 'numpy' in m])"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert result.stdout.strip() == "[]"
