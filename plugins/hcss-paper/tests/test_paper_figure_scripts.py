"""The script that draws Figs 4 and 10 of the HCSS paper runs on the public interface."""

import runpy
import sys
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from hcss_paper import figure_04_fractal_fields, figure_10_cloud_types
from PIL import Image

ROOT = Path(__file__).parents[3]
SCRIPT = ROOT / "docs" / "figures" / "fractal_panels.py"


@pytest.mark.long
def test_both_figures_are_drawn(tmp_path, monkeypatch):
    """Of fields with fewer pixels: test_paper_figures.py has those of full size."""
    monkeypatch.setattr(figure_10_cloud_types, "thickness", partial(figure_10_cloud_types.thickness, size=200))
    whole = figure_04_fractal_fields.field
    monkeypatch.setattr(figure_04_fractal_fields, "field", lambda change, seed: whole(change, seed)[::4, ::4])
    monkeypatch.setattr(sys, "argv", [str(SCRIPT), str(tmp_path)])
    runpy.run_path(str(SCRIPT), run_name="__main__")
    for name in ("fig4.png", "fig10.png"):
        with Image.open(tmp_path / name) as image:
            shades = np.asarray(image.convert("L"))
        # Pictures with blacks, greys and whites, not an empty page.
        assert min(shades.shape) > 900
        assert np.mean((shades > 30) & (shades < 220)) > 0.1
