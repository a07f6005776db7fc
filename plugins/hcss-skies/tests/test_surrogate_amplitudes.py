"""The iteration of Schreiber and Schmitz against a plain writing of it, and where its result is known."""

import numpy as np
import pytest
from hcss_skies.surrogate.amplitude_adjusted import adjust_amplitudes, match_ranks
from scipy.special import ndtri


def cloudy_image(shape, seed=0, beta=3.0, threshold=0.3):
    """A power-law field of which only what exceeds a threshold is seen: broken cloud."""
    frequency = np.hypot(np.fft.fftfreq(shape[0])[:, None], np.fft.rfftfreq(shape[1])[None, :])
    frequency[0, 0] = np.inf
    white = np.fft.rfft2(np.random.default_rng(seed).normal(size=shape))
    field = np.fft.irfft2(white * frequency ** (-beta / 2), s=shape)
    return np.maximum(field / field.std() - threshold, 0.0)


def plain_iaaft(start, image, iterations):
    """The algorithm as printed: full complex transforms, phases as angles, sorting by a general sort."""
    wanted = np.abs(np.fft.fft2(image - image.mean()))
    ascending = np.sort(image, axis=None)
    field = start.copy()
    for _ in range(iterations):
        matched = np.empty(field.size)
        matched[np.argsort(field, axis=None, kind="stable")] = ascending
        phases = np.angle(np.fft.fft2(matched.reshape(field.shape)))
        field = np.fft.ifft2(wanted * np.exp(1j * phases)).real
    matched = np.empty(field.size)
    matched[np.argsort(field, axis=None, kind="stable")] = ascending
    return matched.reshape(field.shape)


def surrogate(adjusted, shape, amplitudes):
    return match_ranks(np.fft.irfft2(adjusted.coefficients, s=shape), amplitudes)


@pytest.mark.parametrize("shape", [(48, 64), (45, 63), (45, 64)])
@pytest.mark.parametrize("iterations", [0, 1, 10])
def test_result_is_that_of_the_plain_algorithm(shape, iterations):
    image = cloudy_image(shape) + np.linspace(0.0, 1e-6, shape[0] * shape[1]).reshape(shape)
    start = np.random.default_rng(1).permutation(image.ravel()).reshape(shape)
    amplitudes = np.sort(image, axis=None)
    adjusted = adjust_amplitudes(np.fft.rfft2(start), shape, amplitudes, np.abs(np.fft.rfft2(image)), iterations)
    expected = plain_iaaft(start, image, iterations)
    ours = surrogate(adjusted, shape, amplitudes)
    assert len(adjusted.misfit) == iterations
    # Amplitudes of 1e-6 differ where rounding exchanges two ranks.
    np.testing.assert_allclose(ours, expected, atol=1e-5)


def test_magnitudes_are_exact_after_the_spectral_step_and_amplitudes_after_the_other():
    shape = (64, 96)
    image = cloudy_image(shape)
    wanted = np.abs(np.fft.rfft2(image))
    start = np.fft.rfft2(np.random.default_rng(2).normal(size=shape))
    amplitudes = np.sort(image, axis=None)
    adjusted = adjust_amplitudes(start, shape, amplitudes, wanted, 5)
    found = np.abs(adjusted.coefficients)
    assert found[0, 0] == 0.0
    found[0, 0] = wanted[0, 0]
    np.testing.assert_allclose(found, wanted, rtol=1e-9)
    ours = surrogate(adjusted, shape, amplitudes)
    np.testing.assert_array_equal(np.sort(ours, axis=None), amplitudes)


def test_misfit_is_the_rms_over_the_full_transform_and_falls():
    shape = (65, 80)
    image = cloudy_image(shape)
    start = np.random.default_rng(3).normal(size=shape)
    amplitudes = np.sort(image, axis=None)
    wanted = np.abs(np.fft.fft2(image - image.mean()))
    adjusted = adjust_amplitudes(np.fft.rfft2(start), shape, amplitudes, np.abs(np.fft.rfft2(image)), iterations=40)
    for count in (1, 5):
        field = plain_iaaft(start, image, count - 1)
        found = np.abs(np.fft.fft2(field - field.mean()))
        expected = np.sqrt(np.sum((found - wanted) ** 2) / np.sum(wanted**2))
        assert adjusted.misfit[count - 1] == pytest.approx(expected, rel=1e-6)
    assert adjusted.misfit[-1] < 0.3 * adjusted.misfit[0]


def test_the_image_itself_is_a_fixed_point():
    shape = (40, 56)
    image = np.random.default_rng(4).gamma(2.0, size=shape)
    amplitudes = np.sort(image, axis=None)
    transform = np.fft.rfft2(image)
    adjusted = adjust_amplitudes(transform, shape, amplitudes, np.abs(transform), 5, tolerance=0.5)
    assert max(adjusted.misfit) < 1e-12
    np.testing.assert_allclose(surrogate(adjusted, shape, amplitudes), image, rtol=1e-12)


def test_normal_amplitudes_need_no_iteration():
    """A Gaussian field with the right spectrum has (nearly) the right amplitudes: a random-phase surrogate."""
    shape = (256, 256)
    frequency = np.hypot(np.fft.fftfreq(256)[:, None], np.fft.rfftfreq(256)[None, :])
    wanted = np.exp(-((frequency / 0.2) ** 2))
    wanted[0, 0] = 0.0
    phases = np.angle(np.fft.rfft2(np.random.default_rng(5).normal(size=shape)))
    start = wanted * np.exp(1j * phases)
    field = np.fft.irfft2(start, s=shape)
    level = (np.arange(field.size) + 0.5) / field.size
    adjusted = adjust_amplitudes(start, shape, ndtri(level) * field.std(), wanted, 3)
    assert adjusted.misfit[0] < 0.02
    result = np.fft.irfft2(adjusted.coefficients, s=shape)
    assert np.corrcoef(result.ravel(), field.ravel())[0, 1] > 0.999


def test_a_tolerance_ends_the_iteration():
    shape = (64, 64)
    image = cloudy_image(shape)
    start = np.fft.rfft2(np.random.default_rng(6).normal(size=shape))
    amplitudes, wanted = np.sort(image, axis=None), np.abs(np.fft.rfft2(image))
    every = adjust_amplitudes(start, shape, amplitudes, wanted, 60)
    ended = adjust_amplitudes(start, shape, amplitudes, wanted, 60, tolerance=0.05)
    count = len(ended.misfit)
    assert 2 <= count < 60
    assert ended.misfit == every.misfit[:count]
    steps = [1.0 - later / before for before, later in zip(every.misfit, every.misfit[1:], strict=False)]
    assert min(steps[: count - 2]) >= 0.05 > steps[count - 2]


def test_what_does_not_fit_is_refused():
    good = np.ones((8, 5), dtype=complex)
    with pytest.raises(ValueError, match=r"start: shape \(8, 4\) given, allowed: \(8, 5\)"):
        adjust_amplitudes(good[:, :4], (8, 8), np.arange(64.0), np.ones((8, 5)), 1)
    with pytest.raises(ValueError, match="magnitude: all 0 given"):
        adjust_amplitudes(good, (8, 8), np.arange(64.0), np.zeros((8, 5)), 1)
    with pytest.raises(ValueError, match="amplitudes: shape"):
        adjust_amplitudes(good, (8, 8), np.arange(63.0), np.ones((8, 5)), 1)
