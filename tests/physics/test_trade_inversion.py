"""Air under a trade inversion follows the laws of a well-mixed, cloud-topped boundary layer."""

import itertools
import json
import os
from pathlib import Path

import netCDF4
import numpy as np
import pytest

from hcss_twin import Scenario, simulate
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import CatalogError, ScenarioError
from hcss_twin.models.atmosphere.inversion import JUMP_M, RELAXATION_M, with_inversion
from hcss_twin.models.atmosphere.moist_air import altitude_of_pressure, relative_humidity
from hcss_twin.models.atmosphere.profile_file import load_profile
from hcss_twin.plan.make_plan import make_plan
from hcss_twin.scenario.atmosphere import InversionSection

CATALOG = Catalog()
NAMES = CATALOG.names("atmospheres", ".csv")
CLEAR = """
time = 2020-09-06T00:45:00+00:00
place = {latitude = -16.0, longitude = 1.8}
image = {rows = 4, columns = 4, pixel_size = 20.0}
frames.count = 1
bands = ["lwir-10.8"]
"""


def changed(name="us-standard-1976", surface_K=290.0, **keys):
    profile = load_profile(name, CATALOG)
    return profile, with_inversion(profile, InversionSection(**keys), surface_K)


def test_air_below_the_cloud_is_dry_adiabatic_and_of_constant_composition() -> None:
    _, air = changed(cloud_base=700.0)
    below = air.altitude_m <= 700.0
    assert below.sum() == 8
    np.testing.assert_allclose(np.diff(air.temperature_K[below]) / np.diff(air.altitude_m[below]), -9.80665 / 1005.0)
    assert np.ptp(air.mixing_ratio["h2o"][below]) == 0.0


def test_cloudy_air_is_saturated_and_keeps_its_equivalent_potential_temperature() -> None:
    """D. Bolton, Mon. Weather Rev. 108, 1046 (1980), eq. 43 for saturated air; the adiabat is computed from another."""
    _, air = changed(height=2000.0, cloud_base=400.0)
    cloud = (air.altitude_m >= 400.0) & (air.altitude_m <= 2000.0)
    kelvin, pressure, mole = air.temperature_K[cloud], air.pressure_Pa[cloud], air.mixing_ratio["h2o"][cloud]
    np.testing.assert_allclose(relative_humidity(mole, pressure, kelvin), 1.0, atol=1e-9)
    grams = 1e3 * 0.62198 * mole / (1.0 - mole)
    theta = kelvin * (1e5 / pressure) ** (0.2854 * (1.0 - 0.28e-3 * grams))
    equivalent = theta * np.exp((3.376 / kelvin - 0.00254) * grams * (1.0 + 0.81e-3 * grams))
    np.testing.assert_allclose(equivalent, equivalent[0], atol=0.25)


def test_temperature_jumps_and_humidity_falls_by_what_is_given() -> None:
    _, air = changed(height=1200.0, strength=8.5, humidity_above=0.11)
    low, high = air.temperature_at([1200.0, 1200.0 + JUMP_M])
    assert high - low == pytest.approx(8.5)
    humidity = relative_humidity(air.mixing_ratio["h2o"], air.pressure_Pa, air.temperature_K)
    assert humidity[np.searchsorted(air.altitude_m, 1200.0 + JUMP_M)] == pytest.approx(0.11)


def test_air_is_in_hydrostatic_balance_and_becomes_that_of_the_profile() -> None:
    profile, air = changed()
    assert air.pressure_Pa[0] == profile.pressure_Pa[0]
    end = 1000.0 + JUMP_M + RELAXATION_M
    low = air.altitude_m <= end
    heights = altitude_of_pressure(air.pressure_Pa[low], air.temperature_K[low], air.mixing_ratio["h2o"][low])
    np.testing.assert_allclose(heights, air.altitude_m[low], rtol=1e-6, atol=1e-3)
    high = profile.altitude_m > end
    kept = air.altitude_m > end
    np.testing.assert_array_equal(air.temperature_K[kept], profile.temperature_K[high])
    np.testing.assert_allclose(np.ptp(np.log(air.pressure_Pa[kept] / profile.pressure_Pa[high])), 0.0, atol=1e-12)
    np.testing.assert_allclose(air.mixing_ratio["co2"][low], profile.mixing_ratio["co2"][0], rtol=1e-3)


def test_water_vapour_under_the_cloud_is_that_measured_in_dycoms() -> None:
    """B. Stevens et al., Mon. Weather Rev. 133, 1443 (2005): 289.0 K, 1017.8 hPa, cloud base about 600 m, 9.0 g/kg."""
    surface = 289.0 * 1.0178**0.286
    _, air = changed(surface_K=surface, height=840.0, cloud_base=600.0, strength=8.5)
    mole = air.mixing_ratio["h2o"][0]
    assert 1e3 * 0.62198 * mole / (1.0 - mole) == pytest.approx(9.0, rel=0.04)


LIMITS = {
    "height": (200.0, 3000.0),
    "strength": (0.0, 25.0),
    "cloud_base": (0.0, 200.0, 3000.0),
    "humidity_above": (0.01, 1.0),
}


