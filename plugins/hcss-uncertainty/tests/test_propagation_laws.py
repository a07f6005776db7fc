"""Spread of radiance where it is known: a clear sky and a sea of uncertain temperature."""

import numpy as np
import pytest
from cheap import CHEAP
from hcss_uncertainty import propagate
from scipy import constants
from scipy.integrate import quad

import hcss_twin

SIGMA = 0.4
CLEAR = {
    **CHEAP,
    "clouds.coverage": 0.0,
    "image.rows": 4,
    "image.columns": 4,
    "frames.count": 1,
    "bands": [[10.3, 11.3]],
    "time": "2024-04-20T14:30:00Z",
}


def radiance_at(temperature):
    cube = hcss_twin.simulate(hcss_twin.Scenario.load("stratus", {**CLEAR, "sea.temperature": temperature}))
    return cube["radiance"].values.astype(np.float64).mean(axis=(0, 2, 3))


@pytest.fixture(scope="module")
def found():
    return propagate("stratus", draws=16, uncertain={"sea.temperature": f"normal:291:{SIGMA}"}, overrides=CLEAR).dataset


def test_the_spread_of_a_linear_scene_is_the_slope_times_that_of_the_input(found):
    slope = (radiance_at(291.0 + SIGMA) - radiance_at(291.0 - SIGMA)) / (2.0 * SIGMA)
    spread = found["radiance_standard_deviation"].sel({"class": "clear"}).values
    drawn = found["input_value"].values[:, 0]
    np.testing.assert_allclose(spread, slope * drawn.std(ddof=1), rtol=0.01)
    error = found["radiance_standard_deviation_error"].sel({"class": "clear"}).values
    np.testing.assert_array_less(np.abs(spread - slope * SIGMA), 4.0 * error)
    assert np.all(error < 0.4 * spread)


def test_all_of_it_is_the_share_of_the_only_input(found):
    clear = found.sel({"class": "clear"})
    np.testing.assert_allclose(clear["radiance_first_order"].sel(source="sea.temperature"), 1.0, atol=1e-3)
    np.testing.assert_array_equal(clear["radiance_total"].sel(source="seed"), 0.0)


def test_classes_without_pixels_have_no_numbers(found):
    thick = found.sel({"class": "thick"})
    assert np.all(np.isnan(thick["radiance_mean"]))
    assert np.all(thick["radiance_draws"] == 0)
    assert np.all(np.isnan(found["metric_mean"].sel(metric_name=["entropy", "fractal_dimension"])))
    assert float(found["metric_mean"].sel(metric_name="coverage")) == 0.0


STEP, NEDT, AT_K = 1e-4, 0.05, 300.0
SENSOR = {
    "sensor.parameters.noise": "nedt",
    "sensor.parameters.nedt": NEDT,
    "sensor.parameters.nedt_temperature": AT_K,
    "sensor.parameters.bits": 20,
    "sensor.parameters.radiance_per_number": STEP,
}


@pytest.fixture(scope="module")
def sensed():
    """The same sea through a linear sensor, in enough pixels for its noise."""
    overrides = CLEAR | SENSOR | {"image.rows": 32, "image.columns": 32}
    uncertain = {"sea.temperature": f"normal:291:{SIGMA}"}
    return propagate("stratus", draws=12, uncertain=uncertain, overrides=overrides).dataset.isel(band=0)


def black_body(kelvin):
    """Radiance of a black body from 10.3 to 11.3 um, W m-2 sr-1."""

    def spectral(wavelength_um):
        metres = wavelength_um * 1e-6
        x = constants.h * constants.c / (metres * constants.k * kelvin)
        return 2e-6 * constants.h * constants.c**2 / metres**5 / np.expm1(x)

    return quad(spectral, 10.3, 11.3, epsabs=0.0, epsrel=1e-10)[0]


def per_kelvin(kelvin):
    return (black_body(kelvin + 0.5) - black_body(kelvin - 0.5)) / 1.0


def test_the_spread_of_digital_numbers_is_that_of_radiance_divided_by_the_step_of_the_converter(sensed):
    clear = sensed.sel({"class": "clear"})
    spread = float(clear["radiance_standard_deviation"]) / STEP
    # the noise of a mean over 1024 pixels is .002 K, of the sea .4 K
    assert float(clear["digital_number_standard_deviation"]) == pytest.approx(spread, rel=5e-3)
    assert float(clear["digital_number_mean"]) == pytest.approx(float(clear["radiance_mean"]) / STEP, rel=1e-4)
    # a pixel has the spread of the draws and the noise
    pixel = np.hypot(clear["radiance"].values[0].std(), NEDT * per_kelvin(AT_K)) / STEP
    assert float(clear["digital_number_pixel_standard_deviation"]) == pytest.approx(pixel, rel=5e-3)


def test_noise_signal_to_noise_and_nedt_are_those_of_the_black_body(sensed):
    clear = sensed.sel({"class": "clear"})
    noise = NEDT * per_kelvin(AT_K)
    kelvin = float(clear["brightness_temperature_mean"])
    # 24 scenes of 1024 pixels: half a per cent is two standard errors
    assert float(clear["noise_radiance_mean"]) == pytest.approx(noise, rel=0.015)
    assert float(clear["signal_to_noise_mean"]) == pytest.approx(black_body(kelvin) / noise, rel=0.015)
    assert float(clear["nedt_mean"]) == pytest.approx(NEDT * per_kelvin(AT_K) / per_kelvin(kelvin), rel=0.015)
    assert int(clear["nedt_scenes"]) == 24
    assert int(sensed["nedt_scenes"].sel({"class": "thick"})) == 0
