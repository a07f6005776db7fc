"""Laws of the variance-keeping cubic interpolation."""

import numpy as np
import pytest

from hcss_twin.clouds.interpolation import AxisWeights, apply, cubic_axis, cubic_weights, nearest_axis, split

FRACTIONS = np.concatenate([np.linspace(0.0, 1.0, 1001)[:-1], [np.nextafter(1.0, 0.0), 1e-300]])


def test_the_variance_of_interpolated_independent_nodes_is_one_everywhere():
    np.testing.assert_allclose(np.sum(cubic_weights(FRACTIONS) ** 2, axis=1), 1.0, atol=1e-12, rtol=0)


def test_the_variance_is_one_in_the_assembled_matrices_too():
    for step in (1e-6, 0.37, 1.0, 1.99):
        matrix = cubic_axis(-3.3 + step * np.arange(200)).matrix
        np.testing.assert_allclose(np.sum(matrix.toarray() ** 2, axis=1), 1.0, atol=1e-12, rtol=0)


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


def test_coordinates_split_into_floor_and_fraction_on_both_sides_of_zero_and_far_away():
    cell, fraction = split(np.array([-1.25, -1.0, -0.0, 0.75, 1e12 + 0.5, -1e12 - 0.25]))
    assert cell.tolist() == [-2, -1, 0, 0, 10**12, -(10**12) - 1]
    np.testing.assert_array_equal(fraction, [0.75, 0.0, 0.0, 0.75, 0.5, 0.75])


@pytest.mark.parametrize("bad", [np.nan, np.inf, 1e19])
def test_a_coordinate_that_has_no_cell_is_refused(bad):
    with pytest.raises(ValueError, match="coordinate"):
        split(np.array([0.0, bad]))


def test_the_separable_product_equals_the_written_out_double_sum():
    rng = np.random.default_rng(3)
    y, x = -2.7 + 0.31 * np.arange(9), 5.2 + 0.83 * np.arange(7)
    along_y, along_x = cubic_axis(y), cubic_axis(x)
    plane = rng.standard_normal((along_y.nodes.size, along_x.nodes.size))
    node = {
        (int(i), int(j)): plane[a, b]
        for a, i in enumerate(along_y.nodes)
        for b, j in enumerate(along_x.nodes)
    }
    (iy, fy), (ix, fx) = split(y), split(x)
    wy, wx = cubic_weights(fy), cubic_weights(fx)
    expected = [
        [
            sum(wy[r, p] * wx[c, q] * node[iy[r] + p - 1, ix[c] + q - 1] for p in range(4) for q in range(4))
            for c in range(x.size)
        ]
        for r in range(y.size)
    ]
    np.testing.assert_allclose(apply(along_y, along_x, plane), expected, atol=1e-13)


def test_a_nearest_axis_hands_each_point_its_own_node():
    axis = nearest_axis(np.array([-2.5, 0.1, 2.6, 5.0]))
    assert axis.nodes.tolist() == [-3, 0, 2, 5]
    plane = np.arange(8.0).reshape(4, 2)
    np.testing.assert_array_equal(apply(axis, AxisWeights(np.arange(2), None), plane), plane)


def test_what_the_nearest_node_neglects_two_cells_apart_is_a_weak_correlation():
    # The stated price of the nearest node from 2 cells on: -.11 at worst, -.05 on average, 0 from 4 on.
    pairs = [cubic_axis(np.array([f, f + 2.0])).matrix.toarray() for f in np.linspace(0, 1, 101)[:-1]]
    correlation = np.array([first @ second for first, second in pairs])
    assert -0.11 < correlation.min() < -0.10
    assert -0.055 < correlation.mean() < -0.045
    first, second = cubic_axis(np.array([0.4, 4.4])).matrix.toarray()
    assert first @ second == 0.0
