"""Estimators against surfaces and sets of known dimension, and box countings against their definition."""

import functools
import math

import numpy as np
import pytest
from fractional_brownian_surface import circulant_embedding, draw_surface
from hcss_evaluate.measures.box_counting import body_dimension, boundary_dimension, box_counting_dimension
from hcss_evaluate.measures.fractal_dimension import (
    DimensionEstimate,
    estimator_calibration,
    spectral_dimension,
    variogram_dimension,
)

# Far from the seeds that made the calibration and the stated errors.
SEED = 70_000


def boundary_of_level_set(surface):
    found = boundary_dimension(surface > np.median(surface))
    return DimensionEstimate(found.dimension + 1.0, found.standard_error, found.method)


ESTIMATORS = {
    "variogram": variogram_dimension,
    "box counting": box_counting_dimension,
    "spectrum": spectral_dimension,
    "boundary": boundary_of_level_set,
}


@functools.cache
def surfaces(size, hurst, count):
    embedding = circulant_embedding(size, hurst)
    return [draw_surface(embedding, SEED + i) for i in range(count)]


def deviations(estimator, size, hurst, count):
    found = [ESTIMATORS[estimator](surface) for surface in surfaces(size, hurst, count)]
    return np.array([(one.dimension - (3.0 - hurst)) / one.standard_error for one in found])


@pytest.mark.parametrize("estimator", ESTIMATORS)
@pytest.mark.parametrize(("size", "hurst", "count"), [(256, 0.2, 6), (256, 0.5, 6), (256, 0.8, 6), (800, 0.5, 2)])
def test_every_estimator_recovers_exact_surfaces_within_its_stated_error(estimator, size, hurst, count):
    deviation = deviations(estimator, size, hurst, count)
    assert np.all(np.abs(deviation) < 4.0)
    assert math.sqrt(np.mean(deviation**2)) < 2.2


def many_surfaces():
    """Sizes and Hurst exponents; large surfaces take long to draw: in CI two exponents of those of 256 do."""
    for size in (96, 256, 800):
        for hurst in (0.1, 0.25, 0.5, 0.75, 0.9):
            is_usual = size == 96 or (size == 256 and hurst in (0.25, 0.75))
            yield pytest.param(size, hurst, marks=pytest.mark.long if is_usual else pytest.mark.campaign)


@pytest.mark.parametrize("estimator", ESTIMATORS)
@pytest.mark.parametrize(("size", "hurst"), list(many_surfaces()))
def test_the_stated_error_is_the_root_mean_square_over_many_surfaces(estimator, size, hurst):
    count = {96: 60, 256: 20, 800: 6}[size]
    rms = math.sqrt(np.mean(deviations(estimator, size, hurst, count) ** 2))
    # 20 surfaces leave 16 % of scatter and 6 of them 29 %, those behind the stated error 13 %, interpolation the rest.
    # The error is stated for the estimate, not for the truth: a biased estimate may read a larger one.
    assert 0.35 < rms < 1.7


def test_the_variogram_table_agrees_with_an_earlier_measurement_of_its_own():
    # Bias and spread on 800 x 800 surfaces, found with other code: .000 +- .001 at H = .3, .003 +- .013 at .8.
    table = estimator_calibration()
    size = int(np.argmin(abs(table.log_size - math.log(800))))
    for hurst, bias, spread in ((0.3, 0.0, 0.001), (0.8, 0.003, 0.013)):
        at = int(np.argmin(abs(table.dimension - (3.0 - hurst))))
        scatter = 4.0 * table.spread["variogram"][size, at] / math.sqrt(30)
        assert table.mean["variogram"][size, at] - (3.0 - hurst) == pytest.approx(bias, abs=scatter)
        assert table.spread["variogram"][size, at] == pytest.approx(spread, rel=0.6)


def test_the_calibration_rises_and_returns_its_own_table():
    table = estimator_calibration()
    assert np.all(np.diff(table.mean["box counting, raw"], axis=1) > 0.0)
    for row, log_size in enumerate(table.log_size):
        for column, dimension in enumerate(table.dimension):
            raw = table.mean["box counting, raw"][row, column]
            size = math.exp(log_size)
            assert table.calibrated("box counting, raw", raw, size) == pytest.approx(dimension, abs=1e-9)


