"""Elements have the same bits however a scene is divided, and scenes without elements none of them."""

import json
from functools import partial

import numpy as np
import pytest
from cheap import CHEAP
from written_cubes import assert_same_bits

from hcss_twin import Scenario, make_plan
from hcss_twin.core.errors import ScenarioError
from hcss_twin.cube.reader import open_cube
from hcss_twin.engine import parts, stream
from hcss_twin.engine.simulate import run
from hcss_twin.engine.verification import Verdict, verify_cube
from hcss_twin.plan.windows import windows

TRACKS = """source, time, x, y, altitude, temperature, area
7, -1, -300, 20, 4000, 700, 3
7, 5, 300, -80, 4000, 700, 3
2, 0, 0, 0, 0, 320, 40
2, 0.5, 5, 0, 0, 320, 40
"""
SCENE = """
time = 2024-04-20T12:30:00+10:00
place = {latitude = 35.0, longitude = 150.0}
image = {rows = 30, columns = 40, samples_per_pixel = 2}
frames.count = 2
bands = [{name = "mwir", limits = [3.6, 3.8]}, {name = "lwir", limits = [10.5, 11.0]}]
clouds = {type = "stratus", coverage = 0.5, coverage_mode = "field"}
output.variables = ["radiance", "truth", "terms", "element_radiance"]

[[elements]]
[elements.parameters]
footprint = 50.0
file = "tracks.csv"

[[elements]]
provider = "point-sources"
parameters = {tracks = [{x = -10, y = 5, altitude = 10000, intensity = {mwir = 2e3, lwir = 5e2}}]}
"""


NONE = {"elements": [], "output.variables": ["radiance", "truth", "terms"]}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("elements")
    (path / "tracks.csv").write_text(TRACKS)
    return path


def written(folder, name, workers=1, **changes):
    plan = make_plan(Scenario.from_toml(SCENE, {**CHEAP, **changes}, base=folder))
    return run(plan, folder / name, workers=workers)


@pytest.fixture(scope="module")
def whole(folder):
    return written(folder, "whole.nc")


def test_windows_tiles_and_workers_have_the_same_bits(folder, whole):
    again = partial(written, folder, **{"output.certificate": 0})
    part = slice(11, 19), slice(17, 26)
    assert_same_bits(whole, again("part.nc", **{"image.window": {"rows": [11, 19], "columns": [17, 26]}}), part)
    # Patches of its own, on which no analysis of the scene depends: that of the whole serves.
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(stream, "windows", partial(windows, most_points=300))
        assert_same_bits(whole, again("strips.nc"))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(parts, "LARGEST_FRAME_BYTES", 1)
        patch.setattr(parts, "TILE_PIXELS", 90)
        assert_same_bits(whole, again("tiles.nc"))
        assert_same_bits(whole, again("workers.nc", workers=2))


def test_a_clear_scene_of_several_windows_keeps_the_elements_of_each(folder, monkeypatch):
    clear = {"clouds": {}, "output.certificate": 0}
    one = written(folder, "clear.nc", **clear)
    monkeypatch.setattr(stream, "windows", partial(windows, most_points=300))
    assert_same_bits(one, written(folder, "clear-strips.nc", **clear))


def test_truth_names_the_pixels_that_differ_from_the_scene_without_elements(folder, whole):
    with open_cube(whole) as cube, open_cube(written(folder, "plain.nc", **NONE)) as plain:
        changed = np.any(cube["radiance"].to_numpy() != plain["radiance"].to_numpy(), axis=1)
        number = cube["element"].to_numpy()
        assert np.all(number[changed] > 0)
        seen = (number > 0) & ~(plain["cloud_mask"].to_numpy() > 0)
        assert np.all(changed[seen])
        assert set(np.unique(number)) == {0, 1, 2}
        np.testing.assert_array_equal(cube["element_share"].to_numpy() > 0, number > 0)
        np.testing.assert_allclose(cube["radiance"] - cube["element_radiance"], plain["radiance"], rtol=1e-6, atol=1e-6)
        sources = cube["element_source"].to_numpy()
        assert set(sources[0][number[0] == 1]) == {1.0, 2.0}
        assert set(sources[1][number[1] == 1]) == {2.0}  # source 2 of the file has gone
        np.testing.assert_array_equal(np.isnan(sources), number == 0)
        assert not {"element", "element_share", "element_source"} & set(plain.data_vars)
        assert "elements" not in json.loads(plain.attrs["hcss_scenario"])
        assert "with elements" not in plain.attrs["hcss_certificate_strata"]


def test_pixels_with_elements_are_not_certified_and_the_rest_passes(whole):
    with open_cube(whole) as cube:
        assert cube.attrs["hcss_certificate"].startswith("computed as specified")
        assert "pixels with elements" in cube.attrs["hcss_certificate"]
        assert {"elements[0]", "elements[1]"} <= set(json.loads(cube.attrs["hcss_providers"]))
        assert any(name.endswith("tracks.csv") for name in json.loads(cube.attrs["hcss_files_sha256"]))


def test_verification_reproduces_elements(whole):
    assert verify_cube(whole).verdict is Verdict.IDENTICAL


@pytest.mark.parametrize(
    ("parameters", "field", "message"),
    [
        ({}, "elements[0].parameters", "no source; allowed: tracks, file or both"),
        ({"tracks": [{"area": 2.0}]}, "elements[0].parameters.tracks[0]", "or temperature with area (a body)"),
        ({"tracks": [{"intensity": {"mwir": 1.0}}]}, "elements[0].parameters.tracks[0].intensity", "'lwir' is missing"),
        (
            {"tracks": [{"intensity": 1.0}, {"intensity": {"mwir": 1.0, "lwir": 1.0, "mwri": 1.0}}]},
            "elements[0].parameters.tracks[1].intensity",
            "'mwri' is no band: allowed: lwir, mwir; closest is 'mwir'",
        ),
        ({"file": "far.csv"}, "elements[0].parameters.file", "60 degrees or more from the image centre"),
        ({"file": "none.csv"}, "elements[0].parameters.file", "no file 'none.csv'"),
        (
            {"file": "bad.csv"},
            "elements[0].parameters.file",
            "column 'altitude' is missing; allowed: source, time, alt",
        ),
    ],
)
def test_wrong_parameters_name_field_and_what_is_allowed(folder, parameters, field, message):
    (folder / "far.csv").write_text("source, time, latitude, longitude, altitude, intensity\n1, 0, -40, 150, 0, 1\n")
    (folder / "bad.csv").write_text("source, time, x, y, intensity\n1, 0, 0, 0, 1\n")
    with pytest.raises(ScenarioError) as error:
        make_plan(Scenario.from_toml(SCENE, {**CHEAP, "elements": [{"parameters": parameters}]}, base=folder))
    assert [(each.field, message in each.message) for each in error.value.problems] == [(field, True)]


def test_variables_of_elements_need_elements(folder):
    with pytest.raises(ScenarioError, match=r"output\.variables.*allowed: .*\[\[elements\]\]"):
        Scenario.from_toml(SCENE, {"elements": []}, base=folder)
