"""Images that cannot be judged are refused, with the argument, the value and what is allowed."""

import math

import numpy as np
import pytest
from hcss_evaluate.measures.box_counting import body_dimension, boundary_dimension, box_counting_dimension
from hcss_evaluate.measures.fractal_dimension import spectral_dimension, variogram_dimension
from hcss_evaluate.measures.histogram_metrics import histogram_metrics, to_grey_levels
from hcss_evaluate.measures.morphology import Morphology, morphology, morphology_errors
from hcss_evaluate.measures.semivariance import semivariances

from hcss_twin.core.errors import ImageError

SURFACE_ESTIMATORS = [variogram_dimension, box_counting_dimension, spectral_dimension]
IMAGE = np.random.default_rng(0).standard_normal((40, 50)).cumsum(axis=0)
ALL = np.ones(IMAGE.shape, dtype=bool)


@pytest.mark.parametrize("estimator", SURFACE_ESTIMATORS)
@pytest.mark.parametrize(
    ("image", "named"),
    [
        (np.zeros((40, 40)), "image: .*allowed: values that vary"),
        (np.full((40, 40), 7, dtype=np.uint8), "image: .*allowed: values that vary"),
        (np.where(np.eye(40) > 0, np.nan, 1.0), "image: a pixel is not finite"),
        (np.where(np.eye(40) > 0, np.inf, 1.0).astype(np.float32), "image: a pixel is not finite"),
        (np.zeros((31, 40)), "31 x 40 pixels given, allowed: 32 .*closest is 32 x 40"),
        (np.zeros((2, 40, 40)), "3 axes given, allowed: 2"),
        (np.zeros((40, 40), dtype=complex), "complex128 given"),
        (np.zeros((40, 40), dtype=bool), "bool given"),
        (np.full((40, 40), "cloud"), "U5 given"),
    ],
)
def test_no_estimator_takes_a_constant_broken_small_or_strange_image(estimator, image, named):
    with pytest.raises(ImageError, match=named):
        estimator(image)


@pytest.mark.parametrize(
    ("call", "named"),
    [
        (lambda: variogram_dimension(IMAGE, lags=(1,)), r"lags: \(1,\) given, allowed: two"),
        (lambda: variogram_dimension(IMAGE, lags=(2, 2)), "lags"),
        (lambda: variogram_dimension(IMAGE, lags=(0, 1)), "lags: 0 given, allowed: 1 to 49; closest is 1"),
        (lambda: variogram_dimension(IMAGE, lags=(1, 50)), "lags: 50 given.*closest is 49"),
        (lambda: variogram_dimension(IMAGE, lags=(1.0, 2.0)), "lags: .*whole numbers"),
        (lambda: variogram_dimension(IMAGE, mask=ALL[:5]), "mask: shape"),
        (lambda: variogram_dimension(IMAGE, mask=ALL.astype(int)), "mask: int64 given, allowed: bool"),
        (lambda: variogram_dimension(IMAGE, mask=~ALL), "mask: 0 pairs"),
        (lambda: semivariances(1e200 * IMAGE), "image: .*square of a difference"),
        (lambda: box_counting_dimension(IMAGE, levels=1), "levels: 1 given, allowed: 2 to 256; closest is 2"),
        (lambda: box_counting_dimension(IMAGE, levels=64), "levels: 64 given, allowed: 256 for a calibrated"),
        (lambda: spectral_dimension(IMAGE, band=(0.2, 0.1)), "band: 0.2 to 0.1 given"),
        (lambda: spectral_dimension(IMAGE, band=(0.1, 0.6)), "band: 0.1 to 0.6 given"),
        (lambda: spectral_dimension(IMAGE, band=(0.1, 0.101)), "band: .*rings, allowed: 3"),
        (lambda: spectral_dimension(np.mgrid[0:40, 0:40][0]), "image: the values form a plane"),
        (lambda: boundary_dimension(ALL), "mask: cloudy everywhere"),
        (lambda: boundary_dimension(~ALL), "mask: clear everywhere"),
        (lambda: boundary_dimension(ALL[:20]), "mask: shape"),
        (lambda: boundary_dimension(IMAGE), "mask: float64 given"),
        (lambda: body_dimension(np.zeros((40, 40), dtype=np.uint8)), "grey: clear"),
        (lambda: body_dimension(IMAGE), "grey: float64 given, allowed: uint8"),
        (lambda: body_dimension(np.full((40, 40), 9, dtype=np.uint8), levels=9), "grey: level 9 given"),
        (lambda: histogram_metrics(IMAGE), "grey: float64 given, allowed: uint8"),
        (lambda: histogram_metrics(np.zeros((5, 1), dtype=np.uint8)), "grey: shape"),
        (lambda: histogram_metrics(np.full((5, 5), 9, dtype=np.uint8), 9), "grey: level 9 given"),
        (lambda: histogram_metrics(np.zeros((5, 5), dtype=np.uint8), 300), "levels: 300 .*closest is 256"),
        (lambda: to_grey_levels(IMAGE, 0.0, 0.0), "low, high"),
        (lambda: to_grey_levels(IMAGE, 0.0, math.nan), "low, high"),
        (lambda: to_grey_levels(IMAGE, -1e9, float(IMAGE.max()) - 1e-6), "values: .*limits of the levels"),
        (lambda: to_grey_levels(IMAGE, -1e9, 1e9, levels=2), "levels: 2 given, allowed: 3"),
        (lambda: to_grey_levels(np.where(ALL, math.nan, IMAGE), -1e9, 1e9), "values: a cloudy pixel is not"),
        (lambda: to_grey_levels(IMAGE, -1e9, 1e9, mask=ALL[:3]), "mask: shape"),
        (lambda: morphology(IMAGE, ~ALL), "mask: no pixel is cloudy"),
        (lambda: morphology(np.zeros((40, 40)), np.ones((40, 40), dtype=bool)), "values: all cloudy pixels are 0"),
        (lambda: morphology(IMAGE, np.indices(IMAGE.shape).sum(axis=0) % 2 == 0), "mask: 0 pairs"),
        (lambda: morphology(np.where(ALL, np.nan, IMAGE), ALL), "values: a cloudy pixel is not finite"),
        (
            lambda: morphology(np.mgrid[0:40, 0:40][0].astype(float), np.ones((40, 40), dtype=bool)),
            "values: cloudy values do not vary along an axis",
        ),
        (lambda: morphology_errors(Morphology(*[1.0] * 9), Morphology(*[0.0] * 9)), "simulated.entropy: 0"),
    ],
)
def test_impossible_arguments_are_refused_by_name(call, named):
    with pytest.raises(ImageError, match=named):
        call()
