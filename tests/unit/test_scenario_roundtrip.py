"""A scenario keeps its values: through JSON, units, short forms and overrides; it cannot be changed."""

import json
import tomllib
from datetime import datetime

import jsonschema
import pytest
from pydantic import ValidationError

from hcss_twin import Scenario, ScenarioError
from hcss_twin.core.catalog import catalog_root
from hcss_twin.scenario.overrides import parse_assignment
from hcss_twin.scenario.reference import json_schema

SHIPPED = sorted(path.stem for path in (catalog_root() / "scenarios").glob("*.toml"))
RAW = {"time": "2024-04-20T12:30:00+10:00", "place": {"latitude": 35, "longitude": 150}}
REFERENCE = catalog_root().parent / "docs" / "reference" / "scenario.md"
EXAMPLE = REFERENCE.read_text(encoding="utf-8").split("```toml\n")[1].split("```")[0]
FULL = """
    title = "Ärger \\"quoted\\""
    seed = 9223372036854775807
    time = 2024-04-20T12:30:00.123456-09:30
    place = {latitude = "-35 deg", longitude = 200}
    bands = ["mwir", [3.4, 4.1], [10, 10.001]]
    motion = {evolution_time = "frozen", platform_speed = "7.5 km/s"}
    clouds = {type = "cirrus", coverage = "30 %", temperature = "-40 degC", parameters = {H = 0.1, k = [0, 3]}}
    output = {variables = ["all"], compression = 4}
"""


def again(scenario, overrides=None):
    return Scenario.from_dict(json.loads(scenario.to_json()), overrides, base=scenario.base)


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_scenarios_survive_json(name):
    scenario = Scenario.load(name)
    assert again(scenario) == scenario


def test_every_kind_of_value_survives_json():
    scenario = Scenario.from_toml(FULL)
    assert again(scenario) == scenario
    assert again(scenario).to_json() == scenario.to_json()
    assert again(scenario).time.utcoffset() == scenario.time.utcoffset()
    assert again(scenario, {"seed": 3}) != scenario


def test_json_and_toml_files_mean_the_same(tmp_path):
    (tmp_path / "a.toml").write_text(FULL, encoding="utf-8-sig")
    scenario = Scenario.load(tmp_path / "a.toml")
    (tmp_path / "a.json").write_text(scenario.to_json(), encoding="utf-8")
    assert Scenario.load(tmp_path / "a.json") == scenario
    assert scenario.base == tmp_path.resolve()


def test_units_give_the_plain_number():
    scenario = Scenario.from_toml(FULL)
    layer = scenario.clouds.layers[0]
    assert scenario.place.latitude == -35
    assert scenario.motion.platform_speed == pytest.approx(7500)
    assert layer.coverage == pytest.approx(0.3)
    assert layer.temperature == pytest.approx(233.15)


def test_the_short_and_the_long_form_of_a_layer_are_equal():
    short = Scenario.from_dict({**RAW, "clouds": {"type": "cirrus", "coverage": 0.2}})
    long = Scenario.from_dict({**RAW, "clouds": {"layers": [{"type": "cirrus", "coverage": 0.2}]}})
    assert short == long
    assert short.field_as_typed("clouds.layers[0].generator") == "clouds.generator"
    assert long.field_as_typed("clouds.layers[0].generator") == "clouds.layers[0].generator"
    assert short.field_as_typed("bands[0]") == "bands[0]"


@pytest.mark.parametrize(
    ("clouds", "key", "value"),
    [
        (None, "clouds.coverage", 0.25),
        ({}, "clouds.coverage", 0.25),
        ({"layers": []}, "clouds.coverage", 0.25),
        ({"type": "cirrus"}, "clouds.coverage", 0.25),
        ({"layers": [{"type": "cirrus"}]}, "clouds.coverage", 0.25),
        ({"layers": [{"type": "cirrus"}]}, "clouds.layers.0.coverage", "25 %"),
    ],
)
def test_overrides_reach_the_single_layer(clouds, key, value):
    raw = RAW if clouds is None else {**RAW, "clouds": clouds}
    scenario = Scenario.from_dict(raw, {key: value})
    assert scenario.clouds.layers[0].coverage == 0.25
    kept = "cirrus" if clouds and "cirrus" in str(clouds) else "stratus"
    assert scenario.clouds.layers[0].type == kept


