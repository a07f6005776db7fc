"""Bands with a name of their own: limits, and Gaussian responses."""

import re

import numpy as np
import pytest
from refusals import problems_of
from scipy import special

from hcss_twin.core.catalog import Catalog
from hcss_twin.scenario.bands import spectral_band
from hcss_twin.scenario.scenario import Scenario

SCENE = {"time": "2024-04-20T12:30:00+10:00", "place": {"latitude": 35.0, "longitude": 150.0}}


def scenario(*bands):
    return Scenario.from_dict({**SCENE, "bands": list(bands)})


def test_named_limits_are_limits_with_a_name():
    (band,) = scenario({"name": "blue spike", "limits": [4.17, 4.2]}).bands
    found = spectral_band(band, Catalog())
    assert (found.name, found.lower_um, found.upper_um) == ("blue spike", 4.17, 4.2)
    np.testing.assert_array_equal(found.response, 1.0)


@pytest.mark.parametrize("text", ["8-14um", "8-14 um", "8.0 - 14.0 um", "8-14µm"])
def test_limits_with_their_unit_are_limits(text):
    assert scenario(text).bands == ((8.0, 14.0),)


def test_a_gaussian_band_is_a_gaussian_with_its_width_and_area():
    (band,) = scenario({"name": "g", "center_um": 4.0, "fwhm_um": 0.2}).bands
    found = spectral_band(band, Catalog())
    assert np.interp([3.9, 4.0, 4.1], found.wavelength_um, found.response) == pytest.approx([0.5, 1.0, 0.5], abs=1e-3)
    assert found.response[[0, -1]] == pytest.approx(1e-4)
    assert found.central_um == pytest.approx(4.0, abs=1e-12)
    sigma = 0.2 / np.sqrt(8.0 * np.log(2.0))
    whole = sigma * np.sqrt(2.0 * np.pi)
    area = np.trapezoid(found.response, found.wavelength_um)
    assert 1.0 - area / whole == pytest.approx(special.erfc(np.sqrt(np.log(1e4))), rel=0.05)
    assert 1.0 - area / whole < 2e-5
    between = np.linspace(found.lower_um, found.upper_um, 5000)
    exact = np.exp(-0.5 * ((between - 4.0) / sigma) ** 2)
    linear = np.interp(between, found.wavelength_um, found.response)
    assert np.abs(linear - exact).max() < 6e-4


def test_forms_survive_being_written():
    one = scenario(
        "mwir", [8.0, 9.0], {"name": "a", "limits": [3.0, 4.0]}, {"name": "b", "center_um": 4.0, "fwhm_um": 0.1}
    )
    assert Scenario.from_toml("", {**SCENE, "bands": list(one.model_dump(mode="json")["bands"])}) == one


@pytest.mark.parametrize(
    ("band", "field", "message"),
    [
        (4, "bands[0]", "4 is not a band; allowed: .*{name, limits} or {name, center_um, fwhm_um}"),
        ({"name": "x", "centre_um": 4.0}, "bands[0].centre_um", "unknown key; .*closest is 'center_um'"),
        ({"name": "x", "limit": [3, 4]}, "bands[0].limit", "unknown key; .*closest is 'limits'"),
        ({"name": "x", "limits": [3, 4], "fwhm_um": 1.0}, "bands[0]", "limits, fwhm_um in one band; allowed"),
        ({"name": "x", "limits": [5, 3]}, "bands[0].limits", "is reversed; closest valid choice is \\[3, 5\\]"),
        ({"name": "x", "limits": 4.0}, "bands[0].limits", "4.0 is not \\[shortest_um, longest_um\\]"),
        ({"limits": [3, 5]}, "bands[0].name", "is missing"),
        ({"name": "x", "center_um": 4.0}, "bands[0].fwhm_um", "is missing; Full width"),
        ({"name": "x", "center_um": 4.0, "fwhm_um": -1.0}, "bands[0].fwhm_um", "-1.0 is out of range; allowed: > 0"),
        (
            {"name": "x", "center_um": 4.0, "fwhm_um": 3.0},
            "bands[0]",
            "its response ends at -1.46.* closest valid choice of fwhm_um is 2.13",
        ),
        ({"name": "x", "center_um": 4.0, "fwhm_um": 1e-9}, "bands[0]", "too narrow"),
        ({"name": "x", "center_um": 4.0, "fwhm_um": 1.0, "cut": 1}, "bands[0].cut", "unknown key"),
    ],
)
def test_wrong_forms_are_told(band, field, message):
    found = problems_of(lambda: scenario(band))
    assert re.search(message, found.get(field, "")), found
