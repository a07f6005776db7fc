"""Frames, pixels, saved files and runs without a browser or a server."""

import numpy as np
import pytest
from conftest import SCENE
from hcss_explore.controls import CLEAR, controls
from hcss_explore.explorer import ExploreError, Explorer

from hcss_twin import Scenario, ScenarioError, brightness_temperature, make_plan, open_cube, simulate
from hcss_twin.engine.simulate import run
from hcss_twin.providers import Catalog

OTHERS = 'sea.wind_from = 200\noutput.variables = ["radiance", "cloud_thickness"]\n'
CHANGES = {"view.zenith": "35", "clouds.coverage": "0.3", "seed": "11", "sea.temperature": "15 degC", "others": OTHERS}


def test_a_saved_scenario_has_the_image_of_the_page(explorer, folder):
    picture = explorer.picture(CHANGES, 2, False)
    path = explorer.save(CHANGES, "mine")
    assert path == folder / "mine.toml"
    cube = simulate(Scenario.load(path))
    frame = cube.isel(time=2)
    assert np.array_equal(frame["radiance"].to_numpy(), picture.radiance)
    assert np.array_equal(frame["cloud_thickness"].to_numpy() > 0.0, picture.thickness > 0.0)
    kelvin = brightness_temperature(cube).isel(time=2).to_numpy()
    assert np.abs(kelvin - picture.kelvin).max() < 1e-3


@pytest.mark.parametrize("clouds", [{"type": "stratus"}, {"layers": [{"type": "stratus"}]}])
def test_controls_of_the_only_layer_show_its_defaults(clouds):
    raw = {"time": "2024-04-20T12:00:00Z", "place": {"latitude": 35.0, "longitude": 150.0}, "clouds": clouds}
    scenario = Scenario.from_dict(raw)
    shown = {each["key"]: each for group in controls(raw, scenario, Catalog()) for each in group["controls"]}
    cover = shown["clouds.coverage" if "type" in clouds else "clouds.layers[0].coverage"]
    assert (cover["value"], float(cover["default"])) == ("", scenario.clouds.layers[0].coverage)


def test_a_saved_scenario_with_a_sensor_has_the_measured_image_of_the_page(explorer, folder):
    given = {"sensor": "generic-mwir"}
    picture = explorer.picture(given, 1, True)
    assert picture.about["measured"]
    path = explorer.save(given, "measured")
    run(make_plan(Scenario.load(path)), folder / "measured.nc")
    with open_cube(folder / "measured.sensor.nc") as cube:
        assert np.array_equal(cube["radiance"].isel(time=1).to_numpy(), picture.radiance)
    clean = explorer.picture(given, 1, False)
    assert not clean.about["measured"]
    assert clean.about["has_sensor"]
    assert not np.array_equal(clean.radiance, picture.radiance)


def test_nothing_is_planned_again_for_another_frame_or_a_control_set_back(folder):
    explorer, steps = Explorer(str(folder / "scene.toml")), []
    explorer.picture({}, 0, False, steps.append)
    assert steps == ["plan", "tables", "frame"]
    for given, number, expected in (
        ({}, 2, ["frame"]),
        ({"seed": "9"}, 2, ["plan", "tables", "frame"]),
        ({}, 0, ["frame"]),
    ):
        steps.clear()
        picture = explorer.picture(given, number, False, steps.append)
        assert steps == expected
        assert picture.about["kept"] == (expected == ["frame"])


