"""``hcss volume`` draws the cloud of a cube in three dimensions and writes its occupancy."""

import json
import shutil
import subprocess
import sys

import netCDF4
import numpy as np
import pytest
from cheap import CHEAP, NARROW
from click.testing import CliRunner
from PIL import Image

from hcss_twin import Scenario, simulate
from hcss_twin.cli.main import cli
from hcss_twin.core.errors import CubeError
from hcss_twin.cube.reader import open_cube
from hcss_twin.reports.cloud_columns import read_columns
from hcss_twin.reports.cloud_volume import draw_volume

SMALL = {"image.rows": 24, "image.columns": 32, "frames.count": 2, "bands": NARROW[1:], **CHEAP}


@pytest.fixture(scope="module")
def cube(tmp_path_factory):
    path = tmp_path_factory.mktemp("cube") / "small.nc"
    simulate(Scenario.load("stratus", {**SMALL, "output.variables": ["truth"]}), path).close()
    return path


def run(*arguments):
    return CliRunner().invoke(cli, ["volume", *map(str, arguments)])


def test_the_volume_of_the_file_is_the_thickness_of_the_cube(cube, tmp_path):
    picture, voxels = tmp_path / "v.png", tmp_path / "v.nc"
    done = run(cube, "--frame", 1, "-o", picture, "--occupancy", voxels, "--step-m", 70)
    assert done.exit_code == 0, done.output
    assert done.output.splitlines()[0] == str(picture)
    with Image.open(picture) as image:
        assert image.size == (1320, 1100)
    with netCDF4.Dataset(voxels) as file, open_cube(cube) as dataset:
        heights = np.diff(file["altitude_bounds"][:], axis=1)[:, :, None]
        volume = np.sum(file["cloud_occupancy"][:] * heights, axis=0, dtype=np.float64)
        np.testing.assert_allclose(volume, dataset["cloud_thickness"][1], atol=2e-3)
        np.testing.assert_array_equal(file["x"][:], dataset["x"])
        np.testing.assert_array_equal(file["altitude"][:], file["altitude_bounds"][:].mean(axis=1))
        seconds = float(file["time"][...])
        assert seconds == dataset["time"].to_numpy()[1].astype("datetime64[ms]").astype(int) / 1e3
    assert sorted(path.name for path in tmp_path.iterdir()) == ["v.nc", "v.png"]


def test_the_occupancy_file_complies_with_cf(cube, tmp_path):
    pytest.importorskip("compliance_checker")
    assert run(cube, "-o", tmp_path / "v.png", "--occupancy", tmp_path / "v.nc").exit_code == 0
    code = (
        "from compliance_checker.runner import CheckSuite, ComplianceChecker\n"
        "CheckSuite.load_all_available_checkers()\n"
        "ComplianceChecker.run_checker('v.nc', ['cf:1.11'], 0, 'strict', output_filename='r.json', "
        "output_format='json')\n"
    )
    subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, check=False, timeout=120)
    report = json.loads((tmp_path / "r.json").read_text())["cf:1.11"]
    findings = [
        message
        for priority in ("high_priorities", "medium_priorities", "low_priorities")
        for check in report[priority]
        for message in check["msgs"]
    ]
    assert findings == []


def test_the_answer_in_json_names_the_files(cube, tmp_path):
    files = {"picture": str(tmp_path / "v.png"), "occupancy": str(tmp_path / "v.nc")}
    done = run(cube, "-o", files["picture"], "--occupancy", files["occupancy"], "--step-m", 2000, "--json")
    assert json.loads(done.stdout) == {**files, "voxels": [1, 24, 32]}


def test_the_cloudy_part_of_averaged_pixels_fills_their_voxels(cube, tmp_path):
    """Thickness is then a mean over the pixel, the top one over its cloudy part."""
    path = tmp_path / "c.nc"
    shutil.copy(cube, path)
    with netCDF4.Dataset(path, "a") as file:
        before = file["cloud_thickness"][0]
        if "cloud_fraction" not in file.variables:
            file.createVariable("cloud_fraction", "f4", ("time", "y", "x"))
        file["cloud_fraction"][:] = 0.25 * (file["cloud_thickness"][:] > 0)
        file["cloud_thickness"][:] = 0.25 * file["cloud_thickness"][:]
    columns = read_columns(path)
    np.testing.assert_allclose(np.nan_to_num(columns.thickness_m), before, atol=1e-3)
    assert run(path, "-o", tmp_path / "v.png", "--occupancy", tmp_path / "v.nc").exit_code == 0
    with netCDF4.Dataset(tmp_path / "v.nc") as file:
        shares, bounds = file["cloud_occupancy"][:], file["altitude_bounds"][:]
    assert shares.max() <= 0.25
    volume = np.sum(shares * np.diff(bounds, axis=1)[:, :, None], axis=0, dtype=np.float64)
    np.testing.assert_allclose(volume, 0.25 * before, atol=2e-3)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"clouds": {"layers": [{}, {}]}}, "the scene has 2 cloud layers; this needs a cube with one"),
        ({"image": {"samples_per_pixel": 3}}, "lacks cloud_fraction; run the scenario with"),
    ],
)
def test_columns_that_the_cube_does_not_determine_are_refused(cube, tmp_path, change, message):
    shutil.copy(cube, tmp_path / "c.nc")
    with netCDF4.Dataset(tmp_path / "c.nc", "a") as file:
        file.hcss_scenario = json.dumps(change)
        if "cloud_fraction" in file.variables:
            file.renameVariable("cloud_fraction", "other")
    with pytest.raises(CubeError, match=message):
        read_columns(tmp_path / "c.nc")


