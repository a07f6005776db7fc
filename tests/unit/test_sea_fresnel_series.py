"""Reflectance at many angles against that of each angle by itself."""

import numpy as np
import pytest

from hcss_twin.core.catalog import Catalog
from hcss_twin.models.refractive_index import load_refractive_index
from hcss_twin.models.sea.cox_munk import TERMS, reflectance_at
from hcss_twin.physics.fresnel import unpolarised_reflectance

COSINES = np.concatenate((np.geomspace(1e-6, 0.1, 50), np.linspace(0.1, 1.0, 200)))


@pytest.mark.parametrize("name", ["water", "water-240K", "water-segelstein", "ice"])
def test_many_angles_have_the_digits_of_one(name):
    known = load_refractive_index(Catalog(), name)
    low, high = known.valid_cm1
    index = known.at(np.linspace(max(low, 700.0), min(high, 14200.0), 400))
    expected = unpolarised_reflectance(index, COSINES[:, None])
    np.testing.assert_allclose(reflectance_at(index, COSINES), expected, rtol=1e-12)


@pytest.mark.parametrize("index", [1.02 + 0j, 1.1 + 0.001j, 0.6 + 0.2j, 3.0 + 30j, 40 + 40j])
def test_where_a_series_is_too_short_each_angle_is_computed_by_itself(index):
    given = np.array([1.33 + 0.01j, index])
    expected = unpolarised_reflectance(given, COSINES[:, None])
    np.testing.assert_allclose(reflectance_at(given, COSINES), expected, rtol=3e-11)


@pytest.mark.parametrize("wrong", [0.0, -0.1, 1.1, np.nan])
@pytest.mark.parametrize("count", [1, 10 * TERMS])
def test_cosines_out_of_range_are_refused(wrong, count):
    with pytest.raises(ValueError, match="allowed above 0, at most 1"):
        reflectance_at(np.array([1.33 + 0.01j]), np.full(count, wrong))
