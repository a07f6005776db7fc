"""Defaults of version 0.1, selected by name, for keys that a scenario does not set."""

import datetime
import json

import pytest

from hcss_twin import Scenario
from hcss_twin.scenario.former_defaults import with_former_defaults

GIVEN = {"place": {"latitude": 0.0, "longitude": 0.0}, "time": datetime.datetime(2024, 1, 1, tzinfo=datetime.UTC)}
PHASE = "ice_phase_function"


def optics(defaults=None, **sections):
    raw = {**GIVEN, **sections} | ({"defaults": defaults} if defaults else {})
    return with_former_defaults(raw)


def test_ice_has_the_phase_function_of_the_version_that_is_named():
    assert PHASE not in optics().get("optics", {}).get("parameters", {})
    assert optics("0.1")["optics"]["parameters"][PHASE] == "henyey-greenstein"


def test_what_a_scenario_says_stays():
    kept = optics("0.1", optics={"parameters": {PHASE: "diffraction-and-rays", "roughness": "smooth"}})
    assert kept["optics"]["parameters"] == {PHASE: "diffraction-and-rays", "roughness": "smooth"}


def test_layers_with_optics_of_their_own_have_the_former_defaults_too():
    layers = [{"type": "cirrus", "optics": {"provider": "bulk"}}, {"type": "stratus"}]
    first, second = optics("0.1", clouds={"layers": layers})["clouds"]["layers"]
    assert first["optics"]["parameters"] == {PHASE: "henyey-greenstein"}
    assert second == {"type": "stratus", "coverage_mode": "frame"}


@pytest.mark.parametrize("provider", ["mie", "my-optics"])
def test_other_providers_are_given_nothing(provider):
    assert optics("0.1", optics={"provider": provider})["optics"] == {"provider": provider}


def test_a_scenario_with_former_defaults_is_read_again_as_it_was():
    scenario = Scenario.from_dict({**GIVEN, "defaults": "0.1", "clouds": {"type": "cirrus"}})
    again = Scenario.from_dict(json.loads(scenario.to_json()))
    assert again.optics.parameters == scenario.optics.parameters
    assert again.coefficients == scenario.coefficients


def test_the_version_needs_no_quotes():
    assert Scenario.from_dict(GIVEN, {"defaults": 0.1}).coefficients == "lowtran7"


@pytest.mark.parametrize(
    ("sensor", "expected"),
    [
        ({"name": "modis"}, {"name": "modis", "parameters": {"method": "frames"}}),
        ({"parameters": {"method": "rows"}}, {"parameters": {"method": "rows"}}),
        ({"model": "my-sensor"}, {"model": "my-sensor"}),
        (
            {"stages": [{"model": "radiometer"}, {"model": "mine"}]},
            {"stages": [{"model": "radiometer", "parameters": {"method": "frames"}}, {"model": "mine"}]},
        ),
    ],
)
def test_a_radiometer_measures_as_in_the_version_that_is_named(sensor, expected):
    assert optics("0.1", sensor=sensor)["sensor"] == expected
    assert optics(sensor=sensor)["sensor"] == sensor
    assert "sensor" not in optics("0.1")


@pytest.mark.parametrize("generator", ["imagery", "surrogate"])
def test_clouds_from_images_have_the_former_threshold(generator):
    of_image = {"generator": generator, "parameters": {"image": "image.nc"}}
    one, two = (optics("0.1", clouds=clouds)["clouds"] for clouds in (of_image, {"layers": [of_image, {}]}))
    assert one["parameters"] == two["layers"][0]["parameters"] == {"image": "image.nc", "method": "otsu"}
    assert two["layers"][1] == {"coverage_mode": "frame"}
    kept = {"generator": generator, "coverage_mode": "field", "parameters": {"entry": "cloud.nc"}}
    assert optics("0.1", clouds=kept)["clouds"] == kept


@pytest.mark.parametrize(("defaults", "given", "expected"), [(None, {}, None), ("0.1", {}, 0.0), ("0.1", 0.2, 0.2)])
def test_the_sea_has_one_temperature_in_version_0_1(defaults, given, expected):
    keys = {"defaults": defaults} if defaults else {}
    scenario = Scenario.from_dict(GIVEN | keys | ({"sea": {"temperature_texture": given}} if given else {}))
    assert scenario.sea.temperature_texture == expected
    assert Scenario.from_dict(json.loads(scenario.to_json())).sea.temperature_texture == expected


@pytest.mark.parametrize(
    ("keys", "expected"),
    [
        ({}, "by-scale"),
        ({"defaults": "0.1"}, 1800.0),
        ({"defaults": "0.1", "motion": {"wind_speed": 5.0}}, 1800.0),
        ({"defaults": "0.1", "motion": {"evolution_time": "frozen"}}, "frozen"),
    ],
)
def test_clouds_change_as_in_the_version_that_is_named(keys, expected):
    scenario = Scenario.from_dict({**GIVEN, **keys})
    assert scenario.motion.evolution_time == expected
    assert Scenario.from_dict(json.loads(scenario.to_json())).motion.evolution_time == expected


FIELD, FRAME = "field", "frame"
STILL = {"motion": {"wind_speed": 0.0, "evolution_time": "frozen"}}


@pytest.mark.parametrize(
    ("keys", "layer", "expected"),
    [
        ({}, {}, FIELD),
        ({}, {"coverage_mode": "frame"}, FRAME),
        ({"defaults": "0.1"}, {}, FRAME),
        ({"frames": {"count": 1}}, {}, FRAME),
        (STILL, {}, FRAME),
        (STILL, {"wind_speed": 5.0}, FIELD),
        (STILL | {"platform": {"altitude": 7e5, "mode": "push-broom"}}, {}, FIELD),
    ],
)
def test_frames_that_differ_have_one_threshold_for_the_sky(keys, layer, expected):
    scenario = Scenario.from_dict({**GIVEN, **keys, "clouds": {"layers": [layer, {"type": "cirrus"} | layer]}})
    assert [each.coverage_mode for each in scenario.clouds.layers] == [expected, expected]
    again = Scenario.from_dict(json.loads(scenario.to_json()), {"frames.count": 1})
    assert [each.coverage_mode for each in again.clouds.layers] == [expected, expected]


@pytest.mark.parametrize("clouds", [{}, {"clouds": {}}, {"clouds": {"layers": []}}])
def test_a_clear_sky_stays_one(clouds):
    assert Scenario.from_dict({**GIVEN, **clouds, "defaults": "0.1"}).clouds.layers == ()
