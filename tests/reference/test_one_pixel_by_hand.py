"""Pixels of a cube against the ten steps of ``docs/development/one_pixel.py``, clouds by discrete ordinates."""

import runpy

import numpy as np
import pytest

from hcss_twin.core.catalog import catalog_root

PAGE = catalog_root().parent / "docs" / "development" / "one-pixel.md"


def test_pixels_of_a_cube_have_the_radiance_of_the_ten_steps():
    script = runpy.run_path(str(PAGE.with_name("one_pixel.py")))
    thickness, radiance = script["of_cube"]()
    for quantile in (0.0, 0.6, 1.0):
        pixel = int(np.flatnonzero(thickness == np.quantile(thickness, quantile, method="nearest"))[0])
        # Half the accuracy that the scene asks for.
        assert radiance[pixel] == pytest.approx(script["by_hand"](float(thickness[pixel])), rel=5e-4)
    assert np.min(thickness) == 0.0
