"""Amounts of gases: given, of the year, or of the profile."""

from __future__ import annotations

import json

import numpy as np
import pytest

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import ScenarioError
from hcss_twin.models.atmosphere.gases import DOBSON_M2, factor_of, means_of_year
from hcss_twin.models.atmosphere.moist_air import column_m2
from hcss_twin.models.atmosphere.profile_file import load_profile
from hcss_twin.plan.surroundings import surroundings
from hcss_twin.scenario.scenario import Scenario

CLEAR = """
time = 2010-07-01T00:00:00Z
place = {latitude = 35.0, longitude = 150.0}
sea = {temperature = 290.0, wind_speed = 5.0}
atmosphere.profile = "us-standard-1976"
"""
CATALOG = Catalog()
STANDARD = load_profile("us-standard-1976", CATALOG)


def air(**overrides: object) -> tuple[object, dict[str, str]]:
    """Return the profile of a scene and what the plan filled in."""
    given = {key.replace("__", "."): value for key, value in overrides.items()}
    around = surroundings(Scenario.from_toml(CLEAR, given), CATALOG, None)
    return around.profile, {each.field: each.value for each in around.filled_in}


def test_means_are_those_of_the_record_and_constant_beyond_it():
    assert means_of_year(2010) == pytest.approx({"co2": 388.75e-6, "ch4": 1798.9e-9, "n2o": 323.2e-9})
    assert means_of_year(2100) == means_of_year(2025)
    assert means_of_year(2000)["co2"] < means_of_year(2003)["co2"] < means_of_year(2005)["co2"]


def test_a_model_atmosphere_has_the_gases_of_the_year_and_the_plan_says_so():
    profile, told = air()
    assert profile.mixing_ratio["co2"][0] == pytest.approx(388.75e-6)
    np.testing.assert_array_equal(profile.mixing_ratio["o3"], STANDARD.mixing_ratio["o3"])
    assert told == {"atmosphere.gases": "CO2 388.8, CH4 1.799, N2O 0.3232 ppm"}


def test_the_gases_of_the_profile_can_be_chosen():
    profile, told = air(atmosphere__gases__others="profile")
    np.testing.assert_array_equal(profile.mixing_ratio["co2"], STANDARD.mixing_ratio["co2"])
    assert told == {}


def test_given_amounts_are_met():
    profile, _ = air(atmosphere__gases__CO2="560 ppm", atmosphere__gases__O3="250 DU", atmosphere__gases__CO=2)
    assert profile.mixing_ratio["co2"][0] == pytest.approx(560e-6)
    assert column_m2(profile, "o3") / DOBSON_M2 == pytest.approx(250.0)
    np.testing.assert_allclose(profile.mixing_ratio["co"], 2.0 * STANDARD.mixing_ratio["co"])


def test_the_gases_of_a_users_file_are_kept(tmp_path):
    rows = "\n".join(f"{z},{1013.25 * np.exp(-z / 8000.0):.6f},{288.0 - 0.0065 * z},1e-6,5e-4" for z in (0, 3000, 6000))
    (tmp_path / "own.csv").write_text(f"altitude_m,pressure_hPa,temperature_K,h2o,co2\n{rows}\n")
    profile, told = air(atmosphere__profile=str(tmp_path / "own.csv"))
    assert profile.mixing_ratio["co2"][0] == 5e-4
    assert profile.mixing_ratio["ch4"][0] == pytest.approx(1798.9e-9)
    assert "CO2" not in told["atmosphere.gases"]


@pytest.mark.parametrize("amounts", [{"CO2": "5e6 ppm"}, {"CH4": "2e9 ppb"}, {"O3": "1e9 DU"}])
def test_amounts_of_more_than_a_hundred_times_the_profile_are_refused_with_the_largest(amounts):
    [(gas, amount)] = amounts.items()
    with pytest.raises(ScenarioError, match=rf"atmosphere.gases.{gas}: {amount} is .* allowed: above 0 to "):
        surroundings(Scenario.from_toml(CLEAR, {"atmosphere.gases": amounts}), CATALOG, None)


def test_a_factor_is_a_factor():
    assert factor_of(STANDARD, "co2", 1.5) == 1.5


@pytest.mark.parametrize("amount", ["5 km", "ppm", -1, 0, True, "0 ppm", "nan ppm"])
def test_other_amounts_are_refused(amount):
    with pytest.raises(ScenarioError, match=r"atmosphere.gases.CO2: .*(is not an amount of a gas|not a number)"):
        Scenario.from_toml(CLEAR, {"atmosphere.gases.CO2": amount})


def test_scenarios_store_the_coefficients_that_were_used():
    stored = json.loads(Scenario.from_toml(CLEAR).to_json())
    assert stored["atmosphere"]["coefficients"] in ("rrtmgp", "lowtran7")
    table = json.loads(Scenario.from_toml(CLEAR, {"atmosphere.provider": "table"}).to_json())
    assert "coefficients" not in table["atmosphere"]


@pytest.mark.parametrize("more", [{"atmosphere.provider": "table"}, {"atmosphere.parameters": {"file": "x"}}])
def test_coefficients_are_refused_where_they_have_no_effect(more):
    with pytest.raises(ScenarioError, match="coefficients given with"):
        Scenario.from_toml(CLEAR, {"atmosphere.coefficients": "lowtran7", **more})
