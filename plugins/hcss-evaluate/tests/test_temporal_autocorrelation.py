"""Correlation of images over time for sequences whose correlation is known."""

import numpy as np
import pytest
from hcss_evaluate.comparison.image_measures import temporal_autocorrelation

from hcss_twin.core.errors import ImageError


def autoregressive(share, count=12, size=120, seed=0):
    random = np.random.default_rng(seed)
    frames = [random.standard_normal((size, size))]
    for _ in range(count - 1):
        frames.append(share * frames[-1] + np.sqrt(1 - share**2) * random.standard_normal((size, size)))
    return np.stack(frames)


def test_an_autoregressive_sequence_forgets_exponentially():
    found = temporal_autocorrelation(autoregressive(0.8), 2.0 * np.arange(12))
    np.testing.assert_allclose(found.correlation, 0.8**found.lag, atol=0.03)
    np.testing.assert_allclose(found.lag_s, 2.0 * found.lag)
    # 0.8^n = 1/e at n = 4.48, 8.96 s.
    assert found.decorrelation_s == pytest.approx(8.96, abs=0.4)
    assert found.pairs.tolist() == list(range(12, 0, -1))


def test_no_time_is_given_where_the_second_image_has_forgotten_the_first():
    found = temporal_autocorrelation(autoregressive(0.2), 2.0 * np.arange(12))
    assert found.is_unresolved
    assert np.isnan(found.decorrelation_s)
    assert not temporal_autocorrelation(autoregressive(0.8), 2.0 * np.arange(12)).is_unresolved


def test_what_stands_still_stays_correlated_whatever_its_brightness():
    image = np.random.default_rng(0).standard_normal((40, 40))
    found = temporal_autocorrelation(np.stack([image, 2 * image + 5, image - 1]), np.arange(3.0))
    np.testing.assert_allclose(found.correlation, 1.0)
    assert np.isnan(found.decorrelation_s)


def test_pixels_that_are_missing_once_do_not_count_and_times_may_be_unknown():
    frames = autoregressive(0.5, 3)
    frames[1, :60] = np.nan
    found = temporal_autocorrelation(frames)
    np.testing.assert_allclose(found.correlation, temporal_autocorrelation(frames[:, 60:]).correlation)
    assert found.pixels == 60 * 120
    assert np.isnan(found.lag_s).all()
    assert np.isnan(found.decorrelation_s)


@pytest.mark.parametrize(
    ("frames", "message"),
    [
        (np.zeros((1, 4, 4)), "T of 2 or more"),
        (np.zeros((2, 4, 4)), "image 0 is constant"),
        (np.full((2, 4, 4), np.nan), "no two pixels"),
    ],
)
def test_sequences_without_a_correlation_are_refused(frames, message):
    with pytest.raises(ImageError, match=message):
        temporal_autocorrelation(frames)
