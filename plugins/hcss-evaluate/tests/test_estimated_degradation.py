"""Blur and noise that are found in an image are those that were put into it."""

import numpy as np
import pytest
from hcss_evaluate.measures.degradation import estimate_degradation
from sample_data import sample_file

from hcss_twin.core.errors import ImageError


def degraded(seed, slope, sigma, noise, side=128):
    """Power-law scene of unit variance, blurred in the Fourier domain and cut out of a larger one, with white noise."""
    random = np.random.default_rng(seed)
    size = 2 * side
    k = np.hypot(np.fft.fftfreq(size)[:, None], np.fft.rfftfreq(size))
    k[0, 0] = 1.0
    spectrum = np.fft.rfft2(random.standard_normal((size, size))) * k ** (-slope / 2.0)
    spectrum[0, 0] = 0.0
    scale = np.fft.irfft2(spectrum).std()
    image = np.fft.irfft2(spectrum * np.exp(-2.0 * (np.pi * sigma * k) ** 2))[:side, :side] / scale
    return image + noise * random.standard_normal(image.shape)


@pytest.mark.parametrize(("slope", "sigma"), [(2.2, 0.8), (3.0, 1.2), (2.5, 2.0)])
@pytest.mark.parametrize("noise", [0.003, 0.02])
def test_known_blur_and_noise_of_a_power_law_scene_are_found(slope, sigma, noise):
    found = [estimate_degradation(degraded(seed, slope, sigma, noise)) for seed in range(4)]
    for name, error, true in (("blur_sigma_pixels", "blur_error", sigma), ("noise", "noise_error", noise)):
        values = np.array([getattr(estimate, name) for estimate in found])
        stated = np.array([getattr(estimate, error) for estimate in found])
        assert values.mean() == pytest.approx(true, rel=0.06)
        assert np.all(np.abs(values - true) < 4.0 * stated)


def test_without_blur_none_is_found():
    found = estimate_degradation(degraded(1, 3.0, 0.0, 0.02))
    assert found.blur_sigma_pixels < 0.35


def test_blur_and_noise_do_not_depend_on_unit_and_offset():
    image = degraded(3, 2.5, 1.5, 0.01)
    one, other = estimate_degradation(image), estimate_degradation(280.0 + 40.0 * image)
    assert other.blur_sigma_pixels == pytest.approx(one.blur_sigma_pixels, rel=1e-3)
    assert other.noise == pytest.approx(40.0 * one.noise, rel=1e-3)


def test_blur_added_to_a_measured_image_is_found_as_a_difference_of_squares():
    import netCDF4
    from scipy.ndimage import gaussian_filter

    with netCDF4.Dataset(sample_file("seviri/sea-blocks-*.nc")) as file:
        image = np.ma.filled(file["ir_108"][0, 0], np.nan).astype(np.float64)
    noise = 0.2
    random = np.random.default_rng(1)
    before, after = (
        estimate_degradation(gaussian_filter(image, sigma, truncate=6.0) + noise * random.standard_normal(image.shape))
        for sigma in (1.0, 1.8)
    )
    added = after.blur_sigma_pixels**2 - before.blur_sigma_pixels**2
    assert added == pytest.approx(1.8**2 - 1.0**2, rel=0.15)
    assert after.noise == pytest.approx(noise, rel=0.05)


def test_a_sharp_image_of_the_same_kind_replaces_the_power_law():
    def stepped(seed, sigma, noise):
        """Noise whose power falls in three steps, a factor of 300 each, instead of with a slope."""
        k = np.hypot(np.fft.fftfreq(256)[:, None], np.fft.rfftfreq(256))
        random = np.random.default_rng(seed)
        amplitude = 300.0 ** (-0.5 * np.searchsorted([0.03, 0.06, 0.12], k))
        spectrum = np.fft.rfft2(random.standard_normal((256, 256))) * amplitude
        image = np.fft.irfft2(spectrum * np.exp(-2.0 * (np.pi * sigma * k) ** 2))
        return image + noise * random.standard_normal(image.shape)

    sharp = stepped(10, 0.0, 0.0)
    images = [stepped(seed, 1.2, 1e-4) for seed in range(4)]
    found = [estimate_degradation(image, sharp) for image in images]
    for estimate in found:
        assert abs(estimate.blur_sigma_pixels - 1.2) < 4.0 * estimate.blur_error < 0.25
        assert estimate.noise == pytest.approx(1e-4, rel=0.02)
        assert estimate.slope == 0.0
    misled = [estimate_degradation(image) for image in images]
    assert all(abs(estimate.blur_sigma_pixels - 1.2) > 1.0 for estimate in misled)
    with pytest.raises(ImageError, match=r"scene: \(256, 255\) pixels given, allowed: \(256, 256\)"):
        estimate_degradation(images[0], sharp[:, 1:])


def test_an_image_without_deviations_has_no_degradation_to_find():
    with pytest.raises(ImageError, match="plane"):
        estimate_degradation(np.add.outer(np.arange(80.0), np.arange(80.0)))