@pytest.mark.parametrize("name", NAMES)
def test_every_accepted_inversion_gives_finite_stable_unsaturated_air(name) -> None:
    accepted = 0
    for surface_K, values in itertools.product((250.0, 310.0), itertools.product(*LIMITS.values())):
        keys = dict(zip(LIMITS, values, strict=True))
        if keys["cloud_base"] > keys["height"]:
            continue
        try:
            profile, air = changed(name, surface_K, **keys)
        except CatalogError:  # unstable above
            continue
        accepted += 1
        for each in (air.temperature_K, air.pressure_Pa, air.mixing_ratio["h2o"]):
            assert np.all(np.isfinite(each) & (each >= 0.0))
        assert np.all(np.diff(air.altitude_m) > 0.0)
        assert np.all(np.diff(air.pressure_Pa) < 0.0)
        given = relative_humidity(profile.mixing_ratio["h2o"], profile.pressure_Pa, profile.temperature_K)
        humidity = relative_humidity(air.mixing_ratio["h2o"], air.pressure_Pa, air.temperature_K)
        assert np.max(humidity) <= max(1.0, np.max(given)) + 1e-6
        own = np.max(-np.diff(profile.temperature_K) / np.diff(profile.altitude_m))
        assert np.max(-np.diff(air.temperature_K) / np.diff(air.altitude_m)) <= max(own, 9.80665 / 1005.0) + 1e-9
    assert accepted >= 8


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"atmosphere.inversion.cloud_base": 1200.0}, "1200 m is above the inversion; allowed: up to height, 1000"),
        ({"atmosphere.inversion": {}, "atmosphere.water_vapour_column": 20.0}, "water_vapour_column given with inv"),
        (
            {"atmosphere.inversion": {"strength": 25.0, "surface_temperature": 305.0}},
            r"atmosphere.inversion.strength: a jump of 25 K .*allowed: ",
        ),
        (
            {"atmosphere.provider": "table", "atmosphere.inversion": {}},
            r"atmosphere.inversion: provider 'table' supports only the profile",
        ),
    ],
)  # fmt: skip
def test_impossible_inversions_are_refused_with_what_is_allowed(values, message) -> None:
    with pytest.raises(ScenarioError, match=message):
        make_plan(Scenario.from_toml(CLEAR, values))


def test_the_largest_jump_of_a_message_is_accepted() -> None:
    values = {"atmosphere.inversion": {"strength": 25.0, "surface_temperature": 298.0}}
    with pytest.raises(ScenarioError) as refused:
        make_plan(Scenario.from_toml(CLEAR, values))
    closest = float(str(refused.value).rsplit(" ", 1)[1])
    values["atmosphere.inversion"]["strength"] = closest
    make_plan(Scenario.from_toml(CLEAR, values))
    values = {"atmosphere.profile": "subarctic-winter", "atmosphere.inversion": {"surface_temperature": 310.0}}
    with pytest.raises(ScenarioError, match="allowed: a surface_temperature that is about"):
        make_plan(Scenario.from_toml(CLEAR, values))


def test_scenes_without_an_inversion_do_not_store_it() -> None:
    assert "inversion" not in Scenario.from_toml(CLEAR).to_json()


def test_the_air_of_an_inversion_comes_back_from_a_stored_scenario() -> None:
    scenario = Scenario.from_toml(CLEAR, {"atmosphere.inversion": {"height": "1.5 km", "cloud_base": 800.0}})
    again = Scenario.from_dict(json.loads(scenario.to_json()))
    first, second = (make_plan(each).assembly.profile for each in (scenario, again))
    np.testing.assert_array_equal(first.temperature_K, second.temperature_K)
    assert any("inversion of 10 K at 1500 m" in note for note in first.notes)


@pytest.mark.skipif("HCSS_SAMPLE_DATA" not in os.environ, reason="needs measured images, HCSS_SAMPLE_DATA")
@pytest.mark.parametrize("block", [12, 13, 15])
def test_tops_of_stratocumulus_are_as_cold_as_measured_by_default(block, tmp_path) -> None:
    """SEVIRI over the Southeast Atlantic; a cloud of the paper's heights, without an inversion, is much warmer."""
    with netCDF4.Dataset(Path(os.environ["HCSS_SAMPLE_DATA"]) / "seviri" / "sea-blocks-2020-09-06.nc") as measured:
        place = [float(np.mean(measured[name][block])) for name in ("latitude", "longitude", "view_zenith")]
        coldest = float(np.nanpercentile(np.ma.filled(measured["ir_108"][block, 2].astype(float), np.nan), 5))
    overcast = {"type": "stratocumulus", "coverage": 1.0, "thickness_min": 399.0}
    values = dict(zip(("place.latitude", "place.longitude", "view.zenith"), place, strict=True))
    values |= {"output.variables": ["brightness_temperature"], "atmosphere.parameters": {"aerosol": "none"}}
    values |= {"output.certificate": 0}
    of_the_paper = {"type": "paper-stratus", "coverage": 1.0, "thickness_min": 960.0}
    errors = []
    for number, clouds in enumerate((of_the_paper, overcast)):
        simulate(Scenario.from_toml(CLEAR, values | {"clouds": clouds}), tmp_path / f"{number}.nc")
        with netCDF4.Dataset(tmp_path / f"{number}.nc") as cube:
            errors.append(float(np.mean(cube["brightness_temperature"][:])) - coldest)
    assert errors[0] > 6.0
    assert abs(errors[1]) < 4.0
