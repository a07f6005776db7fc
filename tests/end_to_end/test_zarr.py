"""A Zarr store holds what the NetCDF file holds, and is whole or not there."""

import json
import shutil

import numpy as np
import pytest
import xarray as xr
from cheap import CHEAP
from click.testing import CliRunner
from example_cube import example_frame, example_header

from hcss_twin import CubeError, Scenario, make_plan, open_cube
from hcss_twin.cli.main import cli
from hcss_twin.cube.writer import CubeWriter
from hcss_twin.cube.zarr_writer import ZarrWriter
from hcss_twin.engine import parts as tiles_module
from hcss_twin.engine.simulate import run
from hcss_twin.engine.verification import verify_cube

zarr = pytest.importorskip("zarr", reason="the extra 'zarr'")

SMALL = {
    **CHEAP,
    "image.rows": 30,
    "image.columns": 40,
    "frames.count": 2,
    "bands": ["mwir-3.7", "lwir-10.8"],
    "output.variables": ["all"],
    "output.quantization": 1e-4,
}


def planned(**overrides):
    return make_plan(Scenario.load("stratus", {**SMALL, **overrides}))


@pytest.fixture(autouse=True)
def patch():
    """The date is fixed; no analysis of a scene depends on what is patched here, so that they are kept."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SOURCE_DATE_EPOCH", "1700000000")
        yield patch


@pytest.mark.parametrize(("compression", "tiled"), [(0, False), (4, True)])
def test_a_store_equals_the_file(tmp_path, patch, compression, tiled):
    if tiled:
        patch.setattr(tiles_module, "LARGEST_FRAME_BYTES", 0)
        patch.setattr(tiles_module, "TILE_PIXELS", 300)
    plan = planned(**{"output.compression": compression})
    file, store = run(plan, tmp_path / "cube.nc"), run(plan, tmp_path / "cube.zarr")
    with open_cube(file) as one, open_cube(store) as other:
        xr.testing.assert_identical(one.load(), other.load())
        assert {str(each.dtype) for each in one.variables.values()} >= {"float32", "uint8"}
        for name in one.variables:
            # Text is of two kinds in numpy.
            assert one[name].dtype == other[name].dtype or one[name].dtype.kind == "U"
    with xr.open_dataset(file) as one, xr.open_zarr(store, chunks=None) as other:
        xr.testing.assert_equal(one, other)
    height, width = tiles_module.tile_shape(plan) or (30, 40)
    array = zarr.open_group(str(store), mode="r")["radiance"]
    assert array.chunks == (1, 1, height, width)
    assert bool(array.compressors) == (compression > 0)
    assert sorted(each.name for each in tmp_path.iterdir()) == ["cube.nc", "cube.zarr"]


def test_every_variable_of_every_kind_comes_back(tmp_path):
    header = example_header()
    for writer, name in ((CubeWriter, "a.nc"), (ZarrWriter, "a.zarr")):
        with writer(tmp_path / name, header) as cube:
            for index in (2, 0, 1):
                cube.write_frame(index, example_frame(header, index))
            cube.set_attributes({"late": 1.5})
    with open_cube(tmp_path / "a.nc") as one, open_cube(tmp_path / "a.zarr") as other:
        xr.testing.assert_identical(one.load(), other.load())
        assert np.isnan(one.cloud_top_altitude).any()


def _write_all_of_one_frame(cube, header):
    """In parts, with some that are refused in between."""
    frame = example_frame(header, 0)

    def part(rows, columns):
        return {name: values[..., rows, columns] for name, values in frame.items()}

    first, second = (slice(0, 5), slice(0, 4)), (slice(0, 5), slice(4, 7))
    cube.write_tile(0, first, part(*first))
    with pytest.raises(CubeError, match="frame 0: already written in part"):
        cube.write_tile(0, (slice(4, 5), slice(3, 7)), part(slice(4, 5), slice(3, 7)))
    with pytest.raises(CubeError, match=r"frame 1, columns slice\(4, 8, None\): slices inside 0 to 7"):
        cube.write_tile(1, (slice(0, 5), slice(4, 8)), part(*second))
    with pytest.raises(CubeError, match=r"shape \(2, 5, 7\); \(2, 5, 3\) is needed"):
        cube.write_tile(1, second, frame)
    cube.write_tile(1, second, part(*second))
    cube.write_tile(1, first, part(*first))
    with pytest.raises(CubeError, match="frame 1: already written"):
        cube.write_frame(1, frame)


@pytest.mark.parametrize(("writer", "suffix"), [(CubeWriter, "nc"), (ZarrWriter, "zarr")])
def test_parts_are_written_once_each_and_all_of_them(tmp_path, writer, suffix):
    header = example_header()
    cube = writer(tmp_path / f"cube.{suffix}", header)
    with pytest.raises(CubeError, match=r"2 of 3 frames were not written: 0, 2"), cube:
        _write_all_of_one_frame(cube, header)
    assert list(tmp_path.iterdir()) == []


def _fail_halfway(cube, header):
    cube.write_frame(0, example_frame(header, 1))
    raise ZeroDivisionError


def test_an_unfinished_store_leaves_the_old_one(tmp_path):
    header, path = example_header(), tmp_path / "cube.zarr"
    with ZarrWriter(path, header) as cube:
        for index in range(3):
            cube.write_frame(index, example_frame(header, index))
    before = open_cube(path).load()
    with pytest.raises(ZeroDivisionError), ZarrWriter(path, header) as cube:
        _fail_halfway(cube, header)
    xr.testing.assert_identical(open_cube(path).load(), before)
    with ZarrWriter(path, header) as cube:
        for index in range(3):
            cube.write_frame(index, example_frame(header, index + 7))
    assert not open_cube(path).radiance.equals(before.radiance)
    assert [each.name for each in tmp_path.iterdir()] == ["cube.zarr"]


def test_what_is_no_store_is_not_replaced(tmp_path):
    header = example_header()
    (tmp_path / "file.zarr").write_text("mine")
    (tmp_path / "folder.zarr").mkdir()
    (tmp_path / "folder.zarr" / "thesis.txt").write_text("mine")
    (tmp_path / "empty.zarr").mkdir()
    for name, why in (
        ("file", "it is a file"),
        ("folder", "a folder that is not a Zarr store"),
        ("empty", "a folder that is not a Zarr store"),
        ("no/such", "no folder"),
    ):
        with pytest.raises(CubeError, match=why), ZarrWriter(tmp_path / f"{name}.zarr", header):
            pass
    assert (tmp_path / "folder.zarr" / "thesis.txt").read_text() == "mine"
    assert sorted(each.name for each in tmp_path.iterdir()) == ["empty.zarr", "file.zarr", "folder.zarr"]
    assert not list((tmp_path / "empty.zarr").iterdir())
    with pytest.raises(CubeError, match="cannot read"):
        open_cube(tmp_path / "folder.zarr")
    with pytest.raises(CubeError, match="no such file"):
        open_cube(tmp_path / "nothing.zarr")


def test_empty_folders_of_the_user_in_and_beside_a_replaced_store_stay(tmp_path):
    header, path = example_header(), tmp_path / "cube.zarr"
    own = "cube.zarr/plans", "cube.zarr/radiance/mine", "cube.zarr/a/b", ".cube.zarr.partial", "cube.zarr.old", "cube"
    for number in range(2):
        with ZarrWriter(path, header) as cube:
            for index in range(3):
                cube.write_frame(index, example_frame(header, index))
        for name in own if number == 0 else ():
            (tmp_path / name).mkdir(parents=True)
    assert [name for name in own if not (tmp_path / name).is_dir()] == []
    assert sorted(each.name for each in tmp_path.iterdir()) == [
        ".cube.zarr.partial",
        "cube",
        "cube.zarr",
        "cube.zarr.old",
    ]
    open_cube(path).load()


def test_without_the_package_a_store_says_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "zarr", None)
    with (
        pytest.raises(CubeError, match=r"pip install 'hcss-twin\[zarr\]', or choose a name that ends in \.nc"),
        ZarrWriter(tmp_path / "a.zarr", example_header()),
    ):
        pass
    assert list(tmp_path.iterdir()) == []


def test_commands_take_stores(tmp_path):
    store = str(tmp_path / "cube.zarr")
    words = [
        word
        for key, value in {**CHEAP, "image.rows": 20, "image.columns": 30, "output.certificate": 4}.items()
        for word in ("--set", f"{key}={value}")
    ]
    words += ["--set", "bands=['lwir-10.8']", "--set", "frames.count=2"]
    runner = CliRunner()
    done = runner.invoke(cli, ["run", "stratus", *words, "-o", store, "--json"])
    assert done.exit_code == 0, done.output
    assert json.loads(done.stdout)["bytes"] > 2 * 20 * 30 * 5
    assert runner.invoke(cli, ["run", "stratus", *words, "-o", store]).exit_code != 0
    assert runner.invoke(cli, ["run", "stratus", *words, "-o", store, "--force"]).exit_code == 0
    shown = runner.invoke(cli, ["preview", store, "--no-animation"])
    assert shown.exit_code == 0, shown.output
    assert (tmp_path / "cube_lwir-10-8.png").exists() or list(tmp_path.glob("*.png"))
    assert str(verify_cube(store).verdict) == "identical"
    zarr.open_group(store, mode="r+")["radiance"][1, 0, 3, 4] = 1.0
    found = runner.invoke(cli, ["verify", store])
    assert found.exit_code == 1
    assert "row 3, column 4" in found.output
    shutil.rmtree(store)
