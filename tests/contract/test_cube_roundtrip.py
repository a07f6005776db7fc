"""What is written is read again, and what is not allowed is not written."""

import os
from pathlib import Path

import netCDF4
import numpy as np
import pytest
import xarray as xr
from example_cube import example_frame, example_header

from hcss_twin.core.errors import CubeError
from hcss_twin.cube.reader import open_cube, scenario_text
from hcss_twin.cube.requested_variables import expand
from hcss_twin.cube.variables import VARIABLES
from hcss_twin.cube.writer import CubeWriter


def write(path, header, order=None, compression=None):
    with CubeWriter(path, header, compression=compression) as writer:
        for index in order if order is not None else range(header.frames):
            writer.write_frame(index, example_frame(header, abs(index)))
    return path


@pytest.mark.parametrize("compression", [None, 1, 9])
def test_values_come_back_exactly_with_dims_types_and_attributes(tmp_path, compression):
    header = example_header(platform_speed_m_s=7000.0)
    with open_cube(write(tmp_path / "c.nc", header, compression=compression)) as cube:
        assert set(cube.data_vars) == {spec.name for spec in header.variables}
        for spec in header.variables:
            variable = cube[spec.name]
            expected = np.stack([example_frame(header, index)[spec.name] for index in range(header.frames)])
            assert variable.dims == spec.dims
            assert variable.dtype == spec.dtype
            np.testing.assert_array_equal(variable.to_numpy(), expected)
            assert variable.attrs["units"] == spec.units
            assert variable.attrs.get("standard_name") == spec.standard_name
            assert variable.attrs["comment"] == spec.description
        assert str(cube.time.to_numpy()[1]).startswith("2024-06-01T12:00:00.5")
        np.testing.assert_array_equal(cube.wavelength, [2.85, 4.0])
        np.testing.assert_array_equal(cube.wavelength_bounds, [[2.7, 3.0], [3.0, 5.0]])
        np.testing.assert_array_equal(cube.solar_zenith_angle, [24.0, 24.1, 24.2])
        assert cube.layer_name.to_numpy().tolist() == cube.layer.to_numpy().tolist() == ["cumulus", "cirrus"]
        np.testing.assert_array_equal(cube.layer_base, [66.0, 6000.0])
        np.testing.assert_array_equal(cube.layer_top, [3000.0, 10_000.0])
        assert float(cube.sensor_azimuth_angle) == 120.0
        assert float(cube.centre_displacement[-1]) == 7000.0
        assert cube.attrs["seed"] == 1


@pytest.mark.parametrize("compression", [None, 1])
def test_frames_written_together_give_the_bytes_of_frames_written_one_by_one(tmp_path, compression):
    header = example_header(platform_speed_m_s=7000.0)
    frames = [example_frame(header, index) for index in range(header.frames)]
    write(tmp_path / "single.nc", header, compression=compression)
    with CubeWriter(tmp_path / "together.nc", header, compression=compression) as writer:
        writer.write_frame(0, frames[0])
        writer.write_frames(1, frames[1:])
    with open_cube(tmp_path / "single.nc") as single, open_cube(tmp_path / "together.nc") as together:
        for name in single.variables:
            assert single[name].to_numpy().tobytes() == together[name].to_numpy().tobytes(), name


def test_a_wrong_frame_among_several_is_named_and_none_of_them_is_written(tmp_path):
    header = example_header()
    frames = [example_frame(header, index) for index in range(header.frames)]
    wrong = {**frames[1], "radiance": np.full_like(frames[1]["radiance"], np.nan)}
    with CubeWriter(tmp_path / "c.nc", header) as writer:
        with pytest.raises(CubeError, match="frame 2, radiance"):
            writer.write_frames(1, [frames[1], wrong])
        writer.write_frames(0, frames)


def test_a_cube_without_variables_by_layer_has_no_layers(tmp_path):
    header = example_header(variables=tuple(expand(["radiance", "cloud_mask"], {})))
    write(tmp_path / "c.nc", header)
    with netCDF4.Dataset(tmp_path / "c.nc") as dataset:
        assert "layer" not in dataset.dimensions
        assert not [name for name in dataset.variables if name.startswith("layer")]


