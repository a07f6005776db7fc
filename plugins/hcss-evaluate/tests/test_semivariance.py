"""Semivariances are half the mean square differences of the pairs that count."""

import numpy as np
import pytest
from hcss_evaluate.measures.semivariance import semivariances


def counted(image, lag, mask):
    """Plain sums over slices: (x, y) semivariances and pairs."""
    result = []
    for axis in (1, 0):
        a, b = np.moveaxis(image, axis, 0)[:-lag], np.moveaxis(image, axis, 0)[lag:]
        m = np.moveaxis(mask, axis, 0)
        both = m[:-lag] & m[lag:]
        result.append((0.5 * np.mean((b - a)[both] ** 2), np.count_nonzero(both)))
    return result


@pytest.mark.parametrize("dtype", [np.float32, np.float64, np.uint8, np.int16])
@pytest.mark.parametrize("masked", [False, True])
def test_semivariances_are_those_of_a_plain_sum(dtype, masked):
    random = np.random.default_rng(4)
    image = random.integers(0, 256, (37, 53)).astype(dtype)
    mask = random.random(image.shape) < 0.6 if masked else np.ones(image.shape, dtype=bool)
    lags = (1, 2, 5, 30)
    found = semivariances(image, lags, mask if masked else None)
    for i, lag in enumerate(lags):
        (x, pairs_x), (y, pairs_y) = counted(image.astype(float), lag, mask)
        assert (found.pairs_x[i], found.pairs_y[i]) == (pairs_x, pairs_y)
        assert found.along_x[i] == pytest.approx(x, rel=1e-6)
        assert found.along_y[i] == pytest.approx(y, rel=1e-6)


def test_pixels_outside_the_mask_do_not_count_whatever_they_hold():
    image = np.random.default_rng(4).standard_normal((40, 40))
    mask = np.ones(image.shape, dtype=bool)
    mask[5:9, 3:30] = False
    broken = np.where(mask, image, np.nan)
    broken[6, 6] = np.inf
    a, b = semivariances(image, (1, 3), mask), semivariances(broken, (1, 3), mask)
    np.testing.assert_array_equal(a.along_x, b.along_x)
    np.testing.assert_array_equal(a.along_y, b.along_y)


def test_a_lag_longer_than_an_axis_has_no_pairs_there():
    found = semivariances(np.arange(80.0).reshape(2, 40), (1, 20))
    np.testing.assert_array_equal(found.pairs_y, [40, 0])
    np.testing.assert_array_equal(found.along_x, [0.5, 200.0])
    assert np.isnan(found.along_y[1])
