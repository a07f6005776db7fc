"""What a sensor reads from a cube: the size of its pixels, and where they were in the image of the scenario."""

import numpy as np
import pytest
import xarray as xr

from hcss_twin.core.errors import CubeError
from hcss_twin.engine.cube_sensor import corner_in_image, pixel_size_of

IMAGE = (8, 12)
SIZE_M = 100.0


@pytest.fixture
def cube():
    """Pixel centres of the image."""
    y, x = ((np.arange(count) - 0.5 * count + 0.5) * SIZE_M for count in IMAGE)
    return xr.Dataset(coords={"y": y, "x": x})


def test_a_part_of_the_image_starts_where_it_was_cut(cube):
    assert corner_in_image(cube, IMAGE, SIZE_M) == (0, 0)
    assert corner_in_image(cube.isel(y=slice(3, 7), x=slice(2, 12)), IMAGE, SIZE_M) == (3, 2)


def test_pixels_that_are_not_those_of_the_image_have_no_place_in_it(cube):
    # The first pixel fits, the later ones do not.
    assert corner_in_image(cube.isel(x=slice(4, 12, 2)), IMAGE, SIZE_M) == (0, 0)
    assert corner_in_image(cube.coarsen(y=2, x=2).mean(), IMAGE, SIZE_M) == (0, 0)


def test_the_pixel_size_is_that_of_the_scenario_to_rounding_else_that_of_the_cube(cube):
    assert pixel_size_of(cube, SIZE_M * (1.0 + 1e-9), "cube") == SIZE_M * (1.0 + 1e-9)
    assert pixel_size_of(cube.isel(x=slice(0, 12, 3)), SIZE_M, "cube") == 300.0
    assert pixel_size_of(cube, 250.0, "cube") == SIZE_M
    assert pixel_size_of(cube.isel(x=slice(0, 1)), SIZE_M, "cube") == SIZE_M
    with pytest.raises(CubeError, match="not evenly spaced"):
        pixel_size_of(cube.isel(x=[0, 1, 3]), SIZE_M, "cube")
