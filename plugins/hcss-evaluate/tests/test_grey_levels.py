"""Quantisation: clear pixels are level 0, cloudy ones the equal steps above it."""

import numpy as np
import pytest
from hcss_evaluate.measures.histogram_metrics import to_grey_levels


def test_cloudy_levels_are_equal_steps_by_hand():
    values = np.array([[0.0, 0.99, 1.0, 1.99, 2.0, 3.0]])
    np.testing.assert_array_equal(to_grey_levels(values, 0.0, 3.0, levels=4), [[1, 1, 2, 2, 3, 3]])


def test_clear_pixels_are_0_whatever_they_hold():
    values = np.array([[np.nan, 5.0, np.inf, 1e300]])
    mask = np.array([[False, True, False, False]])
    np.testing.assert_array_equal(to_grey_levels(values, 0.0, 10.0, mask=mask), [[0, 128, 0, 0]])


@pytest.mark.parametrize("dtype", [np.float32, np.float64, np.uint8, np.int32])
def test_the_limits_become_the_first_and_the_last_cloudy_level(dtype):
    values = np.array([[10, 200]], dtype=dtype)
    np.testing.assert_array_equal(to_grey_levels(values, 10.0, 200.0), [[1, 255]])


@pytest.mark.parametrize("scale", [1e-300, 1.0, 1e300])
def test_levels_do_not_depend_on_the_unit(scale):
    values = np.linspace(-1.0, 1.0, 1001)[None, :]
    expected = np.minimum(np.floor((values + 1.0) / 2.0 * 255.0), 254) + 1
    found = to_grey_levels(values * scale, -scale, scale)
    assert np.abs(found - expected).max() <= 1  # rounding at the edges of steps
    assert np.count_nonzero(found != expected) < 30


def test_no_cloud_is_an_image_of_zeros():
    assert not to_grey_levels(np.ones((3, 3)), 0.0, 2.0, mask=np.zeros((3, 3), dtype=bool)).any()
