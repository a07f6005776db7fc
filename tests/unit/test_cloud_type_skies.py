"""The generator that a cloud type names for its sky, where its package is installed."""

import json
from pathlib import Path

import pytest

from hcss_twin import Scenario, ScenarioError
from hcss_twin.core.catalog import Catalog

CHOSEN = """
[[sky]]
generator = "imagery"
package = "hcss-twin"
parameters = {image = "made-cumulus.nc"}
coverage = 0.2
pixel_size_max = 100
"""

MISSING = """
[[sky]]
generator = "believable"
package = "hcss-nowhere"
"""


def _scene(folder: Path, sky: str, keys: str = "") -> Scenario:
    cumulus = Catalog().find("paper-cumulus", "cloud_types", ".toml").read_text(encoding="utf-8")
    (folder / "mine.toml").write_text(cumulus + sky, encoding="utf-8")
    text = f"time = 2024-04-20T12:00:00Z\nplace = {{latitude = 20, longitude = -60}}\nclouds.type = 'mine.toml'\n{keys}"
    return Scenario.from_toml(text, base=folder)


def test_type_names_the_generator_and_the_usual_coverage_of_its_sky(tmp_path: Path) -> None:
    layer = _scene(tmp_path, CHOSEN).clouds.layers[0]
    assert layer.generator == "hcss-twin/imagery"
    assert layer.parameters == {"image": "made-cumulus.nc"}
    assert layer.coverage == 0.2


def test_first_sky_that_is_meant_for_the_pixel_size_is_taken(tmp_path: Path) -> None:
    coarse = "\n[[sky]]\ngenerator = 'fractal'\npackage = 'hcss-twin'\nparameters = {H = 0.4}\n"
    fine = _scene(tmp_path, CHOSEN + coarse, "image.pixel_size = 100")
    wide = _scene(tmp_path, CHOSEN + coarse, "image.pixel_size = 101")
    assert fine.clouds.layers[0].generator == "hcss-twin/imagery"
    assert wide.clouds.layers[0].generator == "hcss-twin/fractal"
    assert wide.clouds.layers[0].parameters == {"H": 0.4}


def test_points_smaller_than_those_for_which_a_sky_is_meant_keep_fractal_clouds(tmp_path: Path) -> None:
    of_points = CHOSEN + "pixel_size_min = 20\n"
    assert _scene(tmp_path, of_points, "image.pixel_size = 20").clouds.layers[0].generator == "hcss-twin/imagery"
    finer = _scene(tmp_path, of_points, "image = {pixel_size = 20, samples_per_pixel = 2}")
    assert finer.clouds.layers[0].generator == "fractal"
    (note,) = [note for note in finer.notes if "points" in note]
    assert "fractal at the 10 m between the points" in note
    assert "hcss-twin/imagery, from 20 m on" in note


def test_coverage_that_a_sky_cannot_have_keeps_fractal_clouds_and_a_note_says_why(tmp_path: Path) -> None:
    own = CHOSEN + "own_coverage = true\n"
    scene = _scene(tmp_path, own, "clouds.coverage = 0.7")
    assert scene.clouds.layers[0].generator == "fractal"
    (note,) = scene.notes
    assert "without clouds.coverage" in note
    assert _scene(tmp_path, own).clouds.layers[0].generator == "hcss-twin/imagery"


@pytest.mark.parametrize(
    "keys", ["clouds.generator = 'fractal'", "clouds.parameters = {H = 0.5}", "clouds.edge_taper = 0.1"]
)
def test_layer_that_names_a_generator_or_means_the_fractal_one_keeps_it(tmp_path: Path, keys: str) -> None:
    layer = _scene(tmp_path, CHOSEN, keys).clouds.layers[0]
    assert layer.generator == "fractal"
    assert layer.coverage == 0.5


def test_given_coverage_goes_before_that_of_the_sky(tmp_path: Path) -> None:
    assert _scene(tmp_path, CHOSEN, "clouds.coverage = 0.7").clouds.layers[0].coverage == 0.7


def test_thinnest_cloud_of_the_sky_goes_before_that_of_the_type_and_after_a_given_one(tmp_path: Path) -> None:
    thin = CHOSEN + "thickness_min = 2.0\n"
    assert _scene(tmp_path, thin).clouds.layers[0].thickness_min == 2.0
    assert _scene(tmp_path, thin, "clouds.thickness_min = 5").clouds.layers[0].thickness_min == 5.0
    assert _scene(tmp_path, CHOSEN).clouds.layers[0].thickness_min is None


def test_without_the_package_clouds_are_fractal_and_one_note_names_it(tmp_path: Path) -> None:
    scene = _scene(tmp_path, MISSING)
    assert scene.clouds.layers[0].generator == "fractal"
    (note,) = scene.notes
    assert "hcss-nowhere" in note
    assert "pip install" in note


def test_parameters_that_the_generator_refuses_are_told_with_the_type(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match=r"'mine.toml': sky.parameters.immage.*closest is 'image'"):
        _scene(tmp_path, CHOSEN.replace("image =", "immage ="))


def test_scenario_of_a_cube_keeps_the_generator_with_which_it_was_made(tmp_path: Path) -> None:
    scene = _scene(tmp_path, MISSING)
    again = Scenario.from_dict(json.loads(scene.to_json()), base=tmp_path)
    assert again.clouds.layers[0].generator == "hcss-twin/fractal"
    assert again.notes == ()


def test_generator_that_an_installed_package_has_not_is_told(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match=r"clouds.layers\[0\].type: 'mine.toml': .*imagerie"):
        _scene(tmp_path, CHOSEN.replace('"imagery"', '"imagerie"'))
