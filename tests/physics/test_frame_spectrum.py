"""Laws of the power spectra in reports of cubes."""

import numpy as np
import pytest

from hcss_twin.reports.cube_frames import frame_spectrum


def test_the_spectrum_of_white_noise_is_its_variance_times_the_area_of_a_pixel():
    images = np.random.default_rng(1).normal(5.0, 2.0, (12, 96, 128))
    found = frame_spectrum(images, 200.0)
    assert found.power[3:].mean() == pytest.approx(4.0 * 0.2**2, rel=0.05)
    assert 0.4 / 0.2 < found.cycles_per_km[-1] < 0.5 / 0.2


@pytest.mark.parametrize(("across", "along"), [(12, 0), (0, 12), (9, 8)])
def test_a_wave_is_a_peak_at_its_wavenumber_whatever_its_direction(across, along):
    y, x = np.mgrid[:120, :120]
    found = frame_spectrum([np.sin(2 * np.pi * (across * x + along * y) / 120)], 50.0)
    expected = np.hypot(across, along) / (120 * 0.05)
    # rings are a quarter of an octave wide
    assert found.cycles_per_km[np.argmax(found.power)] == pytest.approx(expected, rel=0.1)


def test_images_without_a_spectrum_have_none_and_do_not_count():
    noise = np.random.default_rng(2).random((40, 40))
    gap = noise.copy()
    gap[3, 4] = np.nan
    for image in (np.ones((40, 40)), gap, noise[:31]):
        assert frame_spectrum([image], 1.0) is None
    np.testing.assert_array_equal(
        frame_spectrum([np.ones((40, 40)), gap, noise], 1.0).power, frame_spectrum([noise], 1.0).power
    )
