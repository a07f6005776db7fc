"""Surfaces have the variogram |h|^(2 H) of the closed form: in law exactly, in draws within their scatter."""

import numpy as np
import pytest
from fractional_brownian_surface import circulant_embedding, draw_surface, fractional_brownian_surface
from scipy import stats
from scipy.fft import irfft2

from hcss_twin.core.errors import ImageError

EXPONENTS = [0.01, 0.1, 0.3, 0.5, 0.7, 0.75, 0.76, 0.9, 0.99]


@pytest.mark.parametrize("hurst", EXPONENTS)
@pytest.mark.parametrize("size", [2, 7, 64])
def test_the_embedded_covariance_and_the_plane_make_the_closed_form_at_every_lag(size, hurst):
    # If an eigenvalue had been negative and set to zero, the covariance would not come back.
    embedding = circulant_embedding(size, hurst)
    covariance = irfft2(embedding.amplitude**2, s=(embedding.side, embedding.side))[:size, :size]
    lag = np.arange(size, dtype=float)
    squared = lag[:, None] ** 2 + lag**2
    variogram = 2.0 * (covariance[0, 0] - covariance) + embedding.tilt_variance * squared
    np.testing.assert_allclose(variogram, squared**hurst, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("hurst", [0.2, 0.75, 0.9])
def test_drawn_differences_have_the_closed_form_mean_square_and_are_normal(hurst):
    embedding = circulant_embedding(24, hurst)
    draws = np.array([draw_surface(embedding, seed) for seed in range(1500)])
    for (i, j), (k, m) in [((0, 0), (23, 23)), ((3, 4), (3, 5)), ((23, 0), (0, 23)), ((5, 2), (17, 9))]:
        scaled = (draws[:, i, j] - draws[:, k, m]) / np.hypot(i - k, j - m) ** hurst
        assert abs(np.mean(scaled**2) - 1.0) < 4.0 * np.sqrt(2.0 / draws.shape[0])
        assert stats.kstest(scaled, "norm").pvalue > 1e-3
    assert np.all(draws[:, 0, 0] == 0.0)


def test_a_seed_makes_one_surface_and_another_seed_another():
    one = fractional_brownian_surface(40, 0.4, 3)
    assert one.shape == (40, 40)
    np.testing.assert_array_equal(one, fractional_brownian_surface(40, 0.4, 3))
    assert not np.allclose(one, fractional_brownian_surface(40, 0.4, 4))


@pytest.mark.parametrize(("size", "hurst", "named"), [(1, 0.5, "size: 1"), (8, 0.0, "hurst: 0"), (8, 1.0, "hurst: 1")])
def test_impossible_surfaces_are_refused_by_name(size, hurst, named):
    with pytest.raises(ImageError, match=named):
        fractional_brownian_surface(size, hurst, 0)
