"""An instrument: what follows from it, and what is refused."""

import json
import math

import pytest
from refusals import problems_of

from hcss_twin.core.catalog import Catalog
from hcss_twin.scenario.instrument import Instrument, load_instrument
from hcss_twin.scenario.instrument_keys import take_instrument
from hcss_twin.scenario.scenario import Scenario

SCENE = {"time": "2024-07-20T12:30:00+10:00", "place": {"latitude": 30.0, "longitude": 140.0}}
CAMERA = {
    "f_number": 2,
    "detector_pitch": "15 um",
    "pixel_angle": "60 urad",
    "rows": 64,
    "columns": 80,
    "jitter": "0.3 px",
    "bits": 14,
    "nedt": "20 mK at 295 K",
    "saturation_temperature": "330 K",
    "bands": [[3.7, 4.8]],
}
FAR = {"altitude": "500 km"}


def scenario(**sections):
    return Scenario.from_dict({**SCENE, **sections})


def problems(**sections):
    return problems_of(lambda: scenario(**sections))


def test_image_platform_bands_and_sensor_follow_from_an_instrument():
    one = scenario(instrument=CAMERA, platform=FAR)
    assert (one.image.rows, one.image.columns) == (64, 80)
    assert one.image.pixel_size == pytest.approx(30.0)  # 60 urad from 500 km
    assert one.bands == ((3.7, 4.8),)
    assert one.sensor.parameters == pytest.approx(
        {
            "noise": "nedt",
            "nedt": 0.02,
            "nedt_temperature": 295.0,
            "saturation_temperature": 330.0,
            "bits": 14,
            "jitter": 0.3,
            "pixel_angle": 60e-6,
            "aperture_diameter": 0.125,  # 250 mm / 2
            "psf": "airy",
        }
    )


def test_a_scenario_is_written_with_what_follows_and_read_again():
    one = scenario(instrument={**CAMERA, "name": "generic-mwir", "aperture_diameter": "125 mm"}, platform=FAR)
    data = json.loads(one.to_json())
    assert "instrument" not in data
    assert Scenario.from_dict(data) == one


def test_a_camera_in_orbit_takes_what_the_grid_would():
    data = {**SCENE, "instrument": CAMERA, "orbit": {"provider": "circular"}}
    assert take_instrument(data, Catalog())[0] == []
    assert data["camera"] == pytest.approx({"rows": 64, "columns": 80, "focal_length": 0.25, "detector_pitch": 15e-6})
    assert data["jitter"]["rms"] == pytest.approx([math.degrees(18e-6)] * 2 + [0.0])
    assert "jitter" not in data["sensor"]["parameters"]
    assert "image" not in data


@pytest.mark.parametrize(
    ("keys", "known"),
    [
        ({"f_number": 2.0, "aperture_diameter": 0.1, "detector_pitch": 2e-5}, {"focal_length": 0.2}),
        ({"f_number": 2.0, "focal_length": 0.1}, {"aperture_diameter": 0.05}),
        ({"pixel_angle": 1e-4, "detector_pitch": 2e-5, "f_number": 4.0}, {"aperture_diameter": 0.05}),
        ({"pixel_angle": 1e-4, "focal_length": 0.2}, {"detector_pitch": 2e-5}),
        ({"f_number": 2.0}, {}),
    ],
)  # fmt: skip
def test_two_of_three_keys_give_the_third(keys, known):
    found = Instrument(**keys).geometry
    assert {name: found.get(name) for name in {**keys, **known}} == pytest.approx({**keys, **known})
    assert known or found == keys


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"f_number": 2, "focal_length": "100 mm", "aperture_diameter": "40 mm"}, "f_number 2, .* make 2.5; allowed"),
        ({"pixel_angle": "40 urad", "focal_length": "1 m", "detector_pitch": "50 um"}, "angle 4e-05, .* make 5e-05"),
        ({"bands": ["mwir"], "response": "a.csv"}, "response with bands; allowed: one of them"),
        ({"jitter": "20 urad"}, "jitter as an angle needs"),
        ({"jitter": "2 furlongs"}, "no jitter; allowed: a number of pixels, or text with px, rad, mrad"),
        ({"cold_shield": 3.0, "f_number": 2.0}, "cold_shield f/3 with optics of f/2"),
        ({"nedt": "20 mK", "saturation_temperature": 330, "saturation_radiance": 3.0}, "allowed: one of them"),
        ({"nedt": "20 mK", "drift": "5 mK"}, "drift has no effect without calibration_cycle"),
        ({"nedt": "20 mK at 300 K", "nedt_temperature": 290}, "another scene temperature"),
        ({"model": "hcss-other/pinhole", "nedt": 0.1}, "nedt with model 'hcss-other/pinhole'"),
        ({"nedt": 0.1, "parameters": {"nedt": 0.1}}, "nedt also in parameters"),
    ],
)  # fmt: skip
def test_contradictions_are_named(keys, message):
    import re

    found = problems(instrument=keys, image={"pixel_size": 20})
    assert list(found) in (["instrument"], ["instrument.jitter"], ["instrument.nedt"])
    assert re.search(message, " ".join(found.values())), found


