"""What an export refuses, what it says, and that nothing half made is left."""

import json
import shutil

import netCDF4
import numpy as np
import pytest
import xarray as xr
from click.testing import CliRunner
from example_cube import example_frame, example_header
from hcss_export import export_cube
from hcss_export.projection import projection_of_mapping

from hcss_twin.cli.main import cli
from hcss_twin.core.errors import CubeError
from hcss_twin.cube.writer import CubeWriter

START = np.datetime64("2024-06-01T12:00:00.1")
FORMATS = ["fits", "envi", "geotiff", "png"]


def write(path, **changes):
    header = example_header(**changes)
    with CubeWriter(path, header) as writer:
        for index in range(header.frames):
            writer.write_frame(index, example_frame(header, index))
    return path


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    return write(tmp_path_factory.mktemp("cube") / "c.nc")


@pytest.fixture
def cube(made, tmp_path):
    return shutil.copy(made, tmp_path / "c.nc")


def run(*arguments):
    return CliRunner().invoke(cli, ["export", *map(str, arguments)])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"to": "fit"}, r"format 'fit': allowed: envi, fits, geotiff, png; closest is 'fits'"),
        ({"variable": "radiane"}, r"variable 'radiane': .*closest is 'radiance'"),
        ({"variable": "latitude"}, "variable 'latitude': the cube holds no such image"),
        ({"bands": ["MWI"]}, "band 'MWI': .*allowed: MWIR, SWIR; closest is 'MWIR'"),
        ({"bands": ["MWIR", "MWIR"]}, "band 'MWIR': requested more than once"),
        ({"bands": ["MWIR"], "variable": "cloud_mask"}, "cloud_mask is the same for all bands"),
        ({"frames": [3]}, "frame 3: the cube has 0 to 2; closest is 2"),
        ({"frames": [-1]}, "frame -1: the cube has 0 to 2; closest is 0"),
        ({"frames": [1, 1]}, "frame 1: requested more than once"),
        ({"output": "a.tif"}, r"a.tif: names of fits end in .fits or .fit or .fts"),
        ({"output": "nowhere/a.fits"}, "there is no folder .*nowhere"),
        ({"limits": (0.0, 1.0)}, "limits: fits stores unscaled values; allowed: with png only"),
        ({"to": "png", "limits": (1.0, 0.0)}, "limits: 1 to 0; two finite, increasing values"),
        ({"to": "png", "limits": (0.0, 0.5)}, "radiance, SWIR frame 0 .*the limits 0 to 0.5 must include all"),
    ],
)
def test_what_cannot_be_exported_is_named_and_leaves_nothing(cube, options, message):
    with pytest.raises(CubeError, match=message):
        export_cube(cube, **{"to": "fits", **options})
    assert [path.name for path in cube.parent.iterdir()] == ["c.nc"]


@pytest.mark.parametrize("to", FORMATS)
def test_existing_files_are_kept_unless_forced(cube, to):
    export_cube(cube, to)
    before = {path.name: path.read_bytes() for path in cube.parent.iterdir()}
    with pytest.raises(CubeError, match=r"exists.*; give another name with -o, or --force"):
        export_cube(cube, to)
    export_cube(cube, to, replace=True)
    assert {path.name: path.read_bytes() for path in cube.parent.iterdir()} == before


@pytest.mark.parametrize("to", FORMATS)
def test_a_cube_that_breaks_off_leaves_no_file(cube, to, monkeypatch):
    """The second frame cannot be read: nothing of the first is left, and older files are whole."""
    old = export_cube(cube, to)
    before = {path: path.read_bytes() for path in old.files}
    original = xr.DataArray.to_numpy

    def to_numpy(self):
        if self.name == "radiance" and self["time"].to_numpy() > START:
            raise OSError(5, "disk on fire")
        return original(self)

    monkeypatch.setattr(xr.DataArray, "to_numpy", to_numpy)
    with pytest.raises(CubeError, match=r"cannot read radiance of frame 1: .*disk on fire"):
        export_cube(cube, to, replace=True)
    assert {path: path.read_bytes() for path in before} == before
    assert {path.name for path in cube.parent.iterdir()} == {"c.nc", *(path.name for path in before)}


@pytest.mark.parametrize("to", FORMATS)
def test_a_disk_that_refuses_is_told_with_the_file(cube, to, monkeypatch):
    def fsync(handle):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("hcss_twin.core.files.os.fsync", fsync)
    with pytest.raises(CubeError, match=r"cannot write .*c_radiance.*: No space left on device"):
        export_cube(cube, to)
    assert [path.name for path in cube.parent.iterdir()] == ["c.nc"]


def test_every_format_has_names_of_its_own(cube):
    files = [path for to in FORMATS for path in export_cube(cube, to).files]
    assert len(set(files)) == len(files)


def test_a_missing_rasterio_is_told_with_the_command(cube, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "rasterio", None)
    with pytest.raises(CubeError, match=r"rasterio; .*pip install './plugins/hcss-export\[geotiff\]'"):
        export_cube(cube, "geotiff")


