"""Mean wavelengths of a scene's light in its bands."""

from dataclasses import replace

import numpy as np
import pytest
from hcss_pyxel.mean_wavelength import MeanWavelength, mean_wavelengths, mean_wavelengths_of
from scipy import constants
from scipy.integrate import quad

from hcss_twin import Scenario, column_spectra, simulate

CHEAP = {"radiance.model": "as-printed", "sea.model": "cox-munk", "optics.provider": "mie"}
SMALL = {"image.rows": 16, "image.columns": 16, "frames.count": 1, **CHEAP}
NIGHT = {"time": "2024-04-20T23:30:00+10:00"}


def mean_of_black_body(temperature_K, lower_um, upper_um):
    """The integral of lambda L over that of L, by scipy."""

    def spectrum(wavelength_um):
        x = constants.h * constants.c / (wavelength_um * 1e-6 * constants.k * temperature_K)
        return wavelength_um**-5 / np.expm1(x)

    energy = quad(spectrum, lower_um, upper_um, epsrel=1e-10)[0]
    return (
        quad(lambda wavelength_um: wavelength_um * spectrum(wavelength_um), lower_um, upper_um, epsrel=1e-10)[0]
        / energy
    )


@pytest.mark.parametrize("band", [[2.7, 3.0], [3.0, 5.0], [8.0, 14.0]])
def test_an_isothermal_enclosure_has_the_mean_wavelength_of_planck(band):
    """Everything at one temperature: the model's spectra are replaced by those of a black body."""
    from hcss_twin.providers import planck

    columns = column_spectra(Scenario.load("stratus", {**SMALL, **NIGHT, "bands": [band]}))
    enclosed = np.broadcast_to(planck(columns.wavenumber_cm1, 290.0), columns.radiance.shape)
    (found,) = mean_wavelengths(replace(columns, radiance=enclosed))
    # the scene's grid of wavenumbers sums each band to some 1e-5
    np.testing.assert_allclose(found.wavelength_um, mean_of_black_body(290.0, *band), rtol=5e-5)


def test_sunlight_shortens_the_mean_wavelength_and_thick_cloud_hides_the_gas_below():
    by_day, by_night = (
        mean_wavelengths(column_spectra(Scenario.load("stratus", {**SMALL, "bands": ["mwir"], **when})))[0]
        for when in ({}, NIGHT)
    )
    assert np.all(by_day.wavelength_um < by_night.wavelength_um)
    # an opaque cloud at night is nearly a black body seen through the gas above it
    assert by_night.wavelength_um[-1] == pytest.approx(mean_of_black_body(282.0, 3.0, 5.0), rel=0.02)


def test_the_mean_wavelength_of_an_image_counts_its_photons():
    known = MeanWavelength("b", np.array([2.0, 1.0]), np.array([4.0, 5.0]))
    radiance = np.array([[1.0, 2.0], [1.5, 0.5]])
    photons = 1.0 * 5.0 + 2.0 * 4.0 + 1.5 * 4.5 + 0.5 * 5.0
    assert known.of_image(radiance) * radiance.sum() == pytest.approx(photons)
    assert known.of_image(np.zeros((2, 2))) == 5.0


def test_a_cube_has_the_mean_wavelengths_of_its_scenario(tmp_path):
    scenario = Scenario.load("stratus", {**SMALL, "bands": ["lwir"]})
    simulate(scenario, tmp_path / "c.nc").close()
    (found,), (expected,) = mean_wavelengths_of(tmp_path / "c.nc"), mean_wavelengths(column_spectra(scenario))
    np.testing.assert_array_equal(found.wavelength_um, expected.wavelength_um)
