"""Sections, files and parameters of sensors: what is taken, and what is told when they are wrong."""

import json

import numpy as np
import pytest
from refusals import problems_of

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import CatalogError, ScenarioError
from hcss_twin.models.sensor.point_spread import read_kernel
from hcss_twin.scenario.instrument import load_instrument
from hcss_twin.scenario.scenario import Scenario
from hcss_twin.scenario.sensor import SensorSection, choose_sensor

SCENE = """
time = 2024-04-20T12:30:00+10:00
place = {latitude = 35.0, longitude = 150.0}
"""


def scenario(text="", base=None, **overrides):
    return Scenario.from_toml(SCENE + text, overrides, base=base)


def problems(text="", base=None, **overrides):
    return problems_of(lambda: scenario(text, base, **overrides))


def of_parameters(**parameters):
    return "; ".join(problems(**{"sensor.parameters": parameters}).values())


def test_without_the_section_a_scenario_is_written_as_ever():
    assert "sensor" not in json.loads(scenario().to_json())
    assert scenario().sensor is None


def test_a_section_survives_being_written():
    one = scenario('[sensor]\nname = "modis"\nvariables = ["all"]\nseed = 4\n')
    assert Scenario.from_dict(json.loads(one.to_json()), base=one.base) == one


@pytest.mark.parametrize("name", Catalog().names("instruments", ".toml"))
def test_shipped_sensors_are_sound_and_bring_their_bands(name):
    sensor = load_instrument(name, Catalog())
    assert all(sensor.sources.values())
    loaded = scenario(**{"sensor.name": name})
    assert loaded.bands == sensor.bands
    assert scenario('bands = ["lwir"]\n', **{"sensor.name": name}).bands == ("lwir",)


def test_bands_may_come_from_any_stage():
    stages = [{"model": "radiometer"}, {"name": "modis"}]
    assert scenario(**{"sensor.stages": stages}).bands == load_instrument("modis", Catalog()).bands


def test_keys_of_the_section_go_before_those_of_the_named_sensor():
    choice = choose_sensor(SensorSection(name="landsat-8-tirs", parameters={"nedt": 0.4}), Catalog())
    assert choice.model == "hcss-twin/radiometer"
    assert choice.parameters.items() >= {"noise": "nedt", "nedt": 0.4, "nedt_temperature": 300.0}.items()
    other = choose_sensor(SensorSection(name="landsat-8-tirs", model="hcss-other/pinhole"), Catalog())
    assert (other.model, other.parameters) == ("hcss-other/pinhole", {})


@pytest.mark.parametrize(
    ("text", "field", "message"),
    [
        ('name = "modos"', "sensor.name", "'modos' is neither in catalogs/instruments nor a file;.*is 'modis'"),
        ('model = "radiometr"', "sensor.model", "no sensor model is called 'radiometr'; .*closest is 'radiometer'"),
        ("naem = 1", "sensor.naem", "unknown key; .*closest is 'name'"),
        ("parameters = {psff = 1}", "sensor.parameters.psff", "unknown key; .*closest is 'psf'"),
        ('parameters = {psf = "gauss"}', "sensor.parameters.psf", "'gauss' is not a choice; .*closest is 'gaussian'"),
        ("seed = -1", "sensor.seed", "-1 is out of range"),
    ],
)
def test_a_wrong_section_is_told_by_key_value_and_choices(text, field, message):
    import re

    found = problems(f"[sensor]\n{text}\n")
    assert re.search(message, found[field]), found


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"psf": "gaussian"}, 'psf = "gaussian" needs psf_sigma'),
        ({"psf": "airy", "pixel_angle": 1e-5}, 'psf = "airy" needs aperture_diameter'),
        ({"noise": "photon"}, "needs aperture_diameter and pixel_angle and integration_time"),
        ({"noise": "nedt"}, 'noise = "nedt" needs nedt'),
        ({"psf_sigma": 1.0}, 'psf_sigma has no influence with psf = "none"; allowed with psf = "gaussian"'),
        ({"read_noise": 3.0}, 'read_noise has no influence with noise = "none"; allowed with noise = "photon"'),
        ({"pixel_angle": 1e-5}, "pixel_angle has no effect without aperture_diameter"),
        ({"transmission": 0.5}, "transmission has no effect without aperture_diameter and pixel_angle"),
        ({"bits": 12}, "bits needs radiance_per_number, saturation_radiance or saturation_temperature"),
        ({"number_offset": 3}, "number_offset has no effect without bits"),
        ({"bits": 4, "radiance_per_number": 1.0, "number_offset": 16}, "allowed with 4 bits: 0 to 15"),
        ({"noise": "ner", "ner": -1.0}, "-1 is out of range; allowed: a number from 1e-12 to 1e\\+09"),
        ({"noise": "ner", "ner": {"mwir": "x"}}, "band 'mwir': 'x' is not a number"),
        ({"noise": "ner", "ner": {}}, "a table without names of bands"),
        ({"noise": "ner", "ner": True}, "True is not a number"),
        ({"quantum_efficiency": 1.5}, "1.5 is out of range.*closest valid choice is 1"),
    ],
)
def test_parameters_that_do_not_fit_are_told(parameters, message):
    import re

    assert re.search(message, of_parameters(**parameters)), of_parameters(**parameters)