@pytest.mark.parametrize(
    ("sections", "field", "message"),
    [
        ({"image": {"rows": 7}}, "image.rows", "7 with instrument.rows, which means 64; allowed: one of them"),
        ({"platform": {**FAR, "focal_length": "1 m"}}, "platform.focal_length", "1 m' with instrument.*means 0.25"),
        ({"sensor": {"name": "modis"}}, "sensor.name", "'modis' with \\[instrument\\]; allowed: one of them"),
        ({"sensor": {"parameters": {"nedt": 0.1}}}, "sensor.parameters.nedt", "0.1 with \\[instrument\\], .* 0.02"),
        ({"sensor": {"stages": [{"name": "modis"}]}}, "sensor.stages", "one without both, which is the instrument"),
        ({"image": {"pixel_size": 99}}, "instrument.detector_pitch", "with image.pixel_size 99 m, and means 30 m"),
    ],
)
def test_other_keys_must_not_say_something_else(sections, field, message):
    import re

    found = problems(**{"instrument": CAMERA, "platform": FAR, **sections})
    assert re.search(message, found[field]), found


def test_keys_that_agree_are_no_contradiction():
    same = {"image": {"rows": 64, "pixel_size": 30.2}, "sensor": {"parameters": {"nedt": 0.02}, "variables": ["all"]}}
    assert scenario(instrument=CAMERA, platform=FAR, **same).sensor.variables == ("all",)


def test_a_stage_without_name_and_model_is_the_instrument():
    stages = [{"model": "radiometer", "parameters": {"psf": "gaussian", "psf_sigma": 1.0}}, {"seed": 3}]
    found = scenario(instrument=CAMERA, platform=FAR, sensor={"stages": stages}).sensor.stages
    assert found[1].seed == 3
    assert found[1].parameters["nedt"] == 0.02


def test_an_instrument_needs_a_distance():
    assert "needs a distance" in problems(instrument="modis")["instrument"]


def test_keys_of_the_scenario_override_those_of_the_file():
    image = {"image": {"pixel_size": 100}}
    found = scenario(instrument={"name": "landsat-8-tirs", "nedt": "80 mK at 280 K"}, **image).sensor
    assert (found.name, found.parameters["nedt"], found.parameters["nedt_temperature"]) == ("landsat-8-tirs", 0.08, 280)


@pytest.mark.parametrize("name", Catalog().names("instruments", ".toml"))
def test_shipped_instruments_are_sound_and_complete(name):
    file = load_instrument(name, Catalog())
    assert file.bands is not None
    assert all(file.sources.values())
    platform = {"altitude": "705 km"}
    one = scenario(instrument=name, platform=platform)
    assert one.image.pixel_size == pytest.approx(705e3 * file.geometry["pixel_angle"])
    assert one.sensor.name == name


def test_every_number_of_a_file_has_a_source(tmp_path):
    (tmp_path / "mine.toml").write_text('title = "x"\nnedt = 0.1\nf_number = 2\n[sources]\nnedt = "data sheet"\n')
    found = problems_of(lambda: Scenario.from_dict({**SCENE, "instrument": "mine.toml"}, base=tmp_path))
    assert "sources lacks f_number" in found["instrument.name"]


