"""The largest rectangle without missing pixels, against trying all of them."""

import numpy as np
import pytest
from fractional_brownian_surface import fractional_brownian_surface
from hcss_evaluate.measures.checks import complete_part
from hcss_evaluate.measures.histogram_metrics import histogram_metrics, joint_histogram
from hcss_evaluate.measures.morphology import morphology

from hcss_twin.core.errors import ImageError


def largest_area(valid):
    rows, columns = valid.shape
    return max(
        (c - a) * (d - b)
        for a in range(rows)
        for c in range(a + 1, rows + 1)
        for b in range(columns)
        for d in range(b + 1, columns + 1)
        if valid[a:c, b:d].all()
    )


@pytest.mark.parametrize("seed", range(6))
def test_no_rectangle_is_larger(seed):
    valid = np.random.default_rng(seed).random((9, 7)) > 0.15 * (seed + 1) / 2
    found = valid[complete_part(valid)]
    assert found.all()
    assert found.size == largest_area(valid)


def test_everything_and_nothing():
    assert complete_part(np.ones((3, 4), bool)) == (slice(0, 3), slice(0, 4))
    assert np.zeros((3, 4), bool)[complete_part(np.zeros((3, 4), bool))].size == 0


def test_pairs_with_a_missing_pixel_do_not_count():
    random = np.random.default_rng(0)
    grey = random.integers(0, 7, (12, 15)).astype(np.uint8)
    valid = random.random(grey.shape) > 0.3
    counts = np.zeros((7, 7), int)
    for row, known in zip(grey, valid, strict=True):
        for j in range(14):
            if known[j] and known[j + 1]:
                counts[row[j], row[j + 1]] += 1
    np.testing.assert_array_equal(joint_histogram(grey, 7, valid), counts)
    share = counts[counts > 0] / counts.sum()
    assert histogram_metrics(grey, 7, valid).entropy == pytest.approx(-np.sum(share * np.log2(share)))
    with pytest.raises(ImageError, match="no two neighbours"):
        histogram_metrics(grey, 7, np.zeros(grey.shape, bool))


def test_a_missing_strip_leaves_the_morphology_of_the_rest():
    image = fractional_brownian_surface(96, 0.5, 3)
    cloudy = image > np.median(image)
    level = np.where(cloudy, image - image.min() + 1.0, 0.0)
    valid = np.ones(image.shape, bool)
    valid[:, 80:] = False
    found = morphology(level, cloudy, valid)
    whole = morphology(level[:, :80], cloudy[:, :80])
    for name in vars(whole):
        # The variogram reaches an eighth of the shorter side, which is shorter by the strip.
        tolerance = 0.05 if name == "aspect" else 1e-9
        assert getattr(found, name) == pytest.approx(getattr(whole, name), rel=tolerance), name


def test_too_small_a_rest_is_refused():
    image = fractional_brownian_surface(64, 0.5, 3)
    valid = np.random.default_rng(0).random(image.shape) > 0.1
    with pytest.raises(ImageError, match="largest part without missing pixels"):
        morphology(image, image > np.median(image), valid)
