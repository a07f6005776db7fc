"""The height spectrum against quadrature."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

from hcss_twin.models.sea import pierson_moskowitz as pm
from hcss_twin.models.sea.wave_spectrum import WaveSpectrum


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
    found = WaveSpectrum("pierson-moskowitz", 10.0).resolved_mean_square_slope(6.0)
    assert found == pytest.approx(expected, rel=1e-5)
