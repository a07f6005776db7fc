"""Tensor trains of columns with several layers, from some of their lines."""

from __future__ import annotations

import numpy as np
import pytest

from hcss_twin.engine.tables.tensor_train import TensorTrain, beside, cross, stacked, total

LOW, HIGH = np.geomspace(10.0, 2000.0, 41), np.geomspace(50.0, 1500.0, 33)
MIDDLE = np.geomspace(20.0, 500.0, 11)


class Counted:
    """Columns of a closed form; counts how many are asked for."""

    def __init__(self, law, *axes):
        self.law, self.axes, self.asked = law, axes, 0

    def __call__(self, nodes):
        self.asked += len(nodes)
        return self.law(*(axis[of_axis] for axis, of_axis in zip(self.axes, nodes.T, strict=True))).reshape(
            len(nodes), -1
        )

    @property
    def sizes(self):
        return [axis.size for axis in self.axes]

    @property
    def elements(self):
        return np.array(list(np.ndindex(*self.sizes)))


def away(guess, exact):
    """Error of the total of three terms in two bands."""
    totals = [np.sum(values.reshape(len(values), 3, -1), axis=1) for values in (guess, exact)]
    return np.max(np.abs(totals[0] - totals[1]) / np.abs(totals[1]), axis=1)


def thermal(low, high):
    """A lower cloud seen through a higher one, with a kink where its top crosses a level: (N, K = 3, B = 2)."""
    through = np.exp(-np.multiply.outer(high, [1 / 200.0, 1 / 350.0]))
    top = 290.0 - 0.006 * low - 0.002 * np.maximum(low - 700.0, 0.0)
    black = (top / 290.0)[:, None] ** np.array([12.0, 4.0])
    opaque = 1.0 - np.exp(-np.multiply.outer(low, [1 / 40.0, 1 / 70.0]))
    back = (1.0 - through) * opaque
    return np.stack([through * opaque * black, through * (1.0 - opaque), (1.0 - through) * 0.3 + 0.05 * back], 1)


def thermal_of_three(low, middle, high):
    through = np.exp(-middle / 150.0)[:, None, None]
    return through * thermal(low, high) + 0.4 * (1.0 - through)


@pytest.mark.parametrize(("law", "axes"), [(thermal, (LOW, HIGH)), (thermal_of_three, (LOW, MIDDLE, HIGH))])
def test_few_lines_say_what_all_columns_are(law, axes):
    columns = Counted(law, *axes)
    found, error = cross(columns, columns.sizes, away, 2e-8)
    asked, every = columns.asked, columns.elements
    assert np.max(away(found.at(every), columns(every))) < 1e-6
    assert error <= 2e-8
    assert asked < 0.4 * len(every)
    rounded = found.rounded(1e-7)
    assert np.max(away(rounded.at(every), columns(every))) < 1e-6
    assert max(core.shape[3] for core in rounded.cores) <= max(core.shape[3] for core in found.cores)


def test_a_difference_of_low_rank_needs_fewer_columns_than_what_it_completes():
    def finer(low, high):
        more = 2e-3 * np.exp(-low / 300.0) / (1.0 + high / 400.0)
        return thermal(low, high) * (1.0 + more[:, None, None])

    alone, derived = Counted(finer, LOW, HIGH), Counted(finer, LOW, HIGH)
    near, _ = cross(Counted(thermal, LOW, HIGH), alone.sizes, away, 1e-9)
    cross(alone, alone.sizes, away, 2e-7)
    change, error = cross(derived, derived.sizes, away, 2e-7, near)
    asked, every = derived.asked, derived.elements
    assert np.max(away(total([near, change], [1.0, 1.0]).at(every), derived(every))) < 1e-6
    assert error <= 2e-7
    assert asked < 0.8 * alone.asked


def test_columns_on_the_lines_are_the_computed_ones():
    columns = Counted(thermal, LOW, HIGH)
    found, _ = cross(columns, columns.sizes, away, 1e-3)
    for row in (0, LOW.size - 1):
        line = np.stack((np.full(HIGH.size, row), np.arange(HIGH.size)), axis=1)
        np.testing.assert_allclose(found.at(line), columns(line), rtol=1e-9, atol=1e-12)


def test_what_is_on_no_line_is_found_by_trying():
    columns = Counted(lambda low, high: 1.0 + np.exp(-((np.log(low / high)) ** 2) / 0.02), LOW, HIGH)

    def relative(guess, exact):
        return np.max(np.abs(guess - exact) / exact, axis=1)

    found, error = cross(columns, columns.sizes, relative, 5e-4)
    every = columns.elements
    np.testing.assert_allclose(found.at(every), columns(every), rtol=5e-3)
    assert error <= 5e-4


@pytest.mark.parametrize("size", [1, 2, 5])
def test_small_products_are_exact(size):
    columns = Counted(thermal, LOW[:size], HIGH[:size])
    found, _ = cross(columns, columns.sizes, away, 1e-9)
    np.testing.assert_allclose(found.at(columns.elements), columns(columns.elements), rtol=1e-7, atol=1e-10)


def test_noise_is_on_no_few_lines_and_ends_exact():
    table = np.random.default_rng(1).uniform(1.0, 2.0, (LOW.size, HIGH.size))

    def relative(guess, exact):
        return np.max(np.abs(guess - exact) / exact, axis=1)

    found, error = cross(lambda nodes: table[nodes[:, 0], nodes[:, 1]][:, None], table.shape, relative, 1e-6)
    every = np.array(list(np.ndindex(table.shape)))
    np.testing.assert_allclose(found.at(every)[:, 0], table.ravel(), rtol=1e-6)
    assert error <= 1e-6


def test_trains_are_added_put_together_and_mixed_as_their_values_are():
    random, sizes = np.random.default_rng(1), (4, 3, 5)
    every = np.array(list(np.ndindex(*sizes)))

    def train(rank):
        ranks = (1, rank, rank, 1)
        return TensorTrain(tuple(random.normal(size=(2, ranks[k], size, ranks[k + 1])) for k, size in enumerate(sizes)))

    one, other = train(2), train(3)
    np.testing.assert_allclose(
        total([one, other], [2.0, -3.0]).at(every), 2.0 * one.at(every) - 3.0 * other.at(every), atol=1e-12
    )
    np.testing.assert_allclose(beside([one, other]).at(every), np.hstack((one.at(every), other.at(every))), atol=1e-12)
    both = stacked([one, other]).values(every)
    np.testing.assert_allclose(both, np.stack((one.at(every), other.at(every)), axis=-1), atol=1e-12)
    doubled = one.each(lambda which, values: values * (2.0 if which == 1 else 1.0))
    np.testing.assert_allclose(doubled.at(every), 2.0 * one.at(every), atol=1e-12)
    twice = total([one, one], [1.0, 1.0]).rounded(1e-12)
    assert [core.shape[3] for core in twice.cores] == [2, 2, 1]
    np.testing.assert_allclose(twice.at(every), 2.0 * one.at(every), atol=1e-10)
