"""The height spectrum against quadrature, and realisations against the spectrum."""

import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad

from hcss_twin.models.sea import pierson_moskowitz as pm


def spectrum(omega: float, wind: float) -> float:
    return float(pm.spectrum_m2_s(np.array([omega]), wind)[0])


def test_eq_1_at_a_frequency_worked_by_hand() -> None:
    # U = 9.81 and omega = 1: alpha g^2 exp(-beta)
    assert spectrum(1.0, 9.81) == pytest.approx(8.1e-3 * 96.2361 * 0.4771139155, rel=1e-9)


@pytest.mark.parametrize("wind", [5.0, 10.0, 20.0])
def test_variance_is_the_integral_of_the_spectrum(wind: float) -> None:
    peak = pm.peak_frequency_rad_s(wind)
    body, _ = quad(spectrum, 0.2 * peak, 3.0 * peak, (wind,), epsabs=0.0, epsrel=1e-9)
    tail, _ = quad(spectrum, 3.0 * peak, math.inf, (wind,), epsabs=0.0, epsrel=1e-8)
    assert pm.elevation_variance_m2(wind) == pytest.approx(body + tail, rel=1e-7)


def test_significant_wave_height_is_2_13_m_at_10_m_per_s() -> None:
    assert pm.significant_wave_height_m(10.0) == pytest.approx(2.13, abs=0.005)
    # The usual rule for a fully developed sea, 0.21 U^2 / g.
    assert pm.significant_wave_height_m(15.0) == pytest.approx(0.21 * 225.0 / 9.81, rel=0.01)


@pytest.mark.parametrize("wind", [5.0, 10.0, 15.0])
def test_spectrum_peaks_where_the_closed_form_says(wind: float) -> None:
    # omega_p = 0.877 g / U, the usual rounding of (4 beta / 5)^(1/4)
    omega = np.linspace(0.1, 4.0, 39001)
    top = omega[int(np.argmax(pm.spectrum_m2_s(omega, wind)))]
    assert pm.peak_frequency_rad_s(wind) == pytest.approx(top, abs=1e-4)
    assert top == pytest.approx(0.877 * 9.81 / wind, rel=1e-3)


def test_resolved_slope_is_the_fourth_moment_up_to_the_cutoff() -> None:
    expected, _ = quad(lambda omega: omega**4 / 9.81**2 * spectrum(omega, 10.0), 0.1, 6.0, epsrel=1e-9)
    assert pm.resolved_mean_square_slope(10.0, 6.0) == pytest.approx(expected, rel=1e-8)


def test_components_share_the_variance_as_the_spectrum_does() -> None:
    omega = pm.component_frequencies_rad_s(10.0, 2000)
    edges = np.array([0.5, 0.8, 1.0, 1.5, 2.5])
    counted = np.histogram(omega, edges)[0] / 2000
    integrals = [quad(spectrum, a, b, (10.0,))[0] for a, b in pairwise(edges)]
    np.testing.assert_allclose(counted, np.array(integrals) / pm.elevation_variance_m2(10.0), atol=1e-3)


def test_elevations_have_the_spectrums_variance_and_are_gaussian() -> None:
    # Points scattered over 1000 km are independent samples of the one surface.
    x, y = np.random.default_rng(2).uniform(0.0, 1e6, (2, 20_000))
    elevation = pm.surface_elevation(x, y, 0.0, 10.0, 240.0, seed=4, components=200)
    sigma = math.sqrt(pm.elevation_variance_m2(10.0))
    assert elevation.var() == pytest.approx(sigma**2, rel=4.0 * math.sqrt(2.0 / elevation.size))
    assert elevation.mean() == pytest.approx(0.0, abs=4.0 * sigma / math.sqrt(elevation.size))
    assert np.mean(elevation**4) == pytest.approx(3.0 * elevation.var() ** 2, rel=0.1)


def test_slopes_split_three_to_one_between_downwind_and_crosswind() -> None:
    # The mean of cos^2 over the density 2/pi cos^2 is 3/4. Few waves of one surface carry most of its slope
    # (about 7 of 50), so it takes many surfaces.
    x, y = np.random.default_rng(6).uniform(0.0, 1e6, (2, 300))
    step, surfaces, downwind, crosswind = 0.01, 100, 0.0, 0.0
    for seed in range(surfaces):
        here, east, north = (
            pm.surface_elevation(x + dx, y + dy, 0.0, 10.0, 270.0, seed=seed, components=50)
            for dx, dy in ((0.0, 0.0), (step, 0.0), (0.0, step))
        )
        downwind += float(np.mean((east - here) ** 2)) / step**2 / surfaces
        crosswind += float(np.mean((north - here) ** 2)) / step**2 / surfaces
    omega = pm.component_frequencies_rad_s(10.0, 50)
    total = pm.elevation_variance_m2(10.0) * np.mean(omega**4) / 9.81**2
    assert downwind + crosswind == pytest.approx(total, rel=0.03)
    assert downwind / (downwind + crosswind) == pytest.approx(0.75, abs=0.03)


def test_undulation_of_a_patch_at_10_m_per_s_is_the_2_5_m_of_the_paper() -> None:
    """The HCSS paper's largest undulation, around 2.5 m (text on Fig 10), as crest to trough in 100 m."""
    axis = np.linspace(0.0, 100.0, 41)
    ranges = [
        np.ptp(pm.surface_elevation(axis, axis[:, None], 0.0, 10.0, 270.0, seed=seed, components=200))
        for seed in range(15)
    ]
    assert np.median(ranges) == pytest.approx(2.5, abs=0.5)