def test_a_number_for_each_of_the_bands_is_needed():
    from hcss_twin import make_plan

    with pytest.raises(ScenarioError, match=r"sensor.parameters.nedt: gives no number for band 'lwir'; allowed: mwir"):
        make_plan(
            scenario('bands = ["mwir", "lwir"]\n', **{"sensor.parameters": {"noise": "nedt", "nedt": {"mwir": 0.1}}})
        )


@pytest.mark.parametrize(
    ("overrides", "message"),
    [
        (
            {"sensor.variables": ["saturatd"]},
            "sensor.variables: 'saturatd' is not an output of the sensor 'radiometer' with these parameters",
        ),
        (
            {"sensor.seed": 1, "output.variables": ["geometry"]},
            "output.variables: \\[sensor\\] measures frames, of which no variable is requested",
        ),
        (
            {"sensor.parameters": {"psf": "file", "psf_file": "nowhere.txt"}},
            "sensor.parameters.psf_file: no file 'nowhere.txt'",
        ),
    ],
)
def test_the_plan_finds_what_the_sensor_cannot_do(overrides, message):
    from hcss_twin import make_plan

    with pytest.raises(ScenarioError, match=message):
        make_plan(scenario(**overrides))


def test_a_users_sensor_needs_a_source_for_each_number(tmp_path):
    text = 'title = "mine"\nparameters = {noise = "ner", ner = 0.1}\n[sources]\nnoise = "measured"\n'
    (tmp_path / "mine.toml").write_text(text, encoding="utf-8")
    assert "sources lacks ner" in problems(base=tmp_path, **{"sensor.name": "mine.toml"})["sensor.name"]
    (tmp_path / "mine.toml").write_text(f'{text}ner = "measured"\n', encoding="utf-8")
    assert scenario(base=tmp_path, **{"sensor.name": "mine.toml"}).sensor.name == "mine.toml"


def test_wrong_bands_of_a_users_sensor_are_told_at_its_name(tmp_path):
    text = 'title = "mine"\nbands = [[5, 3]]\n[sources]\nbands = "measured"\n'
    (tmp_path / "mine.toml").write_text(text, encoding="utf-8")
    found = problems(base=tmp_path, **{"sensor.name": "mine.toml"})
    assert list(found) == ["sensor.name"]
    assert "bands[0]: [5, 3] um is reversed" in found["sensor.name"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("1 2 1\n2 4 2\n", "2 x 3; allowed: an odd number of rows and of columns"),
        ("1 2 1\n2 4\n1 2 1\n", "line 2: 2 numbers, the first row has 3"),
        ("a b c\n", "line 1: could not convert string to float: 'a'"),
        ("1 -1 0\n", "the numbers sum to 0; allowed: finite numbers with a sum above 0"),
        ("nan 1 1\n", "finite numbers with a sum above 0"),
        ("# nothing\n", "no rows; allowed"),
    ],
)
def test_a_wrong_kernel_is_told(tmp_path, text, message):
    path = tmp_path / "kernel.txt"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(CatalogError, match=message):
        read_kernel(path)


def test_a_kernel_is_read_with_blanks_commas_and_comments_and_scaled_to_one(tmp_path):
    path = tmp_path / "kernel.txt"
    path.write_text("# of the test bench\n0, 1, 0\n1 4 1  # the middle\n\n0 1 0\n", encoding="utf-8")
    np.testing.assert_array_equal(read_kernel(path), np.array([[0, 1, 0], [1, 4, 1], [0, 1, 0]]) / 8.0)
