"""Laws of the power spectra in reports."""

import numpy as np
import pytest

from hcss_twin.reporting.cube_report.radial_spectrum import mean_spectrum, radial_spectrum


def test_the_spectrum_of_white_noise_is_its_variance_times_the_area_of_a_pixel():
    images = np.random.default_rng(1).normal(5.0, 2.0, (12, 96, 128))
    found = mean_spectrum(images, 200.0)
    assert found.power.mean() == pytest.approx(4.0 * 0.2**2, rel=0.02)
    assert found.power[5:].std() / found.power.mean() < 0.15
    assert found.cycles_per_km[-1] == pytest.approx(0.5 / 0.2, rel=0.02)


@pytest.mark.parametrize(("across", "along"), [(12, 0), (0, 12), (9, 8)])
def test_a_wave_is_a_peak_at_its_wavenumber_whatever_its_direction(across, along):
    y, x = np.mgrid[:120, :120]
    found = radial_spectrum(np.sin(2 * np.pi * (across * x + along * y) / 120), 50.0)
    expected = np.hypot(across, along) / (120 * 0.05)
    assert found.cycles_per_km[np.argmax(found.power)] == pytest.approx(expected, rel=0.04)


def test_images_without_a_spectrum_have_none_and_do_not_count():
    noise = np.random.default_rng(2).random((20, 20))
    gap = noise.copy()
    gap[3, 4] = np.nan
    for image in (np.ones((20, 20)), gap, noise[:7]):
        assert radial_spectrum(image, 1.0) is None
    np.testing.assert_array_equal(
        mean_spectrum([np.ones((20, 20)), noise], 1.0).power, radial_spectrum(noise, 1.0).power
    )
