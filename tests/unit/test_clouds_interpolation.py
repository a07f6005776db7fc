"""Laws of the variance-keeping cubic interpolation."""

import numpy as np
import pytest

from hcss_twin.models.clouds.fractal.rows import cubic_weights

FRACTIONS = np.concatenate([np.linspace(0.0, 1.0, 1001)[:-1], [np.nextafter(1.0, 0.0), 1e-300]])


@pytest.mark.parametrize("power", [0, 1, 2])
def test_before_normalisation_keys_kernel_reproduces_quadratics(power):
    # Keys 1981: with a = -1/2, and only then, the interpolation is exact for polynomials of degree 2.
    weights = cubic_weights(FRACTIONS)
    values = weights @ np.array([-1.0, 0.0, 1.0, 2.0]) ** power / weights.sum(axis=1)
    np.testing.assert_allclose(values, FRACTIONS**power, atol=1e-12)


def test_the_weights_are_continuous_from_cell_to_cell_with_their_slope():
    tiny = 1e-6
    before, at, after = cubic_weights(np.array([1.0 - tiny, 0.0, tiny]))
    np.testing.assert_allclose(before, np.roll(at, 1), atol=2 * tiny)
    slope_before = (np.roll(at, 1) - before) / tiny
    slope_after = np.roll((after - at) / tiny, 1)
    np.testing.assert_allclose(slope_before, slope_after, atol=1e-4)


def test_the_weights_are_mirror_symmetric():
    fraction = np.linspace(0.0, 1.0, 65)
    np.testing.assert_allclose(cubic_weights(fraction), cubic_weights(1.0 - fraction)[:, ::-1], atol=1e-15)


def test_what_the_nearest_node_neglects_is_a_weak_correlation():
    # The stated price of the nearest node at 2 cells per pixel: -.11 at worst, -.05 on average; 0 from 4 on.
    fractions = np.linspace(0, 1, 101)[:-1]
    weights = cubic_weights(fractions)
    two_apart = np.sum(weights[:, 2:] * weights[:, :2], axis=1)
    assert -0.11 < two_apart.min() < -0.10
    assert -0.055 < two_apart.mean() < -0.045
