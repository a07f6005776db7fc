"""The script that draws Figs 4 and 10 of the HCSS paper runs on the public interface."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

ROOT = Path(__file__).parents[3]
SCRIPT = ROOT / "docs" / "figures" / "fractal_panels.py"


@pytest.mark.long
def test_both_figures_are_drawn(tmp_path):
    subprocess.run([sys.executable, SCRIPT, tmp_path], check=True, timeout=300)
    for name in ("fig4.png", "fig10.png"):
        with Image.open(tmp_path / name) as image:
            shades = np.asarray(image.convert("L"))
        # Pictures with blacks, greys and whites, not an empty page.
        assert min(shades.shape) > 900
        assert np.mean((shades > 30) & (shades < 220)) > 0.1