def test_the_parts_of_a_pixel_add_up_to_its_radiance(explorer):
    picture = explorer.picture({}, 1, False)
    cloudy, clear = (np.argwhere((picture.thickness > 0.0) == wanted)[5] for wanted in (True, False))
    for (row, column), band in ((cloudy, 0), (cloudy, 1), (clear, 0), (clear, 1)):
        pixel = explorer.pixel({}, 1, int(row), int(column), band)
        of_image = float(picture.radiance[band, row, column])
        assert sum(pixel["band_parts"].values()) == pytest.approx(pixel["column_radiance"], rel=1e-12)
        assert pixel["radiance"] == of_image
        assert pixel["column_radiance"] == pytest.approx(of_image, rel=2e-3)
        assert pixel["column_kelvin"] == pytest.approx(picture.kelvin[band, row, column], abs=0.1)
        assert sum(pixel["thickness_m"]) == pytest.approx(picture.thickness[row, column])
        assert ("cloud_emission" in pixel["parts"]) == (picture.thickness[row, column] > 0.0)
        spectrum = np.sum(list(pixel["parts"].values()), axis=0)
        integral = abs(np.trapezoid(spectrum, pixel["wavelength_um"]))
        assert integral == pytest.approx(pixel["column_radiance"], rel=0.02)


def test_a_spectrum_makes_way_for_newer_requests(explorer):
    class NotWantedError(Exception):
        pass

    def refuse():
        raise NotWantedError

    with pytest.raises(NotWantedError):
        explorer.pixel({}, 0, 3, 3, 0, refuse)


def test_problems_are_those_of_the_core(explorer):
    given = {
        "view.zenith": "95",
        "clouds.type": "stratuss",
        "bands": ["lwirr"],
        "sea.temperature": "warm",
        "time": "noon",
    }
    with pytest.raises(ScenarioError) as of_page:
        explorer.picture(given, 0, False)
    changes = {**given, "view.zenith": 95}
    with pytest.raises(ScenarioError) as of_core:
        Scenario.from_toml(SCENE, changes, base=explorer.base)
    assert set(of_page.value.problems) == set(of_core.value.problems)
    assert len(of_page.value.problems) == 5


def test_a_pixel_outside_the_image_is_refused(explorer):
    for row, column, number in ((24, 0, 0), (-1, 0, 0), (0, 32, 0), (0, 0, 3)):
        with pytest.raises(ExploreError, match="allowed: those of the image"):
            explorer.pixel({}, number, row, column, 0)
    for band in (-1, 2):
        with pytest.raises(ExploreError, match="allowed: 0 to 1"):
            explorer.pixel({}, 0, 0, 0, band)


@pytest.mark.parametrize("name", ["", "../outside", "a/b", ".hidden", "x" * 90, "a\0b", "-rf"])
def test_a_name_that_leads_elsewhere_is_refused_and_nothing_is_written(explorer, folder, name):
    before = set(folder.rglob("*"))
    with pytest.raises(ExploreError, match="name"):
        explorer.save({}, name)
    assert set(folder.rglob("*")) == before


def test_files_are_replaced_only_if_asked_and_the_explored_one_never(explorer, folder):
    (folder / "taken.toml").write_text("another", encoding="utf-8")
    with pytest.raises(ExploreError, match=r"taken\.toml exists"):
        explorer.save({}, "taken")
    explorer.save({}, "taken.toml", replace=True)
    assert Scenario.load(folder / "taken.toml") == Scenario.load(folder / "scene.toml")
    with pytest.raises(ExploreError, match="is explored"):
        explorer.save({}, "scene", replace=True)
    with pytest.raises(ScenarioError):
        explorer.save({"view.zenith": "95"}, "wrong")
    assert not (folder / "wrong.toml").exists()
    assert (folder / "scene.toml").read_text(encoding="utf-8") == SCENE


def test_a_run_says_what_hcss_run_says_and_leaves_nothing(explorer, folder):
    before = set(folder.rglob("*"))
    said = explorer.run({"frames.count": "1"}, lambda: True)
    assert said["code"] == 0, said["text"]
    lines = said["text"].splitlines()
    assert any(line.startswith("scene.nc") for line in lines)  # the first may say that kernels are compiled
    assert any(line.startswith("next:") for line in lines)
    assert explorer.run({}, lambda: False) == {"text": "", "code": None}
    assert set(folder.rglob("*")) == before


def test_a_large_image_begins_smaller_and_the_page_says_so():
    explorer = Explorer("stratus")
    assert (explorer.raw["image"]["rows"], explorer.raw["image"]["columns"]) == (256, 256)
    assert "800 x 800" in explorer.notes[0]
    assert Explorer("stratus", {"image.rows": 200, "image.columns": 300}).notes == []


