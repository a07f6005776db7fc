"""The normal quantile and the exceedance of the cloud field against scipy's double-precision functions."""

import numpy as np
import pytest
from normal_numbers import quantile
from scipy.special import ndtr, ndtri

from hcss_twin.models.clouds.coverage import exceedance

BITS = np.unique(
    np.concatenate(
        [
            np.arange(0, 5000),
            2**31 + np.arange(-5000, 5000),
            2**32 - 1 - np.arange(5000),
            np.linspace(0, 2**32 - 1, 300_001).astype(np.int64),
            2 ** np.arange(32),
        ]
    )
).astype(np.uint32)


def tail(bits):
    return ((bits & np.uint32(0x7FFFFFFF)).astype(np.float64) + 0.5) / 2.0**31


def test_quantile_is_scipys_within_4e_6_to_the_farthest_tail():
    expected = np.where(BITS >> np.uint32(31), -1.0, 1.0) * ndtri(tail(BITS) / 2)
    values = quantile(BITS)
    assert np.abs(values - expected).max() < 4e-6
    assert 6.3 < np.abs(values).max() < 6.4


def test_quantile_is_odd_in_its_sign_bit():
    np.testing.assert_array_equal(quantile(BITS ^ np.uint32(2**31)), -quantile(BITS))


def test_quantile_never_falls_as_the_tail_grows():
    # Rounding may flatten, and wriggles by less than the stated error.
    ascending = quantile(np.sort(BITS[BITS < 2**31]))
    assert np.diff(ascending).min() > -4e-6


def test_equal_words_have_equal_values_whatever_stands_beside_them():
    whole = quantile(BITS)
    for start, stop in ((0, 1), (1, 18), (5, 70), (100, 1131)):
        np.testing.assert_array_equal(quantile(BITS[start:stop]), whole[start:stop])


@pytest.mark.parametrize(("low", "high"), [(-9.0, 0.0), (0.0, 5.0), (5.0, 9.0)])
def test_exceedance_is_scipys_with_small_relative_error_also_far_out(low, high):
    field = np.linspace(low, high, 100_001).astype(np.float32)
    share = np.empty_like(field)
    exceedance(field, share)
    np.testing.assert_allclose(share, ndtr(-field.astype(np.float64)), rtol=8e-6)


def test_exceedance_beyond_nine_sigma_stays_between_0_and_1():
    share = np.empty(4, dtype=np.float32)
    exceedance(np.array([-1e30, -12.0, 12.0, 1e30], dtype=np.float32), share)
    assert share.min() > 0.0
    assert share.max() <= 1.0
    assert share[2] < 2e-19