def test_the_schema_takes_instruments_as_people_write_them():
    import jsonschema

    from hcss_twin.scenario.reference import json_schema

    validator = jsonschema.Draft202012Validator(json_schema())
    by_band = {"nedt": {"a": "20 mK at 300 K", "b": 0.1}, "bands": [{"name": "a", "limits": [3.7, 4.8]}]}
    for instrument in ("modis", CAMERA, by_band):
        validator.validate({**SCENE, "instrument": instrument})
    for wrong in ({"nedt": "20 mK around 300 K"}, {"f_number": "2 m"}, {"nedtt": 1}, 7):
        assert not validator.is_valid({**SCENE, "instrument": wrong}), wrong


@pytest.mark.parametrize(
    ("section", "key", "text", "value"),
    [
        ("sea", "fetch_m", "200 km", 200e3),
        ("atmosphere", "visibility_km", "15000 m", 15.0),
        ("surfaces", "land_temperature", "20 degC", 293.15),
    ],
)
def test_parameters_of_providers_take_units(section, key, text, value):
    from hcss_twin.providers.registry.registry import Registry
    from hcss_twin.providers.registry.specs import Kind

    name = {"sea": "rough-sea", "atmosphere": "band-model", "surfaces": "coast"}[section]
    registry = Registry.discover()
    model = registry.parameters_model(registry.resolve(Kind(section), name))
    assert getattr(model.model_validate({key: text}), key) == pytest.approx(value)
    assert scenario(**{section: {"provider" if section != "sea" else "model": name, "parameters": {key: text}}})


def test_an_override_opens_a_named_instrument():
    one = Scenario.from_dict(
        {**SCENE, "instrument": "viirs-i", "platform": {"altitude": "829 km"}}, {"instrument.nedt": "0.3 K at 260 K"}
    )
    assert (one.sensor.name, one.sensor.parameters["nedt"]) == ("viirs-i", 0.3)


def test_what_the_plan_finds_is_told_at_the_instrument():
    from hcss_twin import make_plan

    keys = {"nedt": {"other": 0.1}, "bands": [[10.0, 10.2]], "pixel_angle": 1e-4, "rows": 8, "columns": 8}
    found = problems_of(lambda: make_plan(scenario(instrument=keys, platform=FAR, clouds={"layers": []})))
    assert "gives no number for band '10-10.2um'" in found["instrument.nedt"]


@pytest.mark.parametrize(
    ("keys", "psf"),
    [({}, "airy"), ({"psf": "none"}, "none"), ({"psf_sigma": 0.5}, "gaussian"), ({"psf_file": "psf.txt"}, "file")],
)
def test_diffraction_is_the_point_spread_of_an_aperture_unless_another_is_stated(keys, psf):
    assert Instrument(**CAMERA, **keys).sensor_parameters()["psf"] == psf


def test_without_an_aperture_there_is_no_point_spread():
    keys = {name: value for name, value in CAMERA.items() if name != "f_number"}
    assert Instrument(**keys).sensor_parameters()["psf"] == "none"


def test_unit_and_column_of_a_response_file_are_those_of_the_band():
    one = Instrument(response="camera.csv", response_unit="nm", response_column="2")
    band = {"name": "camera", "response": "camera.csv", "unit": "nm", "column": "2"}
    assert one.band_keys() == [band]


@pytest.mark.parametrize("name", ["response_unit", "response_column"])
def test_keys_about_a_response_file_without_one_are_refused(name):
    given = {**CAMERA, name: "nm"}
    assert f"{name} has no effect without response" in str(problems(instrument=given, platform=FAR))


@pytest.mark.parametrize("unit", ["percent", "%", "fraction"])
@pytest.mark.parametrize(
    ("field", "keys"),
    [
        (
            "instrument.response_unit",
            lambda unit: {"instrument": {**CAMERA, "response": "a.csv", "response_unit": unit}},
        ),
        ("bands[0].unit", lambda unit: {"bands": [{"name": "a", "response": "a.csv", "unit": unit}]}),
    ],
)
def test_a_unit_of_the_response_is_answered_by_what_percent_is_known_by(unit, field, keys):
    found = problems(**keys(unit), platform=FAR)
    assert f"'{unit}' is a unit of the response, which needs none: numbers above 1.5" in found[field]
