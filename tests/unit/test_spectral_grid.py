import numpy as np
import pytest

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import CatalogError, ProviderError
from hcss_twin.models.radiance.brightness_temperature import BrightnessTemperature
from hcss_twin.models.radiance.spectral_grid import SolarSpectrum, SpectralBand, SpectralGrid
from hcss_twin.physics.planck import planck
from hcss_twin.scenario.bands import ResponseBand, spectral_band

NATIVE = np.arange(500.0, 10_001.0, 5.0)


def flat(low, high):
    return SpectralBand("flat", np.array([low, high]), np.ones(2))


def test_bands_that_overlap_share_wavenumbers_and_not_weights():
    together = SpectralGrid.dense([flat(8.0, 12.0), flat(10.0, 14.0)], NATIVE)
    for row, alone in enumerate((flat(8.0, 12.0), flat(10.0, 14.0))):
        single = SpectralGrid.dense([alone], NATIVE)
        spectrum = planck(together.wavenumber_cm1, 290.0) @ together.weights_cm1[row]
        assert spectrum == pytest.approx(planck(single.wavenumber_cm1, 290.0) @ single.weights_cm1[0], rel=1e-13)


def test_planck_integral_agrees_with_adaptive_quadrature():
    from scipy.integrate import quad

    grid = SpectralGrid.dense([flat(3.0, 5.0)], NATIVE)
    exact, _ = quad(lambda v: planck(np.array([v]), 290.0)[0], 2000, 1e4 / 3, epsrel=1e-12)
    assert planck(grid.wavenumber_cm1, 290.0) @ grid.weights_cm1[0] == pytest.approx(exact, rel=1e-4)


@pytest.mark.parametrize(
    ("wavelength", "response", "centroid"),
    [
        ([3.0, 6.0], [0.0, 0.5], 5.0),  # a triangle's is two thirds of the way
        ([3.0, 6.0], [1.0, 0.0], 4.0),
        ([3.0, 5.0, 6.0], [0.0, 1.0, 0.0], 14.0 / 3.0),
        ([10.0, 10.001], [1.0, 1.0], 10.0005),
    ],
)
def test_the_centre_of_a_band_is_the_centroid_of_its_response(wavelength, response, centroid):
    band = SpectralBand("x", np.array(wavelength), np.array(response))
    assert band.central_um == pytest.approx(centroid, rel=1e-14)


def test_measured_response_weights_the_band(tmp_path):
    (tmp_path / "triangle.csv").write_text("wavelength_um,response\n10,0\n11,1\n12,0\n")
    band = spectral_band(ResponseBand(name="t", response="triangle.csv"), Catalog(base=tmp_path))
    grid = SpectralGrid.dense([band], NATIVE)
    assert band.central_um == pytest.approx(11.0)
    # Integral of the triangle over wavenumber, with a Planck function that hardly varies: compare with quadrature.
    from scipy.integrate import quad

    exact, _ = quad(
        lambda v: planck(np.array([v]), 290.0)[0] * max(0.0, 1 - abs(1e4 / v - 11)),
        1e4 / 12, 1e4 / 10, points=[1e4 / 11], epsrel=1e-10,
    )  # fmt: skip
    assert planck(grid.wavenumber_cm1, 290.0) @ grid.weights_cm1[0] == pytest.approx(exact, rel=2e-4)


@pytest.mark.parametrize(
    "text",
    [
        "wavelength_um\n1\n2\n",
        "wavelength_um,response\n2,1\n1,1\n3,1\n",
        "wavelength_um,response\n1,0\n2,0\n",
        "wavelength_um,response\n1,1\n2,1.5\n",
        "wavelength_um,response\n1,1\n2,nan\n",
    ],
)
def test_malformed_responses_are_refused(tmp_path, text):
    (tmp_path / "bad.csv").write_text(text)
    with pytest.raises(CatalogError):
        spectral_band(ResponseBand(name="b", response="bad.csv"), Catalog(base=tmp_path))


@pytest.mark.parametrize("limits", [(1.5, 1.7), (2.7, 3.0), (3.0, 5.0), (8.0, 14.0), (15.0, 30.0)])
def test_temperature_is_that_of_the_black_body_within_steps_of_single_precision(limits):
    grid = SpectralGrid.dense([flat(*limits)], NATIVE)
    kelvin = np.geomspace(60.001, 2999.9, 5001)
    exact = planck(grid.wavenumber_cm1, kelvin[:, None]) @ grid.weights_cm1[0]
    single = exact.astype(np.float32)
    known = single > 1.2e-38
    slope = np.gradient(kelvin, np.log(exact))
    expected = (kelvin + slope * (single / exact - 1.0))[known]  # of the rounded radiance
    found = BrightnessTemperature(grid, ["flat"])(single[known].reshape(1, 1, -1))[0, 0]
    assert np.all(np.abs(found - expected) <= 2.5 * np.spacing(expected.astype(np.float32)))


def test_radiance_below_the_normal_numbers_has_a_temperature_too():
    grid = SpectralGrid.dense([flat(1.5, 1.7)], NATIVE)
    exact = planck(grid.wavenumber_cm1, 84.0) @ grid.weights_cm1[0]
    assert 1e-40 < exact < 1e-38
    found = BrightnessTemperature(grid, ["flat"])(np.full((1, 1, 2), exact, np.float32))
    np.testing.assert_allclose(found, 84.0, atol=1e-3)


@pytest.mark.parametrize("value", [0.0, -0.0, -1.0, 1e9, np.inf, -np.inf, np.nan])
def test_radiance_of_no_temperature_is_refused(value):
    grid = SpectralGrid.dense([flat(8.0, 14.0)], NATIVE)
    radiance = np.array([10.0, value, 12.0], np.float32).reshape(1, 1, 3)
    with pytest.raises(ProviderError, match=r"'flat'.*brightness"):
        BrightnessTemperature(grid, ["flat"])(radiance)


def test_solar_spectrum_integrates_to_the_catalogued_band_values():
    sun = SolarSpectrum(Catalog())
    # Trapezoidal integrals of the ASTM E490 table over wavelength, W m-2.
    for limits, expected in {(2.7, 3.0): 9.566, (3.0, 5.0): 21.08}.items():
        grid = SpectralGrid.dense([flat(*limits)], None)
        assert sun(grid.wavenumber_cm1) @ grid.weights_cm1[0] == pytest.approx(expected, rel=3e-3)


def test_solar_spectrum_refuses_wavelengths_it_does_not_hold():
    with pytest.raises(ValueError, match="allowed"):
        SolarSpectrum(Catalog())(np.array([100.0]))
