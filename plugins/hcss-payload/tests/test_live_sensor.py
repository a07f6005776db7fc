"""Sensor of live frames: short blurs, and rows, against those of cubes."""

import numpy as np
import pytest
from hcss_payload.live.measure import BLOCK, FEW, MAX_COUNTED, Kernels, measure_rows
from hcss_payload.live.sensor import BLUR_LEFT_OUT, LEAST, TAPS_AT_ONCE, shortened

from hcss_twin.models.sensor import noise, philox, point_spread, rows
from hcss_twin.models.sensor.blur import Weights
from hcss_twin.models.sensor.point_spread import gaussian_mtf, line_kernel
from hcss_twin.models.sensor.rows import Detector, measure


def test_live_frames_draw_and_cut_as_the_sensor_of_cubes():
    assert (LEAST, TAPS_AT_ONCE) == (point_spread.LEAST, rows.TAPS_AT_ONCE)
    assert (BLOCK, FEW, MAX_COUNTED) == (philox.BLOCK, rows.FEW, noise.MAX_COUNTED)


def blur_of(sigma):
    kernel, _ = line_kernel(lambda frequency: gaussian_mtf(frequency, sigma))
    padded = np.zeros((1, kernel.size + -kernel.size % 4), np.float32)
    padded[0, : kernel.size] = kernel
    return Weights(padded, padded, (kernel.size // 2, kernel.size // 2))


def blurred(rows, weights):
    """Noise blurred along rows."""
    reach, row_weights = weights.reach[1], weights.across[0, : 2 * weights.reach[1] + 1]
    wide = np.pad(rows, ((0, 0), (reach, reach)), mode="wrap")
    return sum(weight * wide[:, k : k + rows.shape[1]] for k, weight in enumerate(row_weights))


@pytest.mark.parametrize(("sigma", "most"), [(0.5, 7), (0.8, 3)])
def test_short_kernels_err_by_less_than_half_a_percent_of_the_contrast(sigma, most):
    whole = blur_of(sigma)
    short = shortened(whole, BLUR_LEFT_OUT)
    assert short.reach == (most, most)
    assert short.across.sum() == pytest.approx(whole.across.sum(), abs=1e-6)
    # Independent numbers are the worst image: neighbours of clouds are alike, and the tails alternate in sign.
    rows = np.random.default_rng(1).standard_normal((64, 512))
    error = blurred(rows, short) - blurred(rows, whole)
    assert np.std(error) < 4e-3
    smooth = np.cumsum(rows, axis=1)
    smooth -= np.linspace(0.0, 1.0, 512) * smooth[:, -1:]
    of_smooth = np.std(blurred(smooth, short) - blurred(smooth, whole))
    assert of_smooth < 1.2 * np.std(error) * np.std(np.diff(smooth, axis=1))


def test_blurs_of_two_terms_that_end_by_themselves_and_none_stay():
    ending = blur_of(1.2)
    assert shortened(ending, 0.5) is ending
    two = Weights(np.ones((2, 4), np.float32), np.ones((2, 4), np.float32), (1, 1))
    assert shortened(two, 0.5) is two
    assert shortened(None, 0.5) is None


@pytest.mark.parametrize("converter", [True, False])
@pytest.mark.parametrize("taps", [0, 7, 15])
def test_live_rows_measure_as_the_sensor_of_cubes(taps, converter):
    rng = np.random.default_rng(2)
    image = (5.0 + rng.standard_normal((40, 70))).astype(np.float32)
    kernel = rng.uniform(0.0, 2.0 / max(taps, 1), (1, taps)).astype(np.float32)
    down = np.pad(kernel, ((0, 0), (0, -taps % 4)))[: 1 if taps else 0]
    across = np.ascontiguousarray(down[:, ::-1]) if taps == 15 else down
    weights = Weights(down, across, (taps // 2, max(0, taps // 2 - 1)))
    gain, offset = (0.01 * rng.standard_normal((40, size)).astype(np.float32) for size in (70, 1))
    detector = Detector(5e4, 300.0, 1.0, 1.0, 50.0, 5e5, 60.0 if converter else 0.0, 3.0, 16383.0)
    keys, none = (np.uint64(11), np.uint64(12)), np.empty((0, 0), np.float32)
    shape = (40, 70) if converter else (0, 0)
    expected, found = np.zeros((40, 70), np.float32), np.zeros((40, 70), np.float32)
    numbers, mine = np.zeros(shape, np.int32), np.zeros(shape, np.int32)
    flags = np.zeros((40, 70), np.uint8)
    added = rng.uniform(0.0, 1.0, (40, 70)).astype(np.float32) if taps else none
    measure(image, *weights, added, gain, offset, detector, keys, (0, 0), (0, 40), expected, none, numbers, flags)
    kernels = Kernels.of(weights)
    for lines in ((0, 9), (9, 40)):
        assert measure_rows(
            image,
            kernels.down,
            kernels.across,
            kernels.reach,
            added,
            gain,
            offset,
            detector,
            keys[0],
            lines,
            found,
            mine,
        )
    assert found.std() > 0.01 * found.mean()
    # Rounding moves few numbers to the next.
    assert np.abs(mine - numbers).max(initial=0) <= 1
    assert np.mean(found != expected) < 0.02 or not converter
    assert np.allclose(found, expected, rtol=2e-6, atol=0.0 if not converter else 1.01 * 60.0 / 5e4)
    few = detector._replace(per_radiance=1.0, dark=0.0)
    assert not measure_rows(
        image, kernels.down, kernels.across, kernels.reach, none, none, none, few, keys[0], (0, 40), found, mine
    )
