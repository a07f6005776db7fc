"""What must not change a measure, and what must change it in a known way."""

import numpy as np
import pytest
from fractional_brownian_surface import fractional_brownian_surface
from hcss_evaluate.measures.box_counting import body_dimension, boundary_dimension, box_counting_dimension
from hcss_evaluate.measures.fractal_dimension import spectral_dimension, variogram_dimension
from hcss_evaluate.measures.histogram_metrics import histogram_metrics
from hcss_evaluate.measures.morphology import morphology

SURFACE = fractional_brownian_surface(160, 0.6, 8)[:, :131]
MASK = np.quantile(SURFACE, 0.6) < SURFACE
ESTIMATORS = [variogram_dimension, box_counting_dimension, spectral_dimension]


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_a_surface_keeps_its_dimension_when_shifted_scaled_inverted_or_turned(estimator):
    kept = estimator(SURFACE).dimension
    for other in (SURFACE + 100.0, SURFACE * 2.0**-70, SURFACE * 3.7e20, SURFACE.T, np.asfortranarray(SURFACE)):
        assert estimator(other).dimension == pytest.approx(kept, abs=2e-3)
    # Boxes start at the first pixel and at the lowest level, so that other ends move their count a little.
    for other in (-SURFACE, SURFACE[::-1], SURFACE[:, ::-1]):
        assert estimator(other).dimension == pytest.approx(kept, abs=0.06)


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_single_precision_is_enough(estimator):
    assert estimator(SURFACE.astype(np.float32)).dimension == pytest.approx(estimator(SURFACE).dimension, abs=1e-3)


def test_a_boundary_is_that_of_the_complement_and_of_the_transposed_mask():
    kept = boundary_dimension(MASK)
    assert boundary_dimension(~MASK) == kept
    assert boundary_dimension(MASK.T).dimension == pytest.approx(kept.dimension, abs=1e-12)


def test_a_cut_is_judged_like_the_whole_by_the_variogram():
    whole = fractional_brownian_surface(512, 0.4, 2)
    found = variogram_dimension(whole)
    for cut in (whole[:200, :512], whole[100:132, :]):
        part = variogram_dimension(cut)
        assert part.dimension == pytest.approx(found.dimension, abs=4 * part.standard_error)
        assert part.standard_error > found.standard_error


def test_histogram_metrics_do_not_see_the_order_of_rows_or_the_direction():
    grey = (SURFACE > 0).astype(np.uint8) * 90 + MASK.astype(np.uint8) * 40
    kept = histogram_metrics(grey)
    assert histogram_metrics(grey[::-1]) == kept
    mirrored = histogram_metrics(grey[:, ::-1])
    assert mirrored.entropy == pytest.approx(kept.entropy)
    assert mirrored.density == pytest.approx(kept.density)


def test_body_count_sees_the_contrast_and_grows_with_coverage():
    grey = np.clip((SURFACE - SURFACE.min()) / np.ptp(SURFACE) * 255, 1, 255).astype(np.uint8)
    found = [
        body_dimension(np.where(np.quantile(SURFACE, 1.0 - coverage) < SURFACE, grey, 0).astype(np.uint8))
        for coverage in (0.1, 0.3, 0.6, 1.0)
    ]
    dimensions = [one.dimension for one in found]
    assert dimensions == sorted(dimensions)
    assert body_dimension(grey // 16).dimension < dimensions[-1]


def test_morphology_does_not_depend_on_the_unit_or_on_clear_pixels():
    kept = morphology(SURFACE, MASK)
    for other in (SURFACE * 4.0, np.where(MASK, SURFACE, np.nan), SURFACE.astype(np.float32)):
        found = morphology(other, MASK)
        for name in vars(kept):
            assert getattr(found, name) == pytest.approx(getattr(kept, name), rel=2e-3), name


def test_stretching_an_image_along_x_multiplies_its_aspect():
    surface = fractional_brownian_surface(512, 0.7, 6)
    # Every third row of a surface is the surface with y compressed: 3 times longer along x than along y.
    image = surface[::3, :170]
    everything = np.ones(image.shape, dtype=bool)
    found, turned = morphology(image, everything), morphology(image.T, everything.T)
    assert found.aspect == pytest.approx(3.0, rel=0.25)
    assert found.anisotropy == pytest.approx(3.0 ** (2 * 0.7), rel=0.25)
    assert turned.aspect == pytest.approx(1.0 / found.aspect)
    assert turned.anisotropy == pytest.approx(1.0 / found.anisotropy)
    assert np.isnan(found.boundary_dimension)
    assert found.coverage == 1.0
