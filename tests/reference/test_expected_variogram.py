"""The tabulated correlation of the interpolated lattice against adaptive quadrature of Keys' kernel."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

from hcss_twin.models.clouds.fractal.expected_variogram import KernelCorrelation
from hcss_twin.models.clouds.fractal.parameters import FractalParameters

KERNEL = KernelCorrelation.tabulate()


def keys(distance):
    """Keys' cubic convolution kernel, a = -1/2, as a function of distance."""
    d = abs(distance)
    if d < 1.0:
        return 1.5 * d**3 - 2.5 * d**2 + 1.0
    return -0.5 * d**3 + 2.5 * d**2 - 4.0 * d + 2.0 if d < 2.0 else 0.0


def weights(position):
    values = np.array([keys(position - node) for node in range(-2, 9)])
    return values / math.sqrt(np.sum(values**2))


def exact_semivariogram(lag):
    """Mean over the phase of half the squared difference of the unit-norm weights."""
    breaks = [1.0 - lag % 1.0] if lag % 1.0 else None
    return quad(
        lambda phase: 0.5 * float(np.sum((weights(phase) - weights(phase + lag)) ** 2)),
        0.0,
        1.0,
        points=breaks,
        epsabs=1e-14,
        epsrel=1e-9,
        limit=200,
    )[0]


@pytest.mark.parametrize("lag", [1e-3, 0.0123, 0.2, 0.777, 1.0, 1.3, 2.0, 2.77, 3.5, 3.99])
def test_the_kernel_correlation_is_the_integral_over_the_phase(lag):
    exact = exact_semivariogram(lag)
    assert 1.0 - KERNEL(np.array(lag)) == pytest.approx(exact, rel=2e-5)


def test_the_kernel_correlation_is_one_at_zero_and_nothing_from_four_cells_on():
    np.testing.assert_allclose(KERNEL(np.array([0.0, 4.0, -4.0, 5.5, 1e9])), [1, 0, 0, 0, 0], atol=1e-15)
    assert KERNEL(np.array(-0.3)) == KERNEL(np.array(0.3))


def test_one_octave_along_one_axis_is_the_kernel_alone():
    # 0.3 cells per pixel along x, 0.7 along y.
    shape = FractalParameters(gamma=2.0, H=0.5, L=(240.0, 560.0), k=(0, 0))
    got = KERNEL.expected_variogram(shape, 20.0, [1, 3, 0], [0, 0, 2])
    np.testing.assert_allclose(got, [exact_semivariogram(lag) for lag in (0.3, 0.9, 1.4)], rtol=2e-5)


def test_the_kernel_is_a_product_along_x_and_y():
    shape = FractalParameters(gamma=2.0, H=0.5, L=(240.0, 560.0), k=(0, 0))
    expected = (1.0 - exact_semivariogram(0.6)) * (1.0 - exact_semivariogram(1.4))
    assert 1.0 - KERNEL.expected_variogram(shape, 20.0, 2, -2) == pytest.approx(expected, abs=2e-5)


def test_octaves_add_with_their_share_of_the_variance_and_fine_ones_are_white():
    # Octave 1 has 3.2 cells per pixel: the nearest node.
    shape = FractalParameters(gamma=4.0, H=0.5, L=(640.0, 640.0), k=(0, 1))
    share = np.array([1.0, 0.25]) / 1.25
    expected = share[0] * exact_semivariogram(0.8) + share[1]
    assert KERNEL.expected_variogram(shape, 20.0, 1, 0) == pytest.approx(expected, abs=2e-5)


def test_beyond_four_cells_of_the_coarsest_octave_nothing_is_shared():
    shape = FractalParameters(gamma=3.0, H=0.8, L=(10.0, 10.0), k=(0, 4))
    assert KERNEL.expected_variogram(shape, 20.0, 320, 0) == 1.0
    assert abs(KERNEL.expected_variogram(shape, 20.0, 240, 0) - 1.0) > 1e-3
    assert KERNEL.expected_variogram(shape, 20.0, 0, 0) == 0.0


def test_a_frame_of_many_cells_has_all_the_variance_and_a_frame_within_a_cell_has_little():
    many = FractalParameters(gamma=2.0, H=0.5, L=(400.0, 400.0), k=(0, 3))
    assert KERNEL.frame_variance(many, 20.0, 800, 800) == pytest.approx(1.0, abs=1e-3)
    few = FractalParameters(gamma=2.0, H=0.5, L=(0.05, 0.05), k=(0, 0))
    # The field is a plane within a twentieth of a cell: slope^2 / 12 along each axis.
    slope_squared = 2.0 * exact_semivariogram(1e-3) / 1e-6
    assert KERNEL.frame_variance(few, 20.0, 800, 800) == pytest.approx(2 * slope_squared * 0.05**2 / 12, rel=0.01)


def test_lags_between_pixels_are_refused():
    shape = FractalParameters(gamma=2.0, H=0.5, L=(10.0, 10.0), k=(0, 3))
    with pytest.raises(ValueError, match=r"dx_pixels: 0\.5 given, allowed: whole pixels"):
        KERNEL.expected_variogram(shape, 20.0, 0.5, 0)
