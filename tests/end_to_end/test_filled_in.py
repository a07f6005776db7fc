"""A scenario of place and date alone, and what the plan says about the values it was given."""

import json

import numpy as np
import pytest
from cheap import CHEAP

from hcss_twin.core.errors import ProviderError, ScenarioError
from hcss_twin.core.plugins import Origin
from hcss_twin.engine.simulate import simulate
from hcss_twin.models.atmosphere.moist_air import water_vapour_column_kg_m2
from hcss_twin.plan.make_plan import make_plan
from hcss_twin.providers.registry import ProviderSpec, hookimpl
from hcss_twin.providers.registry.registry import Registry
from hcss_twin.scenario.scenario import Scenario

SMALL = {"image.rows": 4, "image.columns": 4, "frames.count": 1, "bands": [[10.0, 10.2]], **CHEAP}
TABLE = {**SMALL, "atmosphere.provider": "table"}
CLEAR = """
time = 2024-04-20T12:30:00+10:00
place = {latitude = 35.0, longitude = 150.0}
"""


class AnyAir:
    """A provider that accepts any profile: transparent."""

    def __init__(self, inputs, parameters):
        from hcss_twin.providers import AtmosphereDeclaration

        self.declares = AtmosphereDeclaration()

    def transmittance(self, wavenumber_cm1, paths):
        return np.ones((len(paths), wavenumber_cm1.size))


class BadlyBound(AnyAir):
    @staticmethod
    def bound_profile(parameters, catalog):
        return "us-standard-1976"


class Plugin:
    @hookimpl
    def hcss_register_transmittance_providers(self):
        return [
            ProviderSpec("any-air", f"{__name__}:AnyAir", None, 3, "transparent"),
            ProviderSpec("badly-bound", f"{__name__}:BadlyBound", None, 3, "returns a name"),
        ]


@pytest.fixture
def any_air(monkeypatch):
    """Overrides that select a provider without a profile of its own."""
    discover = Registry.discover

    def with_plugin():
        registry = discover()
        registry.add(Plugin(), Origin("any-air", "test-any-air", "1"))
        return registry

    monkeypatch.setattr(Registry, "discover", staticmethod(with_plugin))
    return {**SMALL, "atmosphere.provider": "any-air"}


def filled(plan):
    return {item.field: item for item in plan.filled_in}


def test_place_and_date_are_enough():
    plan = make_plan(Scenario.from_toml(CLEAR, SMALL))
    told = filled(plan)
    assert set(told) == {"atmosphere.profile", "atmosphere.gases", "sea.temperature", "sea.wind_speed"}
    # April in the Kuroshio extension: 17 to 18 degC, half a kelvin warmer now, fresh winds.
    assert 289.9 < plan.assembly.sea_temperature_K < 291.9
    assert told["sea.temperature"].value == f"{plan.assembly.sea_temperature_K:.2f} K"
    assert "COADS 1946-1989" in told["sea.temperature"].why
    assert "April 20" in told["sea.temperature"].why
    assert 8 < float(told["sea.wind_speed"].value.removesuffix(" m/s")) < 10
    assert "climatology/coads-monthly.nc" in plan.catalog.used


def test_the_sea_model_gets_the_wind_that_is_told():
    told = float(filled(make_plan(Scenario.from_toml(CLEAR, SMALL)))["sea.wind_speed"].value.split()[0])
    told_K = float(filled(make_plan(Scenario.from_toml(CLEAR, SMALL)))["sea.temperature"].value.split()[0])
    one = simulate(Scenario.from_toml(CLEAR, SMALL))
    two = simulate(Scenario.from_toml(CLEAR, {**SMALL, "sea.wind_speed": told, "sea.temperature": told_K}))
    np.testing.assert_allclose(one.radiance, two.radiance, rtol=2e-4)
    assert one.attrs["hcss_significant_wave_height_m"] == pytest.approx(
        two.attrs["hcss_significant_wave_height_m"], rel=2e-3
    )
    assert {item["field"] for item in json.loads(one.attrs["hcss_filled_in"])} >= {"sea.wind_speed"}


