"""Spectra of waves, fields of resolved slopes, and the bounds on what they change."""

import numpy as np
import pytest
from scipy.special import exp1

from hcss_twin.core.catalog import Catalog
from hcss_twin.models.parameters import RoughSeaParameters
from hcss_twin.models.sea import plane_waves, wave_spectrum
from hcss_twin.models.sea.rough_sea import RoughSea
from hcss_twin.models.sea.slope_statistics import resolved_variances
from hcss_twin.models.sea.wave_field import WaveField, cutoff_frequency_rad_s, thermal_contrast_bound
from hcss_twin.models.sea.wave_spectrum import WaveSpectrum
from hcss_twin.providers import SeaInputs

PM, JONSWAP = WaveSpectrum("pierson-moskowitz", 10.0), WaveSpectrum("jonswap", 10.0, 50e3)


def test_jonswap_without_its_peak_is_the_closed_form():
    """For gamma = 3.3 the variance is alpha g^2 / (5 omega_p^4) / (1 - 0.287 ln gamma) (DNV-RP-C205, 3.5.5)."""
    peak = wave_spectrum.peak_frequency_rad_s(10.0, 50e3)
    alpha = 0.076 * (100.0 / (9.81 * 50e3)) ** 0.22
    expected = alpha * 9.81**2 / (5.0 * peak**4) / (1.0 - 0.287 * np.log(3.3))
    assert JONSWAP.significant_wave_height_m**2 / 16.0 == pytest.approx(expected, rel=0.01)


def test_jonswap_peaks_at_its_peak_and_grows_with_fetch():
    omega = np.linspace(0.3, 4.0, 20_000)
    density = wave_spectrum.spectrum_m2_s(omega, 10.0, 50e3)
    assert omega[np.argmax(density)] == pytest.approx(wave_spectrum.peak_frequency_rad_s(10.0, 50e3), rel=1e-3)
    heights = [WaveSpectrum("jonswap", 10.0, f).significant_wave_height_m for f in (1e4, 5e4, 1e5)]
    assert np.all(np.diff(heights) > 0.2)


@pytest.mark.parametrize(("wind", "fetch"), [(-1.0, 1e5), (np.nan, 1e5), (5.0, 0.0), (5.0, np.inf)])
def test_jonswap_refuses_what_cannot_be(wind, fetch):
    with pytest.raises(ValueError, match="allowed"):
        wave_spectrum.spectrum_m2_s(np.ones(1), wind, fetch)


def test_resolved_slope_agrees_with_the_closed_form():
    for cutoff in (0.8, 1.24, 5.0):
        # alpha/4 E1(beta (g / (U cutoff))^4), E1 the exponential integral
        expected = 0.25 * 8.1e-3 * exp1(0.74 * (9.81 / (10.0 * cutoff)) ** 4)
        assert PM.resolved_mean_square_slope(cutoff) == pytest.approx(expected, rel=1e-5)


def test_frequencies_share_the_slope_equally():
    edges = PM.slope_frequencies_rad_s(8, 3.0)
    parts = [PM.resolved_mean_square_slope(omega) for omega in edges]
    total = PM.resolved_mean_square_slope(3.0)
    np.testing.assert_allclose(np.array(parts) / total, (np.arange(8) + 0.5) / 8, atol=1e-3)


@pytest.mark.parametrize("spectrum", [PM, JONSWAP], ids=["pierson-moskowitz", "jonswap"])
def test_the_field_has_the_resolved_slope_and_the_height_of_its_spectrum(spectrum):
    field = WaveField(spectrum, 30.0, 5.0, seed=1)
    window = slice(0, 300), slice(-100, 300)
    along, down = field.slopes(0.0, *window)
    assert along.shape == down.shape == (300, 400)
    assert along.var() + down.var() == pytest.approx(field.resolved_mean_square_slope, rel=0.05)
    elevation = field.elevation_m(0.0, *window)
    assert 4.0 * elevation.std() == pytest.approx(spectrum.significant_wave_height_m, rel=0.1)


def test_slopes_are_the_derivatives_of_the_elevation():
    # Pixels resolve waves of two pixels; the field of coarse pixels is smooth on its own grid's fraction.
    field = WaveField(PM, 0.0, 20.0, seed=2, components=64)
    field.pixel_size_m = 0.5
    elevation = field.elevation_m(3.0, slice(0, 40), slice(0, 40))
    along, down = field.slopes(3.0, slice(0, 40), slice(0, 40))
    np.testing.assert_allclose(np.gradient(elevation, 0.5, axis=1)[:, 1:-1], along[:, 1:-1], atol=1e-4)
    np.testing.assert_allclose(np.gradient(elevation, 0.5, axis=0)[1:-1], down[1:-1], atol=1e-4)


def test_one_wave_travels_downwind_with_the_speed_of_deep_water():
    field = WaveField(PM, 270.0, 5.0, seed=3, components=1)
    omega = float(field.frequency_rad_s[0])
    speed = 9.81 / omega
    # The crests move along the wave's own direction, within a quarter turn of downwind (east: columns).
    k = np.array([field.k_x_rad_m[0], field.k_y_rad_m[0]])
    assert k[0] > 0.0
    assert np.hypot(*k) == pytest.approx(omega**2 / 9.81, rel=1e-12)
    shift = 7 * 5.0 * k[0] / np.hypot(*k) / speed
    before = field.elevation_m(0.0, slice(0, 1), slice(0, 60))
    after = field.elevation_m(shift, slice(0, 1), slice(7, 67))
    np.testing.assert_allclose(after, before, atol=1e-9)