CAMERA = """\
[image]
pixel_size = "30 m"

[orbit]
provider = "sun-synchronous"
altitude = "500 km"
above = [35.0, 150.0]

[attitude]
provider = "track"

"""
WRITTEN = """\
[camera]
rows = 24
columns = 32
focal_length = "250 mm"
detector_pitch = "15 um"
"""
FOLLOWS = """\
[instrument]
f_number = 2
rows = 24
columns = 32
focal_length = "250 mm"
detector_pitch = "15 um"
nedt = "20 mK at 300 K"
"""
START, END = SCENE.index("[view]"), SCENE.index("[frames]")


@pytest.mark.parametrize("camera", [WRITTEN, FOLLOWS], ids=["written", "follows from the instrument"])
def test_a_scene_of_a_camera_has_its_pixels_and_no_view_or_size_that_nobody_stated(folder, camera):
    pytest.importorskip("hcss_payload")
    scene = folder / "camera.toml"
    scene.write_text(SCENE[:START] + CAMERA + camera + SCENE[END:], encoding="utf-8")
    explorer = Explorer(str(scene))
    keys = {each["key"] for group in explorer.controls for each in group["controls"]}
    assert "orbit.altitude" in keys
    assert not keys & {"view.zenith", "view.azimuth", "image.rows", "image.columns", "image.pixel_size"}
    assert all(group["controls"] for group in explorer.controls)
    given = {"orbit.altitude": "600 km", "frames.count": "1"}
    picture = explorer.picture(given, 0, False)
    assert picture.radiance.shape == (2, 24, 32)
    assert not [note for note in picture.about["notes"] if "begins with" in note]
    saved = Scenario.read_file(str(explorer.save(given, "camera saved", replace=True)))[0]
    stated = Scenario.read_file(str(scene))[0]
    assert saved == {**stated, "orbit": {**stated["orbit"], "altitude": "600 km"}, "frames": {"count": 1}}


@pytest.mark.parametrize("name", Catalog().names("scenarios", ".toml"))
def test_every_shipped_scenario_has_controls_whose_values_change_nothing(name):
    explorer = Explorer(name)
    given = {
        each["key"]: each["value"]
        for group in explorer.controls
        for each in group["controls"]
        if each["value"] not in ("", "off", CLEAR)
    }
    assert {"time", "place.latitude", "sea.temperature", "bands"} <= {
        each["key"] for group in explorer.controls for each in group["controls"]
    }
    same = Scenario.from_toml(explorer.toml(given), base=explorer.base)
    assert same == Scenario.from_dict(explorer.raw, base=explorer.base)


def test_controls_follow_the_scenario():
    def keys(text):
        scenario = Scenario.from_toml(text)
        import tomllib

        return [
            each["key"] for group in controls(tomllib.loads(text), scenario, Catalog()) for each in group["controls"]
        ]

    start = "time = 2024-04-20T12:30:00+10:00\nplace = {latitude = 35.0, longitude = 150.0}\n"
    assert "view.zenith" in keys(start)
    geostationary = keys(start + "platform = {longitude = 140.0}")
    assert "platform.longitude" in geostationary
    assert "view.zenith" not in geostationary
    looking = keys(start + 'platform = {altitude = "700 km", off_nadir = 20.0}')
    assert {"platform.altitude", "platform.off_nadir"} <= set(looking)
    layers = keys(start + 'clouds.layers = [{type = "stratus"}, {type = "cirrus"}]')
    assert {"clouds.layers[0].type", "clouds.layers[1].coverage"} <= set(layers)


def test_a_clear_sky_gets_clouds_and_loses_them(explorer):
    with_clouds = explorer.picture({}, 0, False)
    cleared = explorer.picture(
        {"clouds.type": CLEAR, "clouds.coverage": "", "others": "", "clouds.parameters": None}, 0, False
    )
    assert with_clouds.thickness.max() > 0.0
    assert cleared.thickness.max() == 0.0
