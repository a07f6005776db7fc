"""The script of the picture of shadows and parallax draws it."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from hcss_twin.core.catalog import catalog_root

SCRIPT = catalog_root().parent / "docs" / "figures" / "shadows_and_parallax.py"


@pytest.mark.long
def test_shadows_and_parallax_are_drawn(tmp_path: Path) -> None:
    target = tmp_path / "picture.png"
    command = [sys.executable, str(SCRIPT), str(target)]
    environment = os.environ | {"MPLBACKEND": "Agg"}
    done = subprocess.run(command, check=True, timeout=300, capture_output=True, text=True, env=environment)
    assert target.stat().st_size > 50_000
    page = (SCRIPT.parents[1] / "how-to" / "layers-and-shadows.md").read_text(encoding="utf-8")
    for line in done.stdout.splitlines():
        number = line.split(": ")[1].split(" of")[0].replace("%", " %")
        assert number in page