def test_a_window_across_tiles_equals_the_same_part_of_the_whole():
    field = WaveField(JONSWAP, 200.0, 10.0, seed=4)
    whole = field.slopes(12.0, slice(-40, 70), slice(-300, 300))
    for rows, columns in (((-40, -31), (-300, 300)), ((-1, 33), (-3, 258)), ((5, 6), (255, 256)), ((31, 70), (0, 9))):
        part = field.slopes(12.0, slice(*rows), slice(*columns))
        expected = whole[:, rows[0] + 40 : rows[1] + 40, columns[0] + 300 : columns[1] + 300]
        np.testing.assert_array_equal(part, expected)


@pytest.mark.parametrize("components", [1, 512])
@pytest.mark.parametrize(("pixel", "row", "column"), [(1.0, -20, 200), (30.0, 10**6, -(10**6))])
def test_slopes_are_the_sum_of_the_sines_of_all_waves(components, pixel, row, column):
    """Against the sum term by term, in double precision: everywhere in a tile, and far from the origin."""
    field = WaveField(PM, 40.0, pixel, seed=6, components=components)
    rows, columns = np.arange(row, row + 40), np.arange(column, column + 300)
    found = field.slopes(2.5, slice(row, row + 40), slice(column, column + 300), 7.7)
    k_y, k_x = field.k_y_rad_m, field.k_x_rad_m
    along = np.exp(1j * (np.outer(k_x * pixel, columns + 0.5) + (k_x * 7.7)[:, None]))
    down = np.exp(1j * (np.outer(rows + 0.5, k_y * pixel) + field.phase_rad - 2.5 * field.frequency_rad_s))
    scale = np.sqrt(field.resolved_mean_square_slope)
    steepest = scale * np.sqrt(2.0 / components)  # of each wave: all have the same mean-square slope
    for slopes, k in zip(found, (k_x, k_y), strict=True):
        expected = -steepest * ((down * k / np.hypot(k_x, k_y)) @ along).imag
        np.testing.assert_allclose(slopes, expected, rtol=0.0, atol=plane_waves.ERROR * scale)


def test_waves_of_the_field_have_the_spectrum():
    """Elevation along time at one point: the periodogram summed in bands is the spectrum's integral."""
    field = WaveField(PM, 0.0, 5.0, seed=5, components=512)
    times = np.arange(0.0, 1600.0, 0.8)
    series = np.array([field.elevation_m(time, slice(0, 1), slice(0, 1))[0, 0] for time in times])
    power = np.abs(np.fft.rfft(series)) ** 2 * 2.0 / times.size**2
    omega = 2.0 * np.pi * np.fft.rfftfreq(times.size, 0.8)
    fine = np.linspace(0.6, 2.0, 4000)
    for low, high in ((0.6, 0.9), (0.9, 1.3), (1.3, 2.0)):
        expected = PM.density_m2_s(fine)[(fine >= low) & (fine < high)].sum() * (fine[1] - fine[0])
        assert power[(omega >= low) & (omega < high)].sum() == pytest.approx(expected, rel=0.25)


def test_a_calm_sea_is_flat():
    field = WaveField(WaveSpectrum("jonswap", 0.0), 0.0, 5.0, seed=1)
    assert field.resolved_mean_square_slope == 0.0
    assert np.all(field.slopes(1.0, slice(0, 3), slice(0, 4))[0] == np.zeros((3, 4)))
    assert WaveSpectrum("jonswap", 0.0).significant_wave_height_m == 0.0


def test_the_bound_holds_for_tilts_of_three_deviations_and_shrinks_with_the_pixel():
    sea = RoughSea(SeaInputs(10.0, 0.0, 290.0, Catalog()), RoughSeaParameters(foam=False))
    wavenumber, mu = 1e4 / np.array([10.8, 3.7]), np.cos(np.radians([0.0, 20.0, 40.0]))
    bounds = [
        thermal_contrast_bound(sea, wavenumber, mu, resolved_variances(PM, p)[0] ** 0.5) for p in (5.0, 20.0, 100.0)
    ]
    assert np.all(bounds[0] > bounds[1])
    assert np.all(bounds[1] > bounds[2])
    level = sea.emissivity(wavenumber, mu)
    for degrees in (-6.0, 3.0, 6.0):  # 20 m: three deviations are 6.4 degrees
        tilted = sea.emissivity(wavenumber, np.cos(np.arccos(mu) + np.radians(degrees)))
        assert np.all(np.abs(tilted / level - 1.0) <= bounds[1])
    assert np.all(thermal_contrast_bound(sea, wavenumber, mu, resolved_variances(PM, 5.0)[0] ** 0.5, 1.0) == 0.0)


@pytest.mark.parametrize("pixel", [0.0, -1.0, np.nan])
def test_a_pixel_needs_a_size(pixel):
    with pytest.raises(ValueError, match="pixel_size_m"):
        cutoff_frequency_rad_s(pixel)
