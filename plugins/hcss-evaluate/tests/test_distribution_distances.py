"""Distances of distributions against closed forms and scipy's own."""

import numpy as np
import pytest
from hcss_evaluate.comparison.image_measures import distribution_distance
from scipy.stats import ks_2samp, wasserstein_distance

from hcss_twin.core.errors import ImageError


@pytest.mark.parametrize("sizes", [(500, 500), (300, 701), (1, 50)])
def test_distances_are_those_of_scipy(sizes):
    random = np.random.default_rng(sum(sizes))
    one, other = random.normal(280, 5, sizes[0]), np.round(random.gamma(3.0, 4.0, sizes[1]), 1)
    found = distribution_distance(one, other)
    assert found.wasserstein == pytest.approx(wasserstein_distance(one, other), rel=1e-12)
    assert found.wasserstein_centred == pytest.approx(
        wasserstein_distance(one - one.mean(), other - other.mean()), rel=1e-12
    )
    assert found.kolmogorov_smirnov == pytest.approx(ks_2samp(one, other, method="asymp").statistic, rel=1e-12)
    assert found.mean_difference == pytest.approx(other.mean() - one.mean())


def test_a_shift_costs_its_size_and_has_no_shape():
    values = np.random.default_rng(0).normal(0, 1, (20, 20))
    found = distribution_distance(values, values + 3.0)
    assert found.wasserstein == pytest.approx(3.0)
    assert found.wasserstein_centred == pytest.approx(0.0, abs=1e-12)
    assert found.deviation_ratio == pytest.approx(1.0)


def test_normal_distributions_of_two_widths_have_the_closed_form():
    # W1 of N(0, s) and N(0, t) is |s - t| E|z|.
    z = np.random.default_rng(1).standard_normal(200_000)
    found = distribution_distance(2.0 * z, 5.0 * z)
    assert found.wasserstein == pytest.approx(3.0 * np.sqrt(2 / np.pi), rel=0.01)
    assert found.deviation_ratio == pytest.approx(2.5)


def test_values_lie_no_distance_from_themselves_in_another_order_and_missing_ones_do_not_count():
    values = np.random.default_rng(2).normal(0, 1, 300)
    with_gap = np.concatenate([values[::-1], [np.nan, np.nan]])
    found = distribution_distance(values, with_gap)
    assert (found.wasserstein, found.kolmogorov_smirnov) == (0.0, 0.0)


def test_no_value_at_all_is_refused():
    with pytest.raises(ImageError, match="second: no value"):
        distribution_distance(np.ones(3), np.full(3, np.nan))
