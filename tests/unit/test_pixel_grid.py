"""Spacing of a cube's coordinates: even, increasing, and known for a single pixel, or refused."""

import numpy as np
import pytest

from hcss_twin.core.errors import CubeError
from hcss_twin.cube.pixel_grid import first_and_step


def test_a_coordinate_that_is_not_even_is_refused():
    with pytest.raises(CubeError, match="x has uneven steps"):
        first_and_step("x", np.array([0.0, 1.0, 2.5]), None)
    with pytest.raises(CubeError, match="y does not increase"):
        first_and_step("y", np.array([2.0, 1.0]), None)
    with pytest.raises(CubeError, match="y has one value"):
        first_and_step("y", np.array([2.0]), None)
