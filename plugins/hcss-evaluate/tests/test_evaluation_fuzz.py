"""Any image is judged with finite numbers in their range, or refused."""

import math

import numpy as np
import pytest
from hcss_evaluate.measures.box_counting import body_dimension, boundary_dimension, box_counting_dimension
from hcss_evaluate.measures.fractal_dimension import spectral_dimension, variogram_dimension
from hcss_evaluate.measures.histogram_metrics import histogram_metrics
from hcss_evaluate.measures.morphology import morphology
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from hcss_twin.core.errors import ImageError

SHAPES = st.tuples(st.integers(1, 70), st.integers(1, 70))


@st.composite
def images(draw):
    """Rough and smooth images of any scale, some of them broken."""
    shape = draw(SHAPES)
    random = np.random.default_rng(draw(st.integers(0, 2**32)))
    image = random.standard_normal(shape)
    for axis in draw(st.sampled_from([(), (0,), (0, 1)])):
        image = image.cumsum(axis=axis)
    dtype = draw(st.sampled_from([np.float32, np.float64]))
    exponent = draw(st.integers(-300, 300) if dtype == np.float64 else st.integers(-35, 30))
    image = (image * 10.0**exponent + draw(st.sampled_from([0.0, 10.0**exponent]))).astype(dtype)
    if draw(st.booleans()):
        image[random.integers(0, shape[0]), random.integers(0, shape[1])] = draw(
            st.sampled_from([0.0, np.nan, np.inf, -np.inf])
        )
    return image, random.random(shape) < draw(st.sampled_from([0.0, 0.05, 0.5, 0.99, 1.0]))


def judged(call):
    """What ``call`` returns, or None if it refuses the image."""
    try:
        return call()
    except ImageError:
        return None


@settings(max_examples=120, deadline=None)
@given(images())
@pytest.mark.parametrize("estimator", [variogram_dimension, box_counting_dimension, spectral_dimension])
def test_a_dimension_is_finite_or_the_image_refused(estimator, case):
    image, _ = case
    found = judged(lambda: estimator(image))
    if found is None:
        return
    assert min(image.shape) >= 32
    assert np.all(np.isfinite(image))
    assert -1.0 < found.dimension < 5.0
    unsure = estimator is box_counting_dimension and min(image.shape) < 64
    assert math.isnan(found.standard_error) == unsure
    assert not found.standard_error <= max(0.0, 2.0 - found.dimension, found.dimension - 3.0)


@settings(max_examples=120, deadline=None)
@given(images())
def test_a_morphology_is_in_its_range_or_the_image_refused(case):
    image, mask = case
    found = judged(lambda: morphology(image, mask))
    if found is None:
        return
    assert np.all(np.isfinite(image[mask]))
    assert 0.0 <= found.entropy <= 16.0
    assert 0.0 < found.density <= 1.0
    assert 0.0 <= found.diagonal_peak <= image.size / 255
    assert found.coverage == np.count_nonzero(mask) / image.size
    assert found.anisotropy > 0.0
    assert found.aspect > 0.0 or math.isnan(found.aspect)


@settings(max_examples=100, deadline=None)
@given(hnp.arrays(np.uint8, SHAPES, elements=st.integers(0, 255)))
def test_histogram_metrics_and_body_count_take_any_8_bit_image(grey):
    if grey.shape[1] > 1:
        found = histogram_metrics(grey)
        pairs = grey.shape[0] * (grey.shape[1] - 1)
        assert 0.0 <= found.entropy <= math.log2(pairs) + 1e-9
        assert 1 / 256 <= found.density <= 1.0
        assert found.diagonal_peak == np.count_nonzero(grey[:, 1:] == grey[:, :-1]) / 255
    try:
        assert -0.5 < body_dimension(grey).dimension < 3.5
    except ImageError:
        assert min(grey.shape) < 32 or not grey.all()


@settings(max_examples=100, deadline=None)
@given(hnp.arrays(np.bool_, SHAPES))
def test_a_boundary_has_a_dimension_of_a_plane_set_or_the_mask_is_refused(mask):
    try:
        found = boundary_dimension(mask)
        # Boundaries of a few pixels scale poorly, and the estimate's own error says so.
        assert -0.2 - found.standard_error < found.dimension < 2.2 + found.standard_error
    except ImageError:
        assert min(mask.shape) < 32 or mask.all() or not mask.any()


@settings(max_examples=60, deadline=None)
@given(
    st.tuples(st.integers(32, 70), st.integers(32, 70)),
    st.one_of(st.sampled_from([0.0, -0.0, 1e300, -1e300, 5e-324]), st.floats(-1e30, 1e30)),
    st.sampled_from([np.float32, np.float64]),
)
def test_a_constant_image_has_no_dimension_and_no_structure(shape, value, dtype):
    """It is refused, or its one grey level is what is found; no warning, no number that is none."""
    image = np.full(shape, np.clip(value, -1e30, 1e30) if dtype == np.float32 else value, dtype)
    for estimator in (variogram_dimension, box_counting_dimension, spectral_dimension):
        with pytest.raises(ImageError):
            estimator(image)
    found = judged(lambda: morphology(image, np.ones(shape, bool)))
    if found is not None:
        assert found.entropy == 0.0
        assert found.coverage == 1.0
    grey = np.full(shape, int(abs(value)) % 256, np.uint8)
    metrics = histogram_metrics(grey)
    assert metrics.entropy == 0.0
    assert metrics.density == 1.0
    for mask in (np.zeros(shape, bool), np.ones(shape, bool)):
        with pytest.raises(ImageError):
            boundary_dimension(mask)
