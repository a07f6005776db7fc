"""Laws of the exact coverage (eq 5) and of the thickness map (eq 7)."""

from dataclasses import replace

import numpy as np
import pytest
from hcss_author import sample_layer
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from scipy import stats

from hcss_twin.models.clouds.coverage import cloud_fraction_value, cloudy_pixels
from hcss_twin.models.clouds.thickness import frame_thickness

COVERAGES = st.one_of(st.sampled_from([0.0, 1.0, 0.5, 1e-9, 1.0 - 1e-9]), st.floats(0.0, 1.0))
SHAPES = hnp.array_shapes(min_dims=2, max_dims=2, min_side=1, max_side=12)
# Few distinct values make many ties.
FIELDS = SHAPES.flatmap(
    lambda shape: st.one_of(
        hnp.arrays(np.float64, shape, elements=st.floats(-9, 9)),
        hnp.arrays(np.float64, shape, elements=st.sampled_from([-1.0, 0.0, 6.0])),
    )
)


@settings(deadline=None)
@given(field=FIELDS, coverage=COVERAGES)
def test_the_mask_is_that_of_a_stable_descending_sort(field, coverage):
    # Stable: ties go to the smaller flat index.
    order = np.argsort(-field.ravel(), kind="stable")[: round(coverage * field.size)]
    expected = np.zeros(field.size, dtype=bool)
    expected[order] = True
    np.testing.assert_array_equal(cloudy_pixels(field, coverage).ravel(), expected)


def test_values_where_p_saturates_are_still_told_apart():
    field = np.array([[9.0, 12.0, 10.0, 11.0]])
    assert np.all(cloud_fraction_value(field) == 1.0)
    assert cloudy_pixels(field, 0.5).tolist() == [[False, True, False, True]]


@pytest.mark.parametrize(("coverage", "nearest"), [(-0.01, "0.0"), (1.01, "1.0"), (float("nan"), "")])
def test_a_coverage_outside_its_range_is_refused_with_the_closest_choice(coverage, nearest):
    with pytest.raises(ValueError, match=f"coverage.*allowed 0 to 1; closest is {nearest}"):
        cloudy_pixels(np.zeros((2, 2)), coverage)


def test_p_is_the_normal_distribution_function():
    v = np.linspace(-8, 8, 161)
    np.testing.assert_allclose(cloud_fraction_value(v), stats.norm.cdf(v), atol=2e-16)


def layer(coverage, low, high):
    limits = {"base_m": 0.0, "top_m": high, "thickness_min_m": low}
    return replace(sample_layer(), coverage=coverage, edge_taper=0.0, **limits)


def test_thickness_is_linear_in_p_and_spans_its_range():
    p = np.array([[0.5, 0.2, 0.625], [0.75, 0.1, 0.9375]])
    expected = np.where(p >= 0.5, 100.0 + 400.0 * (p - 0.5) / 0.4375, 0.0)
    field = stats.norm.ppf(p).astype(np.float32)
    np.testing.assert_allclose(frame_thickness(field, layer(4 / 6, 100.0, 500.0)), expected, rtol=1e-5)


def test_one_cloudy_pixel_has_the_greatest_thickness():
    field = np.array([[-1.0, 1.3]], dtype=np.float32)
    assert frame_thickness(field, layer(0.5, 10.0, 300.0)).tolist() == [[0.0, 300.0]]


def test_rounding_to_single_precision_stays_inside_limits_that_are_no_single_precision_numbers():
    field = np.linspace(-3.0, 3.0, 11, dtype=np.float32)[None, :]
    for low, high in ((0.1, 1000.1), (33.3, 0.7e4), (0.3, 0.3)):
        thickness = frame_thickness(field, layer(1.0, low, high)).astype(np.float64)
        assert thickness.max() <= high
        assert low == high or thickness.min() >= low


@pytest.mark.parametrize("limits", [(-1.0, 5.0), (6.0, 5.0), (0.0, 0.0), (0.0, np.inf), (np.nan, 1.0)])
def test_limits_out_of_order_are_refused(limits):
    with pytest.raises(ValueError, match="thickness"):
        frame_thickness(np.ones((1, 1), dtype=np.float32), layer(1.0, *limits))