def test_the_climatology_gives_the_temperature_of_the_cloud_top_that_is_told():
    asked = CLEAR + 'clouds = {type = "paper-stratus", coverage = 0.5, temperature = "climatology"}'
    plan = make_plan(Scenario.from_toml(asked, SMALL))
    told = filled(plan)["clouds.temperature"]
    # Stratus ends at 1 km: 6 to 7 K below the air over the sea, which is within 2 K of the water.
    assert 4.0 < plan.assembly.sea_temperature_K - plan.layers[0].temperature_K < 9.0
    assert told.value == f"{plan.layers[0].temperature_K:.2f} K"
    assert "COADS 1946-1989" in told.why
    assert "standard deviation of this cooling among the model atmospheres 2." in told.why
    typed = make_plan(Scenario.from_toml(asked.replace("climatology", told.value), SMALL))
    assert typed.layers == plan.layers
    assert "clouds.temperature" not in filled(typed)


def test_a_cloud_top_without_climatological_temperature_is_refused():
    asked = CLEAR + 'clouds = {type = "cirrus", coverage = 0.5, temperature = "climatology", top = "12 km"}'
    with pytest.raises(ScenarioError, match=r"clouds.temperature: top_m: 12000 given, allowed: 0 to 10000 m"):
        make_plan(Scenario.from_toml(asked, SMALL))


def test_what_a_scenario_says_is_not_filled_in_and_the_climatology_is_not_opened():
    plan = make_plan(Scenario.load("baseline", SMALL))
    assert plan.filled_in == ()
    assert not any("climatology" in name for name in plan.catalog.used)
    assert plan.assembly.sea_temperature_K == 284.818


def test_the_table_keeps_its_profile_everywhere():
    plan = make_plan(Scenario.from_toml(CLEAR, {**TABLE, "place": {"latitude": 0.0, "longitude": -150.0}}))
    assert plan.assembly.profile.name == "us-standard-1976"
    assert "provider 'table'" in filled(plan)["atmosphere.profile"].why


@pytest.mark.parametrize(
    ("latitude", "longitude", "month", "models"),
    [
        (0, -150, 7, "tropical"),
        (35, 150, 4, "us-standard-1976"),
        (40, -40, 7, "midlatitude-summer"),
        (40, 140, 1, "midlatitude-winter"),
        (60, 0, 7, "us-standard-1976"),
    ],
)
def test_a_provider_of_any_profile_gets_the_air_of_place_and_date(any_air, latitude, longitude, month, models):
    overrides = {
        **any_air,
        "place": {"latitude": float(latitude), "longitude": float(longitude)},
        "time": f"2024-{month:02d}-15T00:00:00+00:00",
    }
    plan = make_plan(Scenario.from_toml(CLEAR, overrides))
    assert plan.assembly.profile.name == "marine air"
    assert models in plan.assembly.profile.notes[0]
    assert "COADS" in filled(plan)["atmosphere.profile"].why


def test_on_land_every_open_value_of_the_sea_is_reported():
    place = {"latitude": 52.5, "longitude": 13.4}
    with pytest.raises(ScenarioError) as caught:
        make_plan(Scenario.from_toml(CLEAR, {**SMALL, "place": place}))
    assert [problem.field for problem in caught.value.problems] == ["sea.temperature", "sea.wind_speed"]
    assert all("on land" in problem.message for problem in caught.value.problems)


def test_on_land_latitude_and_season_choose_the_air(any_air):
    overrides = {
        **any_air,
        "place": {"latitude": 52.5, "longitude": 13.4},
        "sea.temperature": 285.0,
        "sea.wind_speed": 5.0,
    }
    plan = make_plan(Scenario.from_toml(CLEAR, overrides))
    assert plan.assembly.profile.name == "subarctic-summer"
    assert "latitude and season" in filled(plan)["atmosphere.profile"].why


