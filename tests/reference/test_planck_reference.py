import numpy as np
import pytest
from scipy import constants, integrate

from hcss_twin.physics.planck import BOLTZMANN_J_K, PLANCK_J_S, SPEED_OF_LIGHT_M_S, planck, wavenumber_from_um


@pytest.mark.parametrize("temperature", [150.0, 288.15, 350.0, 5772.0])
def test_integral_over_all_wavenumbers_is_stefan_boltzmann(temperature):
    total, _ = integrate.quad(lambda v: planck(np.array([v]), temperature)[0], 1e-3, 40 * temperature, limit=500)
    assert total == pytest.approx(constants.sigma * temperature**4 / np.pi, rel=1e-8)


@pytest.mark.parametrize("temperature", [200.0, 300.0])
def test_peak_follows_wien(temperature):
    wavenumber = np.linspace(50, 3000, 2_950_001)
    peak = wavenumber[np.argmax(planck(wavenumber, temperature))]
    # Wien's displacement in wavenumber: 1.9609969 cm-1 K-1 (CODATA 5.878925757e10 Hz/K over c).
    assert peak / temperature == pytest.approx(5.878925757e10 / constants.c / 100, rel=1e-5)


def test_agrees_with_the_wavelength_form():
    wavelength, temperature = 10e-6, 300.0
    per_m = 2 * constants.h * constants.c**2 / wavelength**5
    per_m /= np.expm1(constants.h * constants.c / (wavelength * constants.k * temperature))
    wavenumber = wavenumber_from_um(np.array([10.0]))
    # B per m = B per cm-1 x |d nu / d lambda|, nu in cm-1: 1e-2 / lambda^2.
    assert planck(wavenumber, temperature)[0] * 1e-2 / wavelength**2 == pytest.approx(per_m, rel=1e-12)


def test_cold_and_short_gives_zero_without_warning():
    assert planck(np.array([14_000.0]), 20.0)[0] == pytest.approx(0.0, abs=1e-300)


def test_constants_are_those_of_codata():
    assert (constants.h, constants.c, constants.k) == (PLANCK_J_S, SPEED_OF_LIGHT_M_S, BOLTZMANN_J_K)
