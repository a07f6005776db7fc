"""The script of Fig 6 draws from what ships."""

import subprocess
import sys
from pathlib import Path

import pytest

from hcss_twin.core.catalog import catalog_root

SCRIPT = catalog_root().parent / "docs" / "figures" / "fig6_cloud_optics.py"


@pytest.mark.long
def test_fig_6_is_drawn(tmp_path: Path) -> None:
    subprocess.run([sys.executable, str(SCRIPT), str(tmp_path)], check=True, timeout=300)
    assert (tmp_path / "fig6.png").stat().st_size > 50_000