class TestWaterVapour:
    def test_factor_and_column(self, any_air):
        base = {**any_air, "atmosphere.profile": "midlatitude-winter"}
        half = make_plan(Scenario.from_toml(CLEAR, {**base, "atmosphere.water_vapour_scale": 0.5}))
        assert water_vapour_column_kg_m2(half.assembly.profile) == pytest.approx(4.26, abs=0.01)
        four = make_plan(Scenario.from_toml(CLEAR, {**base, "atmosphere.water_vapour_column": 4.0}))
        assert water_vapour_column_kg_m2(four.assembly.profile) == pytest.approx(4.0)
        assert any("water vapour times" in note for note in four.assembly.notes())

    def test_more_than_the_air_can_hold(self, any_air):
        base = {**any_air, "atmosphere.profile": "midlatitude-winter"}
        with pytest.raises(ScenarioError, match=r"atmosphere.water_vapour_column: .*closest valid choice"):
            make_plan(Scenario.from_toml(CLEAR, {**base, "atmosphere.water_vapour_column": 40.0}))

    def test_a_provider_that_belongs_to_one_profile_refuses(self):
        with pytest.raises(ScenarioError, match=r"atmosphere.water_vapour_scale: provider 'table' supports only"):
            make_plan(Scenario.from_toml(CLEAR, {**TABLE, "atmosphere.water_vapour_scale": 0.5}))

    def test_one_of_the_two_keys(self):
        both = {"atmosphere.water_vapour_scale": 0.5, "atmosphere.water_vapour_column": 10.0}
        with pytest.raises(ScenarioError, match="water_vapour_scale given with water_vapour_column"):
            Scenario.from_toml(CLEAR, {**SMALL, **both})


def test_a_radiosonde_runs_and_its_completion_is_noted(any_air, tmp_path):
    rows = ["1013,17,80", "900,9,70", "700,-4,40", "500,-20,30", "300,-46,30", "200,-58,10", "100,-60,2"]
    text = "\n".join(["pressure_hPa,temperature_C,relative_humidity_percent", *rows])
    (tmp_path / "sonde.csv").write_text(text, encoding="utf-8")
    scenario = Scenario.from_toml(CLEAR, {**any_air, "atmosphere.profile": "sonde.csv"}, base=tmp_path)
    cube = simulate(scenario)
    notes = json.loads(cube.attrs["hcss_notes"])
    assert any("altitudes computed from pressure" in note for note in notes)
    assert any("from 'us-standard-1976'" in note for note in notes)
    assert "atmosphere.profile" not in filled(make_plan(scenario))
    (tmp_path / "sonde.csv").write_text(text.replace("-4,40", "-4,moist"), encoding="utf-8")
    with pytest.raises(ScenarioError, match=r"atmosphere.profile: sonde.csv, line 4"):
        Scenario.from_toml(CLEAR, {**any_air, "atmosphere.profile": "sonde.csv"}, base=tmp_path)


def test_a_provider_must_be_bound_to_a_profile_or_to_none(any_air):
    with pytest.raises((ProviderError, ScenarioError), match=r"bound_profile\(\) returned str"):
        make_plan(Scenario.from_toml(CLEAR, {**any_air, "atmosphere.provider": "badly-bound"}))


@pytest.mark.parametrize(
    ("profile", "sea_K", "words"),
    [
        ("midlatitude-winter", 285.0, "12.8 K colder than the sea (285.0 K)"),
        ("tropical", 285.0, "14.7 K warmer than the sea (285.0 K)"),
        ("midlatitude-winter", 280.0, None),
    ],
)
def test_air_of_another_season_than_the_sea_is_noted(any_air, profile, sea_K, words):
    overrides = {**any_air, "atmosphere.profile": profile, "sea.temperature": sea_K}
    notes = [note for note in make_plan(Scenario.from_toml(CLEAR, overrides)).notes if "than the sea" in note]
    assert (len(notes) == 1 and words in notes[0]) if words else not notes
