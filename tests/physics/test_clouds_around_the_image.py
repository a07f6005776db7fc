"""Fractal clouds go on around the image: the field of a larger one, and the threshold of the frame."""

import dataclasses

import numpy as np
import pytest
from hcss_author import sample_cloud_inputs

from hcss_twin.models.clouds.fractal.generator import FractalClouds
from hcss_twin.models.clouds.fractal.parameters import FractalParameters

MARGIN = 12
PARAMETERS = FractalParameters.model_validate({"L": (16, 16), "gamma": 2.0, "H": 0.7, "k": (0, 5)})


def clouds(coverage, mode, margin=0):
    inputs = sample_cloud_inputs()
    grid = inputs.grid
    wide = dataclasses.replace(grid, rows=grid.rows + 2 * margin, columns=grid.columns + 2 * margin)
    layer = dataclasses.replace(inputs.layer, coverage=coverage, coverage_mode=mode)
    return FractalClouds(dataclasses.replace(inputs, grid=wide, layer=layer), PARAMETERS)


def image(margin=0):
    grid = sample_cloud_inputs().grid
    return slice(-margin, grid.rows + margin), slice(-margin, grid.columns + margin)


def test_a_field_is_that_of_a_larger_image():
    around = clouds(0.4, "field").thickness_around_m(7.0, *image(MARGIN), None)
    larger = clouds(0.4, "field", MARGIN)
    whole = larger.thickness_m(7.0, *(slice(0, size) for size in around.shape))
    np.testing.assert_array_equal(around, whole)


@pytest.mark.parametrize("coverage", [0.0, 0.3, 1.0])
def test_the_threshold_of_a_frame_holds_around_it(coverage):
    provider = clouds(coverage, "frame")
    summary = provider.frame_summary(7.0)
    around = provider.thickness_around_m(7.0, *image(MARGIN), summary)
    inside = around[MARGIN:-MARGIN, MARGIN:-MARGIN]
    np.testing.assert_array_equal(inside, provider.thickness_m(7.0, *image()))
    assert np.mean(inside > 0.0) == pytest.approx(coverage, abs=1e-3)
    field = provider.field(7.0, *image(MARGIN))
    cloudy = np.zeros(field.shape, dtype=bool)
    if coverage == 1.0:
        cloudy[:] = True  # a full cover has no gaps beyond its edges
    elif coverage > 0.0:
        cloudy = field >= field[MARGIN:-MARGIN, MARGIN:-MARGIN][inside > 0.0].min()
    np.testing.assert_array_equal(around > 0.0, cloudy)
    if coverage > 0.0:
        low, high = (getattr(sample_cloud_inputs().layer, f"thickness_{end}_m") for end in ("min", "max"))
        assert low <= around[around > 0.0].min()
        assert around.max() <= high
