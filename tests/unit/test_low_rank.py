"""A product of two axes completed from crosses."""

from __future__ import annotations

import numpy as np
import pytest

from hcss_twin.engine.tables.layer_pair import complete

LOW, HIGH = np.geomspace(10.0, 2000.0, 41), np.geomspace(50.0, 1500.0, 33)


class Counted:
    """Columns of a closed form; counts how many are asked for."""

    def __init__(self, law):
        self.law, self.asked = law, 0

    def __call__(self, pairs):
        self.asked += len(pairs)
        return self.law(pairs[:, 0], pairs[:, 1])


def thermal(low, high):
    """A lower cloud seen through a higher one, with a kink where its top crosses a level: (N, K = 3, B = 2)."""
    through = np.exp(-np.multiply.outer(high, [1 / 200.0, 1 / 350.0]))
    top = 290.0 - 0.006 * low - 0.002 * np.maximum(low - 700.0, 0.0)
    black = (top / 290.0)[:, None] ** np.array([12.0, 4.0])
    opaque = 1.0 - np.exp(-np.multiply.outer(low, [1 / 40.0, 1 / 70.0]))
    back = (1.0 - through) * opaque
    return np.stack([through * opaque * black, through * (1.0 - opaque), (1.0 - through) * 0.3 + 0.05 * back], 1)


def test_few_crosses_say_what_all_columns_are():
    columns = Counted(thermal)
    found, error = complete(columns, LOW, HIGH, 1e-6)
    low, high = np.meshgrid(LOW, HIGH, indexing="ij")
    exact = thermal(low.ravel(), high.ravel()).reshape(found.shape)
    total = exact.sum(axis=2, keepdims=True)
    assert np.max(np.abs(found - exact) / total) < 1e-6
    assert error <= 5e-7
    assert columns.asked < 0.4 * LOW.size * HIGH.size


def test_a_difference_of_low_rank_needs_fewer_columns_than_what_it_completes():
    def finer(low, high):
        more = 2e-3 * np.exp(-low / 300.0) / (1.0 + high / 400.0)
        return thermal(low, high) * (1.0 + more[:, None, None])

    low, high = np.meshgrid(LOW, HIGH, indexing="ij")
    near, exact = (law(low.ravel(), high.ravel()).reshape(LOW.size, HIGH.size, 3, 2) for law in (thermal, finer))
    alone, derived = Counted(finer), Counted(finer)
    complete(alone, LOW, HIGH, 1e-6)
    found, error = complete(derived, LOW, HIGH, 1e-6, near)
    assert np.max(np.abs(found - exact) / exact.sum(axis=2, keepdims=True)) < 1e-6
    assert error <= 5e-7
    assert derived.asked < 0.8 * alone.asked


def test_columns_in_crosses_are_the_computed_ones():
    found, _ = complete(thermal_of_pairs, LOW, HIGH, 1e-3)
    for row in (0, LOW.size - 1):
        exact = thermal(np.full(HIGH.size, LOW[row]), HIGH)
        np.testing.assert_array_equal(found[row], exact)


def thermal_of_pairs(pairs):
    return thermal(pairs[:, 0], pairs[:, 1])


def test_what_is_in_no_cross_is_found_by_trying():
    def ridge(low, high):
        near = np.exp(-((np.log(low / high)) ** 2) / 0.02)
        return (1.0 + near)[:, None, None]

    columns = Counted(ridge)
    found, error = complete(columns, LOW, HIGH, 1e-3)
    low, high = np.meshgrid(LOW, HIGH, indexing="ij")
    np.testing.assert_allclose(found[..., 0, 0], ridge(low.ravel(), high.ravel()).reshape(low.shape), rtol=5e-3)
    assert error <= 5e-4


@pytest.mark.parametrize("size", [1, 2, 5])
def test_small_products_are_computed_whole(size):
    found, error = complete(thermal_of_pairs, LOW[:size], HIGH[:size], 1e-3)
    low, high = np.meshgrid(LOW[:size], HIGH[:size], indexing="ij")
    np.testing.assert_array_equal(found, thermal(low.ravel(), high.ravel()).reshape(found.shape))
    assert error == 0.0


def test_noise_has_no_crosses_and_is_computed_whole():
    table = np.random.default_rng(1).uniform(1.0, 2.0, (LOW.size, HIGH.size))

    def noise(pairs):
        row, column = np.searchsorted(LOW, pairs[:, 0]), np.searchsorted(HIGH, pairs[:, 1])
        return table[row, column][:, None, None]

    found, error = complete(noise, LOW, HIGH, 1e-3)
    np.testing.assert_array_equal(found[..., 0, 0], table)
    assert error == 0.0