@pytest.mark.parametrize("change", ["scale_factor", "values"])
@pytest.mark.parametrize("name", ["y", "cloud_top_altitude"])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_cube_whose_coordinates_or_altitudes_are_none_is_refused(cube, tmp_path, name, change, value):
    shutil.copy(cube, tmp_path / "c.nc")
    with netCDF4.Dataset(tmp_path / "c.nc", "a") as file:
        item = file[name]
        item.set_auto_maskandscale(False)
        if change == "values":
            item[...] = np.full(item.shape, value, dtype=item.dtype)
        else:
            item.setncattr(change, value)
    with pytest.raises(CubeError, match=name if name in "xy" else "cloud"):
        read_columns(tmp_path / "c.nc")


@pytest.mark.parametrize("number", ["nan", "inf", "5e-324"])
def test_a_step_that_is_no_height_of_voxels_is_refused(cube, tmp_path, number):
    done = run(cube, "-o", tmp_path / "v.png", "--occupancy", tmp_path / "v.nc", "--step-m", number)
    assert done.exit_code != 0
    assert "step" in done.output + str(done.exception)


def test_an_existing_occupancy_file_is_kept(cube, tmp_path):
    (tmp_path / "v.nc").write_text("mine")
    done = run(cube, "-o", tmp_path / "v.png", "--occupancy", tmp_path / "v.nc")
    assert done.exit_code == 1
    assert "--force" in done.output
    assert (tmp_path / "v.nc").read_text() == "mine"
    assert not (tmp_path / "v.png").exists()


def test_an_existing_picture_is_kept_unless_forced(cube, tmp_path):
    shutil.copy(cube, tmp_path / "c.nc")
    picture = tmp_path / "c_volume.png"
    picture.write_text("mine")
    for arguments in ((tmp_path / "c.nc",), (cube, "-o", picture, "--occupancy", tmp_path / "v.nc")):
        done = run(*arguments)
        assert done.exit_code == 1
        assert f"{picture} exists; give another name with -o, or --force" in done.output
    assert picture.read_text() == "mine"
    assert not (tmp_path / "v.nc").exists()
    assert run(tmp_path / "c.nc", "--force").exit_code == 0
    with Image.open(picture) as image:
        assert image.format == "PNG"


def test_a_frame_that_is_not_there_is_named_with_the_closest(cube):
    with pytest.raises(CubeError, match="frame 7: the cube has 0 to 1; closest is 1"):
        read_columns(cube, 7)


def test_a_cube_without_truth_says_how_to_get_it(tmp_path):
    simulate(Scenario.load("stratus", SMALL), tmp_path / "c.nc").close()
    with pytest.raises(CubeError, match="lacks cloud_thickness and cloud_top_altitude; run the scenario with"):
        read_columns(tmp_path / "c.nc")


def test_a_clear_frame_has_no_volume(tmp_path):
    scenario = Scenario.load("stratus", {**SMALL, "output.variables": ["truth"], "clouds.coverage": 0.0})
    simulate(scenario, tmp_path / "c.nc").close()
    columns = read_columns(tmp_path / "c.nc")
    assert columns.is_clear
    with pytest.raises(CubeError, match="frame 0 has no cloud"):
        draw_volume(columns, tmp_path / "c.png")


def test_a_picture_that_cannot_be_written_leaves_nothing(cube, tmp_path):
    with pytest.raises(CubeError, match="cannot write"):
        draw_volume(read_columns(cube), tmp_path / "v.nothing")
    assert list(tmp_path.iterdir()) == []


class _FullOfRubbish:
    """numpy, whose new memory holds what overflows."""

    def __getattr__(self, name):
        return getattr(np, name)

    @staticmethod
    def empty(*arguments, **options):
        return np.full_like(np.empty(*arguments, **options), 1.7e308)


def test_memory_that_matplotlib_leaves_as_it_is_does_not_matter(cube, tmp_path, monkeypatch):
    draw_volume(read_columns(cube), tmp_path / "before.png")
    monkeypatch.setattr("mpl_toolkits.mplot3d.art3d.np", _FullOfRubbish())
    draw_volume(read_columns(cube), tmp_path / "after.png")
    assert (tmp_path / "after.png").read_bytes() == (tmp_path / "before.png").read_bytes()


@pytest.mark.parametrize("kind", ["cirrus", "cumulus"])
def test_high_and_deep_clouds_are_drawn_too(kind, tmp_path):
    scenario = Scenario.load(kind, {**SMALL, "output.variables": ["truth"]})
    simulate(scenario, tmp_path / "c.nc").close()
    assert run(tmp_path / "c.nc").exit_code == 0
    with Image.open(tmp_path / "c_volume.png") as image:
        shades = np.asarray(image.convert("L"))
    # Neither an empty nor a filled page.
    assert 0.05 < np.mean(shades < 200) < 0.6
