"""Photons against closed forms and scipy's quadrature and constants."""

import numpy as np
import pytest
from hcss_pyxel.airy import airy_kernel
from hcss_pyxel.radiometry import black_body_wavelength_um, etendue_m2_sr, photons
from scipy import constants
from scipy.integrate import quad


def test_etendue_is_area_of_the_aperture_times_solid_angle_of_the_pixel():
    diameter, focal_length, pitch = 0.1, 0.25, 15e-6
    aperture = np.pi / 4 * diameter**2
    assert etendue_m2_sr(pitch**2, focal_length / diameter) == pytest.approx(aperture * (pitch / focal_length) ** 2)


def test_a_watt_of_one_wavelength_is_its_photons():
    per_photon = constants.h * constants.c / 4e-6
    assert photons(np.array([2.0]), 3.0, 0.5, 4.0)[0] == pytest.approx(3.0 / per_photon, rel=1e-9)


@pytest.mark.parametrize("limits_um", [(2.7, 3.0), (3.0, 5.0), (8.0, 14.0)])
@pytest.mark.parametrize("temperature_K", [150.3, 288.15, 600.7])
def test_photons_of_a_black_body_are_counted_exactly(limits_um, temperature_K):
    def per_m(wavelength):
        x = constants.h * constants.c / (wavelength * constants.k * temperature_K)
        return 2 * constants.h * constants.c**2 / wavelength**5 / np.expm1(x)

    low, high = (limit * 1e-6 for limit in limits_um)
    energy = quad(per_m, low, high, epsrel=1e-10, epsabs=0)[0]
    count = quad(lambda w: per_m(w) * w / (constants.h * constants.c), low, high, epsrel=1e-10, epsabs=0)[0]
    mean = black_body_wavelength_um(np.array([energy]), *limits_um)
    assert photons(np.array([energy]), 1.0, 1.0, mean)[0] == pytest.approx(count, rel=1e-5)


def test_what_is_brighter_than_any_body_of_the_table_is_refused():
    with pytest.raises(ValueError, match="above that of a black body of 1000 K"):
        black_body_wavelength_um(np.array([1e6]), 3.0, 5.0)


def test_darkness_has_a_wavelength_in_the_band():
    assert 3.0 < black_body_wavelength_um(np.array([0.0]), 3.0, 5.0)[0] < 5.0


def test_energy_within_a_radius_of_the_airy_pattern_is_that_of_the_closed_form():
    """1 - J0^2(v) - J1^2(v) (Born and Wolf, section 8.5.2), here within the square of the kernel's core."""
    from scipy.special import j0, j1

    # a fine pitch, so that a disc can be cut out of pixels
    kernel = airy_kernel(4.0, 2.0, 0.4, radius=50)
    places = (np.arange(101) - 50) * 0.4
    inside = np.hypot(places[:, None], places[None, :]) <= 1.22 * 4.0 * 2.0
    v, edge = np.pi * 1.22, np.pi * 50.5 * 0.4 / 8.0
    whole = 1 - j0(edge) ** 2 - j1(edge) ** 2
    # the kernel is a square of half side `edge`: its sum lies between the discs inside and around it
    outer = 1 - j0(edge * np.sqrt(2)) ** 2 - j1(edge * np.sqrt(2)) ** 2
    expected = 1 - j0(v) ** 2 - j1(v) ** 2
    assert expected / outer - 0.003 < kernel[inside].sum() < expected / whole + 0.003
    assert kernel.sum() == pytest.approx(1.0, abs=1e-12)
