"""Programs of others read cubes: CDO, NCO, GDAL, h5netcdf, Zarr; each where it is installed."""

import shutil
import subprocess

import netCDF4
import numpy as np
import pytest
import xarray as xr
from example_cube import example_frame, example_header

from hcss_twin.cube.requested_variables import expand
from hcss_twin.cube.writer import CubeWriter


@pytest.fixture(scope="module")
def cube(tmp_path_factory):
    path = tmp_path_factory.mktemp("cube") / "cube.nc"
    header = example_header(variables=tuple(expand(["radiance", "cloud_mask"], {})))
    with CubeWriter(path, header) as writer:
        for index in range(header.frames):
            writer.write_frame(index, example_frame(header, index))
    return path


def call(*words):
    """Run a program and return what it prints."""
    if shutil.which(words[0]) is None:
        pytest.skip(f"{words[0]} is not installed")
    return subprocess.run(list(map(str, words)), capture_output=True, text=True, check=True).stdout


def radiance(path):
    with netCDF4.Dataset(path) as file:
        return np.squeeze(np.asarray(file["radiance"][:], np.float64))


def test_cdo_averages_the_radiance_of_each_band_over_time(cube, tmp_path):
    call("cdo", "-s", "timmean", "-selname,radiance", cube, tmp_path / "mean.nc")
    np.testing.assert_allclose(radiance(tmp_path / "mean.nc"), radiance(cube).mean(0), rtol=1e-6)


def test_cdo_knows_the_times_and_the_projection(cube):
    text = call("cdo", "-s", "sinfon", cube)
    with netCDF4.Dataset(cube) as file:
        assert f"{file.dimensions['time'].size} steps" in text
    assert "azimuthal_equidistant" in text


@pytest.mark.parametrize("command", [("ncwa", "-a", "time"), ("ncra",)])
def test_nco_averages_over_time(cube, tmp_path, command):
    """A cube has no record dimension, which ``ncra`` needs: ``ncks`` makes one."""
    call("ncks", "--mk_rec_dmn", "time", cube, tmp_path / "record.nc")
    call(*command, tmp_path / "record.nc", tmp_path / "mean.nc")
    np.testing.assert_allclose(radiance(tmp_path / "mean.nc"), radiance(cube).mean(0), rtol=1e-6)


def test_gdal_reads_bands_of_all_frames_northernmost_row_first(cube, tmp_path):
    call("gdal_translate", "-q", "-of", "ENVI", "-b", "2", f"NETCDF:{cube}:radiance", tmp_path / "plane.img")
    expected = radiance(cube)[0, 1]
    found = np.fromfile(tmp_path / "plane.img", np.float32).reshape(expected.shape)
    np.testing.assert_array_equal(found, expected[::-1])
    assert "Azimuthal Equidistant" in call("gdalinfo", f"NETCDF:{cube}:radiance")


def test_h5netcdf_reads_what_netcdf4_reads(cube):
    pytest.importorskip("h5netcdf")
    with xr.open_dataset(cube, engine="h5netcdf") as one, xr.open_dataset(cube, engine="netcdf4") as other:
        xr.testing.assert_identical(one.load(), other.load())


@pytest.mark.filterwarnings("ignore")  # of zarr about text and its own format
def test_xarray_writes_a_cube_to_zarr_and_back(cube, tmp_path):
    pytest.importorskip("zarr")
    with xr.open_dataset(cube) as dataset:
        dataset.load().to_zarr(tmp_path / "cube.zarr")
        xr.testing.assert_identical(xr.open_zarr(tmp_path / "cube.zarr").load(), dataset)