def test_overrides_replace_only_their_key():
    before = Scenario.load("stratus")
    after = Scenario.load("stratus", {"view.zenith": "0.5 rad", "bands.1": "mwir-3.7"})
    assert after.view.zenith == pytest.approx(28.6479, abs=1e-4)
    assert after.bands[1] == "mwir-3.7"
    changed = json.loads(before.to_json())
    changed["view"]["zenith"] = after.view.zenith
    changed["bands"] = list(after.model_dump()["bands"])
    assert json.loads(after.to_json()) == json.loads(json.dumps(changed))


def test_what_the_caller_gave_stays_the_callers():
    raw = {**RAW, "clouds": {"type": "stratus", "parameters": {"k": [0, 3]}}}
    override = {"H": 0.2}
    before = json.dumps(raw)
    scenario = Scenario.from_dict(raw, {"clouds.parameters": override})
    assert json.dumps(raw) == before
    override["H"] = 7
    assert scenario.clouds.layers[0].parameters == {"H": 0.2}


def test_a_scenario_cannot_be_changed():
    scenario = Scenario.load("stratus")
    for target, key in ((scenario, "seed"), (scenario.view, "zenith"), (scenario.clouds.layers[0], "coverage")):
        with pytest.raises(ValidationError, match="frozen"):
            setattr(target, key, 0)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("a=40", 40),
        ("a = 'x'", "x"),
        ("a=50%", "50%"),
        ("a=40 deg", "40 deg"),
        ('a=["mwir", [3.4, 4.1]]', ["mwir", [3.4, 4.1]]),
        ("a=b=c", "b=c"),
        ("a=", ""),
        ("a=3\nseed = 4", "3\nseed = 4"),
        ("a=" + "[" * 5000, "[" * 5000),
        ("a=" + "9" * 5000, "9" * 5000),
        ("a=2024-04-20T12:30:00Z", datetime.fromisoformat("2024-04-20T12:30:00Z")),
    ],
)
def test_assignments_are_toml_or_text(text, value):
    assert parse_assignment(text) == ("a", value)


@pytest.mark.parametrize("text", ["a", "=3", " = 3", ""])
def test_assignments_need_a_key(text):
    with pytest.raises(ValueError, match="key=value"):
        parse_assignment(text)


def as_json(text):
    return json.loads(json.dumps(tomllib.loads(text), default=lambda value: value.isoformat()))


class TestSchema:
    validator = jsonschema.Draft202012Validator(json_schema(), format_checker=jsonschema.FormatChecker())

    def test_it_is_a_schema(self):
        jsonschema.Draft202012Validator.check_schema(json_schema())

    @pytest.mark.parametrize("name", SHIPPED)
    def test_it_accepts_shipped_scenarios_as_written_and_as_serialised(self, name):
        text = (catalog_root() / "scenarios" / f"{name}.toml").read_text(encoding="utf-8")
        self.validator.validate(as_json(text))
        self.validator.validate(json.loads(Scenario.load(name).to_json()))

    @pytest.mark.parametrize("text", [EXAMPLE, FULL])
    def test_it_accepts_the_documented_example_units_and_short_forms(self, text):
        Scenario.from_toml(text)
        self.validator.validate(as_json(text))

    @pytest.mark.parametrize(
        "change",
        [
            {"cloud": {"type": "stratus"}},
            {"view": {"zenit": 3}},
            {"view": {"zenith": 95}},
            {"clouds": {"coverag": 0.3}},
            {"clouds": {"temperature": 100}},
            {"clouds": {"layers": [{"top": 0}]}},
            {"sea": {"temperature": 15}},
            {"image": {"rows": "8"}},
            {"motion": {"evolution_time": "frozn"}},
            {"bands": "mwir"},
            {"bands": [{"name": "x"}]},
            {"place": {"latitude": 3}},
            {"time": 5},
        ],
    )
    def test_it_refuses_what_validation_refuses(self, change):
        raw = {**RAW, **change}
        self.validator.validate(RAW)
        assert not self.validator.is_valid(raw)
        with pytest.raises(ScenarioError):
            Scenario.from_dict(raw)


@pytest.mark.parametrize("clouds", [{}, {"clouds": {}}])
def test_without_cloud_keys_the_sky_is_clear_as_the_reference_says(clouds):
    assert Scenario.from_dict({**RAW, **clouds}).clouds.layers == ()
    section = REFERENCE.read_text(encoding="utf-8").split("## `[clouds]`")[1].split("## ")[0]
    assert "Without keys in this section the sky is clear" in section
