"""hcss import and hcss clouds: an image becomes an entry, and a scene made of its clouds."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from cheap import CHEAP, CHEAP_OPTIONS
from command import hcss
from hcss_evaluate.database.samples import Sample
from PIL import Image
from sample_data import sample_file

from hcss_twin import Scenario, open_cube, simulate
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import CatalogError, ScenarioError
from hcss_twin.models.clouds.database import CloudEntry
from hcss_twin.plan.make_plan import make_plan


@pytest.fixture
def working_folder(tmp_path, monkeypatch):
    """A folder with the picture of a sea and clouds, in which the commands run."""
    monkeypatch.chdir(tmp_path)
    rows, columns = np.indices((120, 150))
    picture = 30.0 + np.random.default_rng(0).normal(0, 4, rows.shape)
    for row, column, radius in ((20, 30, 9), (60, 90, 15), (95, 40, 12), (30, 120, 6), (100, 120, 0.8)):
        picture += 160 * np.exp(-((((rows - row) ** 2 + (columns - column) ** 2) / radius**2) ** 2))
    Image.fromarray(picture.clip(0, 255).astype(np.uint8)).save("sea.png")
    return tmp_path


def test_import_writes_an_entry_and_a_picture_and_says_what_it_found(working_folder):
    done = hcss("import", "sea.png", "--pixel-size", "0.5 km", "--licence", "CC0", "--source", "drawn", "--min-area", 9)
    assert done.exit_code == 0, done.output
    assert "4 clouds of 9 pixels or more" in done.output
    assert "Cleaning of the mask changes the coverage from 0.0834 to " in done.output
    assert "pixels of 500 m (from the user)" in done.output
    assert "drawn; CC0" in done.output
    assert sorted(path.name for path in (working_folder / "clouds").iterdir()) == ["sea.nc", "sea.png"]
    with Image.open("clouds/sea.png") as picture:
        assert picture.size[0] > 1000
        # The outline is red, which grey pictures are not.
        colours = np.asarray(picture.convert("RGB")).astype(int)
        assert np.count_nonzero(colours[..., 0] - colours[..., 2] > 150) > 500


def test_the_answer_in_json_is_what_the_entry_says(working_folder):
    answer = json.loads(hcss("import", "sea.png", "--pixel-size", "500", "--name", "a", "--json").output)
    entry = CloudEntry.read(Path(answer["entry"]))
    assert answer["clouds"] == 5
    assert answer["coverage"] == entry.mask.mean()
    assert answer["licence"] == "not stated"
    listed = json.loads(hcss("clouds", "list", "--json").output)
    assert listed[0]["name"] == "a"
    assert listed[0]["source_sha256"] == answer["source_sha256"]
    assert (listed[0]["rows"], listed[0]["columns"]) == (120, 150)


def test_types_are_listed_with_their_optical_thickness_beside_what_is_published():
    listed = {row["name"]: row for row in json.loads(hcss("clouds", "types", "--json").output)}
    assert set(listed) == set(Catalog().names("cloud_types", ".toml"))
    cumulus = listed["cumulus"]
    assert cumulus["published"][0] <= cumulus[cumulus["of"]] <= cumulus["published"][1]
    text = hcss("clouds", "types").output
    assert all(name in text for name in listed)
    assert cumulus["source"] in text


def test_entries_are_listed_and_drawn_again(working_folder):
    assert "no entries in empty" in hcss("clouds", "list", "--from", "empty").output
    hcss("import", "sea.png", "--pixel-size", "500", "--to", "mine")
    (working_folder / "mine" / "broken.nc").write_bytes(b"no")
    listed = hcss("clouds", "list", "--from", "mine").output
    assert "sea " in listed
    assert "broken  unusable: " in listed
    (working_folder / "mine" / "sea.png").unlink()
    done = hcss("clouds", "preview", "sea", "--from", "mine")
    assert done.exit_code == 0
    assert (working_folder / "mine" / "sea.png").is_file()
    hcss("clouds", "preview", "sea", "--from", "mine", "-o", "other.png")
    assert (working_folder / "other.png").read_bytes() == (working_folder / "mine" / "sea.png").read_bytes()


def test_shipped_entries_are_listed_after_ones_own_and_drawn_here(working_folder):
    hcss("import", "sea.png", "--pixel-size", "500", "--name", "a")
    listed = json.loads(hcss("clouds", "--json").output)
    assert [entry["name"] for entry in listed[:2]] == ["a", "made-cirrus"]
    coverages = {entry["name"]: entry["coverage"] for entry in listed[1:]}
    assert coverages["made-scene-30"] == pytest.approx(0.30, abs=1e-5)
    assert coverages["made-scene-47"] == pytest.approx(0.47, abs=1e-5)
    assert {entry["licence"] for entry in listed[1:]} == {"BSD-3-Clause"}
    assert hcss("clouds", "preview", "made-cumulus").exit_code == 0
    assert (working_folder / "made-cumulus.png").is_file()


def test_a_scene_has_the_clouds_of_a_shipped_entry_wherever_it_is(working_folder):
    settings = {
        "clouds.generator": "imagery",
        "clouds.parameters": {"entry": "made-scene-47"},
        "image": {"rows": 400, "columns": 400, "pixel_size": 20.0},
        "motion": {"platform_speed": 0.0, "wind_speed": 0.0},
        "output.variables": ["cloud_mask"],
        "frames.count": 1,
    }
    cube = simulate(Scenario.load("simulated", settings | {"output.certificate": 0}))
    assert float((cube.cloud_mask[0] > 0).mean()) == pytest.approx(0.47, abs=1e-5)


def test_an_existing_entry_is_kept_unless_forced(working_folder):
    arguments = ("import", "sea.png", "--pixel-size", "500")
    hcss(*arguments)
    before = (working_folder / "clouds" / "sea.nc").read_bytes()
    refused = hcss(*arguments)
    assert refused.exit_code == 1
    assert "--force" in refused.output
    assert (working_folder / "clouds" / "sea.nc").read_bytes() == before
    assert hcss(*arguments, "--force", "--min-area", "300").exit_code == 0
    assert CloudEntry.read(working_folder / "clouds" / "sea.nc").facts.clouds == 2


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--method", "coverage"], "needs --coverage"),
        (["--coverage", "0.3"], "--coverage: allowed with"),
        (["--window", "9"], "--window: allowed with"),
        (["--close", "4"], "closest is 5"),
        (["--pixel-size", "2 parsec"], "unit of length"),
        (["--pixel-size", "-3"], "greater than 0"),
        (["--name", "a/b"], "closest is 'a-b'"),
        (["--method", "otzu"], "otzu"),
    ],
)
def test_a_wrong_command_line_exits_2_and_leaves_nothing(working_folder, arguments, message):
    done = hcss("import", "sea.png", *(() if "--pixel-size" in arguments else ("--pixel-size", "500")), *arguments)
    assert done.exit_code == 2
    assert message in done.output
    assert not (working_folder / "clouds").exists()


def test_an_image_that_cannot_be_used_leaves_nothing(working_folder):
    with pytest.raises(CatalogError, match="--pixel-size"):
        hcss("import", "sea.png")
    (working_folder / "text.png").write_text("no image")
    with pytest.raises(CatalogError, match="not a readable image"):
        hcss("import", "text.png", "--pixel-size", "500")
    assert not (working_folder / "clouds").exists()


SCENE = """
time = 2024-04-20T12:30:00+10:00
place = {latitude = 35.0, longitude = 150.0}
image = {rows = 60, columns = 80, pixel_size = 500.0}
frames = {count = 3, interval = 1.0}
motion = {platform_speed = 2000.0, wind_speed = 0.0}
bands = ["lwir-10.8"]
output.variables = ["radiance", "cloud_thickness"]
[clouds]
type = "cumulus"
coverage = 0.4
coverage_mode = "field"
generator = "imagery"
"""


def _scenario(working_folder, *parameters):
    (working_folder / "scene.toml").write_text(SCENE + f"parameters = {{{', '.join(parameters)}}}")


def test_scattered_clouds_of_an_entry_become_a_push_broom_scene(working_folder):
    hcss("import", "sea.png", "--pixel-size", "500")
    _scenario(working_folder, 'entry = "sea"', 'placement = "single-clouds"')
    done = hcss("run", "scene.toml", *CHEAP_OPTIONS)
    assert done.exit_code == 0, done.output
    with open_cube("scene.nc") as cube:
        thickness = cube.cloud_thickness.values
        assert 0.05 < np.mean(thickness > 0) < 0.9
        # 2 km a second: 4 pixels.
        np.testing.assert_array_equal(thickness[1, :, :-4], thickness[0, :, 4:])
        assert any("sea.nc" in str(value) for value in cube.attrs.values())
    plan = make_plan(Scenario.load("scene.toml", CHEAP))
    assert any("in the mean over the unbounded sky" in note for note in plan.assembly.notes())


def test_an_entry_that_is_not_there_is_named_with_the_closest(working_folder):
    hcss("import", "sea.png", "--pixel-size", "500")
    _scenario(working_folder, 'entry = "see"')
    with pytest.raises(ScenarioError, match=r"clouds\.parameters\.entry: 'see' is neither .*closest is 'sea'"):
        make_plan(Scenario.load("scene.toml", CHEAP))


@pytest.mark.parametrize(
    ("pattern", "options", "coverage", "clouds"),
    [
        ("OR_ABI-L2-CMIPM2-M3C03*.nc", (), (0.3, 0.5), (100, 400)),
        ("OR_ABI-L2-CMIPM2-M3C01*.nc", (), (0.3, 0.5), (100, 400)),
        ("OR_ABI-L1b-RadC-M3C08*.nc", (), (0.2, 0.6), (200, 900)),
        ("Miriam*.jpg", ("--pixel-size", "2 km"), (0.4, 0.8), (100, 900)),
        ("*Cloud_Top_Height.nc", ("--method", "valid"), (0.4, 0.9), (20, 200)),
    ],
)
def test_real_images_become_plausible_entries(working_folder, pattern, options, coverage, clouds):
    image = sample_file(f"images/{pattern}")
    cleaning = ("--close", 3, "--fill-holes", "--min-area", 9)
    answer = json.loads(hcss("import", image, "--name", "real", "--json", *cleaning, *options).output)
    assert coverage[0] < answer["coverage"] < coverage[1]
    assert clouds[0] <= answer["clouds"] <= clouds[1]
    assert 2.0 < answer["fractal_dimension"] < 3.0


def test_samples_are_listed_with_their_licences_and_one_that_is_not_installed_says_what_to_install(
    working_folder, monkeypatch
):
    monkeypatch.setattr("hcss_evaluate.database.samples.find_spec", lambda package: None)
    listed = json.loads(hcss("clouds", "import", "--sample", "--json").output)
    assert {entry["installed"] for entry in listed} == {False}
    assert all(entry["licence"] and entry["source"] for entry in listed)
    assert hcss("clouds", "import", "--sample").output.count("pip install 'hcss-twin[samples]'") == len(listed)
    with pytest.raises(CatalogError, match=r"not installed: pip install 'hcss-twin\[samples\]'"):
        hcss("clouds", "import", "--sample", listed[0]["name"])
    with pytest.raises(CatalogError, match="closest is 'modis-cumulus'"):
        hcss("clouds", "import", "--sample", "modis-cumuls")
    with pytest.raises(CatalogError, match="no sample ''; allowed: modis-cumulus"):
        hcss("clouds", "import", "--sample", "")
    for arguments in ((), ("sea.png", "--sample", "modis-cumulus")):
        assert hcss("clouds", "import", *arguments).exit_code == 2
    assert not (working_folder / "clouds").exists()


@pytest.mark.parametrize(("options", "who"), [((), "sample"), (("--pixel-size", "1 km"), "user")])
def test_an_entry_says_who_stated_its_pixel_size(working_folder, monkeypatch, options, who):
    digest = hashlib.sha256((working_folder / "sea.png").read_bytes()).hexdigest()
    drawn = Sample("a sea", "drawn", "sea.png", digest, [0, 0, 120, 150], "grey", "today", "drawn", "CC0", 2000.0)
    monkeypatch.setattr("hcss_evaluate.database.samples.samples", lambda catalog: {"sea": drawn})
    package = SimpleNamespace(submodule_search_locations=[str(working_folder)])
    monkeypatch.setattr("hcss_evaluate.database.samples.find_spec", lambda name: package)
    assert f"(from the {who})" in hcss("clouds", "import", "--sample", "sea", *options).output
    assert CloudEntry.read(working_folder / "clouds" / "sea.nc").facts.pixel_size_from == who


def test_a_part_of_an_image_has_the_clouds_of_that_part_and_is_named(working_folder):
    arguments = ("import", "sea.png", "--pixel-size", "500", "--json")
    answer = json.loads(hcss(*arguments, "--crop", 40, 60, 50, 60).output)
    assert (answer["clouds"], answer["source_file"]) == (1, "sea.png, rows 40 to 89 and columns 60 to 119")
    assert CloudEntry.read(Path(answer["entry"])).grey.shape == (50, 60)
    with pytest.raises(CatalogError, match="within the 120 rows and 150 columns"):
        hcss(*arguments, "--name", "b", "--crop", 100, 0, 50, 60)