def test_bands_are_selected_by_name_and_values_are_read_when_used(tmp_path):
    header = example_header()
    with open_cube(write(tmp_path / "c.nc", header)) as cube:
        assert not cube.radiance.variable._in_memory
        band = cube.radiance.sel(band="MWIR").isel(time=2)
        np.testing.assert_array_equal(band, example_frame(header, 2)["radiance"][1])
        high = cube.cloud_layer_thickness.sel(layer="cirrus").isel(time=2)
        np.testing.assert_array_equal(high, example_frame(header, 2)["cloud_layer_thickness"][1])


def test_the_order_of_frames_does_not_matter_to_a_single_byte(tmp_path, monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")
    header = example_header()
    paths = [write(tmp_path / f"{order}.nc", header, order) for order in ((0, 1, 2), (2, 0, 1))]
    assert paths[0].read_bytes() == paths[1].read_bytes()


def test_the_scenario_comes_back_exactly_however_long(tmp_path):
    text = "# Wolken über See\r\n[scene]\n\tname = 'x'\n" * 5000
    write(tmp_path / "c.nc", example_header(attributes={"hcss_scenario": text}))
    assert scenario_text(tmp_path / "c.nc") == text


def test_a_cube_without_scenario_says_so(tmp_path):
    write(tmp_path / "c.nc", example_header(attributes={}))
    with pytest.raises(CubeError, match="no scenario"):
        scenario_text(tmp_path / "c.nc")


def test_a_cube_of_one_pixel_one_band_and_one_frame_is_a_cube(tmp_path):
    full = example_header()
    header = example_header(
        rows=1,
        columns=1,
        bands=full.bands[:1],
        frame_times_s=(0.0,),
        solar_zenith_deg=(95.0,),
        solar_azimuth_deg=(0.0,),
    )
    with open_cube(write(tmp_path / "c.nc", header)) as cube:
        assert cube.radiance.shape == (1, 1, 1, 1)


def test_plain_numbers_need_no_more_than_their_size(tmp_path):
    header = example_header(rows=300, columns=400, variables=tuple(expand(["radiance"], {})))
    size = write(tmp_path / "c.nc", header).stat().st_size
    assert 3 * 2 * 300 * 400 * 4 <= size < 3 * 2 * 300 * 400 * 4 + 60_000


def broken(name, change):
    header = example_header()
    frame = example_frame(header, 0)
    frame[name] = change(frame[name])
    return header, frame


def with_value(value):
    def change(array):
        array.flat[3] = value
        return array

    return change


@pytest.mark.parametrize(
    ("name", "change", "message"),
    [
        ("radiance", lambda a: a[:, :, :-1], r"radiance: shape \(2, 5, 6\); \(2, 5, 7\) is needed"),
        ("radiance", lambda a: a[0], r"radiance: shape \(5, 7\)"),
        ("cloud_mask", lambda a: a.T, r"cloud_mask: shape \(7, 5\)"),
        ("radiance", lambda a: a.astype(np.float64), "radiance: type float64; float32 is needed"),
        ("cloud_mask", lambda a: a.astype(bool), "cloud_mask: type bool"),
        ("cloud_mask", lambda a: a.tolist(), "cloud_mask: list"),
        ("cloud_mask", lambda a: np.ma.masked_equal(a, 1), "cloud_mask: MaskedArray"),
        ("radiance", with_value(np.nan), "radiance: 1 values are not a number"),
        ("radiance", with_value(np.inf), "radiance: 1 values are infinite"),
        ("radiance", with_value(-1e-6), "radiance: the smallest value is -1e-06; at least 0"),
        ("radiance_sun_glint", with_value(-1.0), "radiance_sun_glint: the smallest"),
        ("cloud_thickness", with_value(np.nan), "cloud_thickness: 1 values are not a number"),
        ("cloud_top_altitude", with_value(-np.inf), "cloud_top_altitude: 1 values are infinite"),
        ("cloud_mask", with_value(2), "cloud_mask: the largest value is 2; at most 1"),
    ],
)
def test_an_array_against_its_spec_is_refused_by_name_and_nothing_is_left(tmp_path, name, change, message):
    header, frame = broken(name, change)
    with pytest.raises(CubeError, match=f"frame 0, {message}"), CubeWriter(tmp_path / "c.nc", header) as writer:
        writer.write_frame(0, frame)
    assert list(tmp_path.iterdir()) == []


def test_missing_is_allowed_in_every_pixel_where_the_spec_says_so(tmp_path):
    header = example_header(variables=tuple(spec for spec in VARIABLES if spec.may_be_missing))
    bands = (len(header.bands),)
    shapes = {spec.name: (bands if "band" in spec.dims else ()) + (5, 7) for spec in header.variables}
    empty = {name: np.full(shape, np.nan, dtype=np.float32) for name, shape in shapes.items()}
    with CubeWriter(tmp_path / "c.nc", header) as writer:
        for index in range(3):
            writer.write_frame(index, empty)
    with open_cube(tmp_path / "c.nc") as cube:
        assert bool(cube.cloud_top_altitude.isnull().all())


@pytest.mark.parametrize(
    ("frames", "message"),
    [([3], "frame 3: 0 to 2"), ([-1], "frame -1: 0 to 2"), ([0, 0], "frame 0: already"), ([0, 2], "1 of 3 .*: 1$")],
)
def test_every_frame_is_written_once(tmp_path, frames, message):
    with pytest.raises(CubeError, match=message):
        write(tmp_path / "c.nc", example_header(), frames)
    assert list(tmp_path.iterdir()) == []


def test_a_frame_has_the_variables_of_the_header_and_no_others(tmp_path):
    header = example_header()
    frame = example_frame(header, 0)
    frame["glint"] = frame.pop("radiance_sun_glint")
    with (
        pytest.raises(CubeError, match=r"missing variables: radiance_sun_glint; .* does not have: glint"),
        CubeWriter(tmp_path / "c.nc", header) as writer,
    ):
        writer.write_frame(0, frame)


def test_frames_outside_the_block_are_refused(tmp_path):
    header = example_header()
    writer = CubeWriter(tmp_path / "c.nc", header)
    with pytest.raises(CubeError, match="not open"):
        writer.write_frame(0, example_frame(header, 0))


@pytest.mark.parametrize("level", [0, 10, -1])
def test_a_compression_level_that_zlib_does_not_have_is_refused(tmp_path, level):
    with pytest.raises(CubeError, match="zlib level"):
        CubeWriter(tmp_path / "c.nc", example_header(), compression=level)


def test_foreign_files_are_refused(tmp_path):
    with pytest.raises(CubeError, match="no such file"):
        open_cube(tmp_path / "none.nc")
    (tmp_path / "text.nc").write_text("not NetCDF")
    with pytest.raises(CubeError, match=r"text\.nc"):
        open_cube(tmp_path / "text.nc")
    xr.Dataset({"radiance": ("x", [1.0])}).to_netcdf(tmp_path / "other.nc", engine="netcdf4")
    with pytest.raises(CubeError, match="not a finished cube"):
        open_cube(tmp_path / "other.nc")


def test_another_format_version_is_refused(tmp_path):
    path = write(tmp_path / "c.nc", example_header())
    with netCDF4.Dataset(path, "a") as dataset:
        dataset.hcss_cube_format = np.int32(2)
    with pytest.raises(CubeError, match="cube format 2"):
        open_cube(path)


@pytest.mark.skipif(not Path("/proc/self/fd").exists(), reason="open files are counted in /proc")
def test_a_cube_that_is_closed_holds_no_file(tmp_path):
    path = write(tmp_path / "c.nc", example_header())

    def held():
        return [each for each in Path("/proc/self/fd").iterdir() if os.path.realpath(each) == str(path.resolve())]

    with open_cube(path) as cube:
        cube["radiance"].isel(time=0).load()
        assert held()
    assert not held()
