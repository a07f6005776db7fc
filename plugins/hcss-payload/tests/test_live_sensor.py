"""Blur of live frames: short kernels against those of cubes."""

import numpy as np
import pytest
from hcss_payload.live.sensor import BLUR_LEFT_OUT, shortened

from hcss_twin.models.sensor.blur import Weights
from hcss_twin.models.sensor.point_spread import gaussian_mtf, line_kernel


def blur_of(sigma):
    kernel, _ = line_kernel(lambda frequency: gaussian_mtf(frequency, sigma))
    padded = np.zeros((1, kernel.size + -kernel.size % 4), np.float32)
    padded[0, : kernel.size] = kernel
    return Weights(padded, padded, (kernel.size // 2, kernel.size // 2))


def blurred(rows, weights):
    """Noise blurred along rows."""
    reach, own = weights.reach[1], weights.across[0, : 2 * weights.reach[1] + 1]
    wide = np.pad(rows, ((0, 0), (reach, reach)), mode="wrap")
    return sum(weight * wide[:, k : k + rows.shape[1]] for k, weight in enumerate(own))


@pytest.mark.parametrize(("sigma", "most"), [(0.5, 7), (0.8, 3)])
def test_short_kernels_err_by_what_they_state(sigma, most):
    whole = blur_of(sigma)
    short, left_out = shortened(whole, BLUR_LEFT_OUT)
    assert short.reach == (most, most)
    assert short.across.sum() == pytest.approx(whole.across.sum(), abs=1e-6)
    # Independent numbers are the worst image: neighbours of clouds are alike, and the tails alternate in sign.
    rows = np.random.default_rng(1).standard_normal((64, 512))
    error = blurred(rows, short) - blurred(rows, whole)
    assert np.std(error) == pytest.approx(left_out, rel=0.1, abs=1e-7)
    assert left_out < 4e-3
    smooth = np.cumsum(rows, axis=1)
    smooth -= np.linspace(0.0, 1.0, 512) * smooth[:, -1:]
    assert np.std(blurred(smooth, short) - blurred(smooth, whole)) < 1.1 * left_out * np.std(np.diff(smooth, axis=1))


def test_blurs_of_two_terms_that_end_by_themselves_and_none_stay():
    ending = blur_of(1.2)
    assert shortened(ending, 0.5) == (ending, 0.0)
    two = Weights(np.ones((2, 4), np.float32), np.ones((2, 4), np.float32), (1, 1))
    assert shortened(two, 0.5) == (two, 0.0)
    assert shortened(None, 0.5) == (None, 0.0)