def test_a_plane_has_dimension_2_and_white_noise_3_by_the_variogram():
    rows, columns = np.mgrid[0:60, 0:90]
    assert variogram_dimension(2.0 * rows - 3.0 * columns).dimension == pytest.approx(2.0, abs=1e-12)
    noise = np.random.default_rng(1).standard_normal((400, 300))
    assert variogram_dimension(noise).dimension == pytest.approx(3.0, abs=0.01)


def test_a_power_law_spectrum_has_its_slope():
    # Band-limited, so that nothing is folded back: |k|^(-3) has D = 4 - 3 / 2.
    size = 512
    k = np.hypot(np.fft.fftfreq(size)[:, None], np.fft.rfftfreq(size))
    k[0, 0] = np.inf
    random = np.random.default_rng(2)
    noise = np.fft.rfft2(random.standard_normal((size, size)))
    image = np.fft.irfft2(noise * k**-1.5, s=(size, size))
    assert spectral_dimension(image).dimension == pytest.approx(2.5, abs=0.04)


def box_count_by_definition(grey, levels, largest, boxes_of):
    """Slope over s = 2, 4, ... <= largest of log(mean boxes / s^2); ``boxes_of(block, h)`` counts."""
    side = min(grey.shape)
    x, y = [], []
    s = 2
    while s <= largest:
        h = s * levels / side
        counts = [
            boxes_of(grey[i : i + s, j : j + s].astype(float), h)
            for i in range(0, grey.shape[0] - s + 1, s)
            for j in range(0, grey.shape[1] - s + 1, s)
        ]
        x.append(math.log(1 / s))
        y.append(math.log(np.mean(counts) / s**2))
        s *= 2
    return np.polyfit(x, y, 1)[0]


@pytest.mark.parametrize("shape", [(64, 64), (70, 131), (33, 40)], ids=str)
def test_box_countings_follow_their_definition(shape):
    random = np.random.default_rng(5)
    grey = np.cumsum(random.integers(-3, 4, shape), axis=1)
    grey = (grey - grey.min()).astype(np.uint8)
    grey[0, 0], grey[-1, -1] = 0, 255
    surface = box_count_by_definition(
        grey, 256, min(shape) // 8, lambda block, h: block.max() // h - block.min() // h + 1
    )
    assert box_counting_dimension(grey, calibrated=False).dimension == pytest.approx(surface, abs=1e-9)
    body = box_count_by_definition(grey, 256, min(shape) // 2, lambda block, h: math.ceil(block.max() / h))
    assert body_dimension(grey).dimension == pytest.approx(body, abs=1e-9)


def carpet(order):
    """Sierpinski's carpet, 3^order pixels a side."""
    mask = np.ones((1, 1), dtype=bool)
    for _ in range(order):
        hole = np.zeros_like(mask)
        mask = np.block([[mask, mask, mask], [mask, hole, mask], [mask, mask, mask]])
    return mask


def test_a_solid_block_has_3_and_a_thin_sheet_2_by_the_body_count():
    block = np.full((256, 256), 255, dtype=np.uint8)
    assert body_dimension(block).dimension == pytest.approx(3.0, abs=0.01)
    sheet = np.ones((256, 256), dtype=np.uint8)
    assert body_dimension(sheet).dimension == pytest.approx(2.0, abs=1e-9)


def test_a_column_over_sierpinskis_carpet_has_its_dimension_plus_1():
    # log 8 / log 3 = 1.893; boxes of powers of 2 do not fit the carpet's powers of 3.
    grey = np.where(carpet(6), 255, 0).astype(np.uint8)
    assert body_dimension(grey).dimension == pytest.approx(1.0 + math.log(8) / math.log(3), abs=0.04)


def test_the_boundary_of_sierpinskis_carpet_has_its_dimension():
    assert boundary_dimension(carpet(6)).dimension == pytest.approx(math.log(8) / math.log(3), abs=0.05)


def test_straight_and_round_boundaries_have_dimension_1_and_a_chessboard_2():
    rows, columns = np.mgrid[0:300, 0:420]
    assert boundary_dimension(rows > 130).dimension == pytest.approx(1.0, abs=0.01)
    assert boundary_dimension(columns > 130).dimension == pytest.approx(1.0, abs=0.01)
    assert boundary_dimension(np.hypot(rows - 150, columns - 200) < 120).dimension == pytest.approx(1.0, abs=0.06)
    assert boundary_dimension((rows + columns) % 2 == 0).dimension == pytest.approx(2.0, abs=0.01)
