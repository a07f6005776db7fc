"""Brightness temperature of cubes, and sensors that cannot see the scene."""

import numpy as np
import pytest
from cheap import CHEAP
from scipy.constants import c, h, k
from scipy.integrate import quad

from hcss_twin import CubeError, Scenario, brightness_temperature, sense, simulate

BAND_UM = (10.3, 11.3)


@pytest.fixture(scope="module")
def cube():
    small = {"image.rows": 40, "image.columns": 40, "frames.count": 1, "output.certificate": 0}
    return simulate(Scenario.load("stratus", {**CHEAP, **small, "bands": [list(BAND_UM)]}))


def planck(wavelength_m, kelvin):
    return 2 * h * c**2 / wavelength_m**5 / np.expm1(h * c / (wavelength_m * k * kelvin))


@pytest.mark.parametrize("kelvin", [200.0, 293.15])
def test_a_cube_of_black_bodies_has_their_temperature(cube, kelvin):
    radiance = quad(planck, *(1e-6 * end for end in BAND_UM), args=(kelvin,), epsabs=0.0)[0]
    black = cube.assign(radiance=cube["radiance"].copy(data=np.full(cube["radiance"].shape, radiance)))
    found = brightness_temperature(black)
    assert found.dims == cube["radiance"].dims
    np.testing.assert_allclose(found, kelvin, atol=1e-3)


def test_noise_in_kelvin_is_that_of_the_sensor(cube):
    own = {"parameters": {"noise": "nedt", "nedt": 0.06, "nedt_temperature": 290.0}}
    difference = brightness_temperature(sense(cube, own)) - brightness_temperature(cube)
    assert float(difference.std()) == pytest.approx(0.06, rel=0.15)


def test_radiance_without_a_temperature_has_none(cube):
    dark = cube.assign(radiance=-cube["radiance"])
    assert np.all(np.isnan(brightness_temperature(dark)))


def test_a_sensor_that_measures_one_value_far_from_the_scene_is_refused(cube):
    with pytest.raises(CubeError, match=r"measures the same radiance.*made for other bands"):
        sense(cube, "generic-mwir")
