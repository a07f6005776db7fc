"""The script of the picture of the degraded image draws it."""

import runpy

import pytest
from cheap import CHEAP

from hcss_twin import Scenario
from hcss_twin.core.catalog import catalog_root

SCRIPT = catalog_root().parent / "docs" / "figures" / "degraded_cirrus.py"


@pytest.mark.long
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_the_degraded_image_is_drawn(tmp_path):
    drawn = runpy.run_path(str(SCRIPT))["draw"](Scenario.load("degraded-cirrus", CHEAP), tmp_path / "picture.png")
    assert drawn.stat().st_size > 50_000
