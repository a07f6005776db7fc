"""Spectra and anisotropies of fields whose spectrum is known."""

import numpy as np
import pytest
from fractional_brownian_surface import fractional_brownian_surface
from hcss_evaluate.measures.power_spectrum import mean_spectrum, power_spectrum, spectral_distance_db

from hcss_twin.core.errors import ImageError


def noise(seed, shape=(256, 256)):
    return np.random.default_rng(seed).standard_normal(shape)


def stretched(angle_deg, ratio=4.0, seed=0, size=256):
    """Filtered noise whose structures are ``ratio`` times as long along ``angle_deg`` as across."""
    ky, kx = np.meshgrid(np.fft.fftfreq(size), np.fft.fftfreq(size), indexing="ij")
    angle = np.radians(angle_deg)
    along, across = kx * np.cos(angle) + ky * np.sin(angle), -kx * np.sin(angle) + ky * np.cos(angle)
    amplitude = (0.01**2 + ratio * along**2 + across**2 / ratio) ** -0.75
    return np.fft.ifft2(np.fft.fft2(noise(seed, (size, size))) * amplitude).real


def slope(spectrum, low=0.02, high=0.15):
    chosen = (spectrum.wavenumber > low) & (spectrum.wavenumber < high)
    return np.polyfit(np.log(spectrum.wavenumber[chosen]), np.log(spectrum.power[chosen]), 1)[0]


def test_the_density_of_white_noise_is_its_variance_at_every_wavenumber():
    found = mean_spectrum([power_spectrum(3.0 * noise(seed)) for seed in range(12)])
    # Of n waves in a ring (of which the taper leaves about a quarter independent) the mean scatters as n^-1/2.
    tolerance = 4.0 * np.sqrt(4.0 / (12 * found.waves))
    chosen = found.wavenumber > 3.0 / 256
    assert np.all(abs(found.power / 9.0 - 1.0)[chosen] < tolerance[chosen])


@pytest.mark.parametrize("hurst", [0.3, 0.7])
def test_the_spectrum_of_a_fractional_brownian_surface_falls_as_k_to_minus_2h_minus_2(hurst):
    found = mean_spectrum([power_spectrum(fractional_brownian_surface(256, hurst, seed)) for seed in range(6)])
    assert slope(found) == pytest.approx(-2.0 * hurst - 2.0, abs=0.12)


def test_rings_do_not_depend_on_the_shape_and_the_integral_is_the_variance():
    field = noise(1, (96, 160))
    found = power_spectrum(field)
    assert found.wavenumber[-1] < 0.5
    # Area of the half plane below the Nyquist wavenumber, for white noise.
    assert np.sum(found.power * found.waves) * 2 / field.size == pytest.approx(np.pi / 4, rel=0.05)


@pytest.mark.parametrize("angle", [0.0, 30.0, 90.0, 135.0])
def test_the_long_axis_is_the_one_that_was_built_in(angle):
    found = power_spectrum(stretched(angle))
    assert found.degree > 5 * found.degree_noise
    assert (found.long_axis_deg - angle + 90.0) % 180.0 - 90.0 == pytest.approx(0.0, abs=5.0)
    across = found.direction_deg[np.argmax(found.by_direction)]
    assert (across - angle) % 180.0 == pytest.approx(90.0, abs=16.0)


def test_exchanging_the_axes_turns_the_long_axis_and_nothing_else():
    field = stretched(20.0)
    one, other = power_spectrum(field), power_spectrum(field.T)
    np.testing.assert_allclose(other.power, one.power, rtol=1e-9)
    assert other.degree == pytest.approx(one.degree, rel=1e-9)
    assert (one.long_axis_deg + other.long_axis_deg) % 180.0 == pytest.approx(90.0, abs=1e-6)


def test_the_degree_of_isotropic_noise_is_the_one_that_is_told():
    found = [power_spectrum(noise(seed, (128, 128))) for seed in range(40)]
    rms = np.sqrt(np.mean([spectrum.degree**2 for spectrum in found]))
    assert rms == pytest.approx(found[0].degree_noise, rel=0.3)
    mean = mean_spectrum(found)
    assert mean.degree < 0.5 * rms


def test_the_distance_of_a_field_from_its_double_is_six_decibels_and_from_itself_none():
    field = stretched(0.0)
    one = power_spectrum(field)
    assert spectral_distance_db(one, power_spectrum(2.0 * field)) == pytest.approx(20 * np.log10(2.0))
    assert spectral_distance_db(one, one) == 0.0


def test_the_distance_does_not_need_images_of_one_size():
    one = mean_spectrum([power_spectrum(noise(seed, (128, 128))) for seed in range(8)])
    other = mean_spectrum([power_spectrum(noise(seed, (256, 200))) for seed in range(8)])
    assert spectral_distance_db(one, other) < 1.0
    assert mean_spectrum([power_spectrum(noise(0, (64, 64))), power_spectrum(noise(0, (64, 96)))]) is None
    assert mean_spectrum([]) is None


@pytest.mark.parametrize("field", [np.ones((40, 40)), np.add.outer(np.arange(40.0), np.arange(40.0))])
def test_images_without_a_spectrum_are_refused(field):
    with pytest.raises(ImageError):
        power_spectrum(field)
