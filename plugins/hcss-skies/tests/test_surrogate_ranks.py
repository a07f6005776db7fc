"""Ordering of pixels and the exchange of their amplitudes by rank."""

import numpy as np
import pytest
from hcss_skies.surrogate.amplitude_adjusted import ascending_order, match_ranks
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as stnp

RNG = np.random.default_rng(0)


@pytest.mark.parametrize(
    "values",
    [
        RNG.normal(size=(90, 110)),
        RNG.normal(size=(90, 110)).astype(np.float32),
        np.round(RNG.normal(size=5000), 1),
        RNG.standard_cauchy(5000),
        np.full(3000, 2.5),
        np.concatenate((np.zeros(4000), RNG.normal(size=4000))),
        np.array([3.0, -1.0]),
        np.array([7.0], dtype=np.float32),
        np.array([]),
        np.array([0.0, 5e-324, 0.0, -5e-324]),
        np.array([-1e308, 1e308, 0.0, 1e308]),
    ],
    ids=[
        "normal",
        "single precision",
        "equal groups",
        "outliers",
        "all equal",
        "half equal",
        "two",
        "one",
        "none",
        "subnormal",
        "span overflows",
    ],
)
def test_order_is_that_of_a_stable_sort(values):
    np.testing.assert_array_equal(ascending_order(values), np.argsort(values, axis=None, kind="stable"))


@settings(derandomize=True, deadline=None, suppress_health_check=[HealthCheck.too_slow])  # on a busy machine, too
@given(
    stnp.arrays(
        np.float32, stnp.array_shapes(max_dims=2, max_side=40), elements=st.floats(-(2.0**100), 2.0**100, width=32)
    )
)
def test_any_finite_field_is_ordered_as_by_a_stable_sort(values):
    np.testing.assert_array_equal(ascending_order(values), np.argsort(values, axis=None, kind="stable"))


def test_matching_keeps_the_order_of_the_field_and_the_numbers_of_the_amplitudes():
    field = RNG.normal(size=(60, 50)).astype(np.float32)
    amplitudes = np.sort(RNG.gamma(0.5, size=3000))
    matched = match_ranks(field, amplitudes)
    assert matched.shape == field.shape
    assert matched.dtype == amplitudes.dtype
    np.testing.assert_array_equal(np.sort(matched, axis=None), amplitudes)
    np.testing.assert_array_equal(
        np.argsort(matched, axis=None, kind="stable"), np.argsort(field, axis=None, kind="stable")
    )


def test_amplitudes_of_another_number_are_refused():
    with pytest.raises(ValueError, match=r"amplitudes: shape \(5,\) given, allowed: \(6,\)"):
        match_ranks(np.zeros((2, 3)), np.zeros(5))