def test_a_missing_astropy_is_told_with_the_command(cube, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "astropy.io", None)
    with pytest.raises(CubeError, match=r"astropy; .*pip install './plugins/hcss-export\[fits\]'"):
        export_cube(cube, "fits")
    assert [path.name for path in cube.parent.iterdir()] == ["c.nc"]


def test_the_command_tells_files_and_what_is_missing(cube):
    done = run(cube, "--to", "png", "--variable", "cloud_top_altitude")
    assert done.exit_code == 0, done.output
    lines = done.output.splitlines()
    assert lines[0] == str(cube.parent / "c_cloud_top_altitude_000.png")
    assert lines[-2] == "  cloud_top_altitude: 3 x 1 x 5 x 7 values (frames, bands or layers, rows, columns)"
    with netCDF4.Dataset(cube) as file:
        missing = np.ma.getmaskarray(file["cloud_top_altitude"][:]).sum()
    assert lines[-1] == f"  {missing} of them are missing: sample 0"


@pytest.mark.parametrize(
    ("to", "closest"), [("tiff", "geotiff"), ("tif", "geotiff"), (".img", "envi"), ("FIT", "fits"), ("pgn", "png")]
)
def test_the_command_names_the_format_that_is_meant(cube, to, closest):
    done = run(cube, "--to", to)
    assert done.exit_code == 2
    assert f"format '{to}': allowed: envi, fits, geotiff, png; closest is '{closest}'" in " ".join(done.output.split())


def test_the_answer_in_json_names_the_files(cube):
    done = run(cube, "--to", "fits", "--band", "MWIR", "--frame", 2, "--frame", 0, "--json")
    answer = json.loads(done.stdout)
    assert answer["files"] == [str(cube.parent / "c_radiance.fits")]
    assert (answer["frames"], answer["planes"], answer["missing"]) == (2, 1, 0)


def test_the_only_image_of_a_cube_need_not_be_named(tmp_path):
    spec = tuple(variable for variable in example_header().variables if variable.name == "cloud_thickness")
    cube = write(tmp_path / "t.nc", variables=spec)
    assert export_cube(cube, "fits").files[0].name == "t_cloud_thickness.fits"


def test_band_names_that_no_file_can_have_get_numbers(tmp_path):
    bands = example_header().bands
    named = (type(bands[0])("3/4", 3.0, 4.0, 3.5), type(bands[0])("3:4", 3.0, 5.0, 4.0))
    cube = write(tmp_path / "c.nc", bands=named)
    names = [path.name for path in export_cube(cube, "png", frames=[0]).files]
    assert names == ["c_radiance_3-4-0.png", "c_radiance_3-4-1.png", "c_radiance.png.json"]
    export_cube(cube, "envi")
    export_cube(cube, "geotiff")


@pytest.mark.parametrize("to", FORMATS)
@pytest.mark.parametrize("size", [{"rows": 1}, {"columns": 1}, {"rows": 1, "columns": 1}])
def test_a_single_row_or_pixel_is_exported(tmp_path, to, size):
    cube = write(tmp_path / "c.nc", **size)
    assert export_cube(cube, to).files[0].is_file()


def test_text_of_any_language_is_carried(tmp_path):
    title = 'Wolken über See — 海, {braces}, <tags> & "quotes"\nsecond line'
    attributes = {**example_header().attributes, "title": title}
    cube = write(tmp_path / "c.nc", attributes=attributes)
    for to in FORMATS:
        for path in export_cube(cube, to, frames=[0]).files:
            assert path.stat().st_size > 0


def test_a_cube_that_counts_time_otherwise_is_refused(cube):
    with netCDF4.Dataset(cube, "a") as file:
        file["time"].units = "hours since 2024-06-01 12:00:00"
    with pytest.raises(CubeError, match="time is in 'hours since"):
        export_cube(cube, "fits")


@pytest.mark.parametrize(
    ("figure", "expected"),
    [
        ({"earth_radius": 6371000.0}, (6371000.0, 0.0)),
        ({"semi_major_axis": 6378137.0, "inverse_flattening": 298.257223563}, (6378137.0, 298.257223563)),
    ],
)
def test_the_figure_of_the_earth_is_that_of_the_grid_mapping(figure, expected):
    projection = projection_of_mapping(
        {
            "grid_mapping_name": "azimuthal_equidistant",
            "latitude_of_projection_origin": 10.0,
            "longitude_of_projection_origin": 20.0,
            **figure,
        }
    )
    assert (projection.latitude, projection.longitude) == (10.0, 20.0)
    assert (projection.semi_major_m, projection.inverse_flattening) == expected
    assert projection.is_wgs84 == (expected[1] > 0.0)


def test_another_projection_is_refused():
    with pytest.raises(CubeError, match="grid_mapping_name: 'mercator'"):
        projection_of_mapping({"grid_mapping_name": "mercator"})
    with pytest.raises(CubeError, match="the grid mapping lacks 'semi_major_axis'"):
        projection_of_mapping(
            {
                "grid_mapping_name": "azimuthal_equidistant",
                "latitude_of_projection_origin": 0.0,
                "longitude_of_projection_origin": 0.0,
            }
        )
