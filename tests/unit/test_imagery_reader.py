"""Every kind of image file: what is read, what is refused."""

from __future__ import annotations

from pathlib import Path

import netCDF4
import numpy as np
import pytest
from PIL import Image as Picture

from hcss_twin.core.errors import CatalogError
from hcss_twin.models.clouds.imagery.image import SatelliteImage
from hcss_twin.models.clouds.imagery.reader import read_image

VALUES = np.arange(12.0).reshape(3, 4)


def _netcdf(path: Path, values=VALUES, *, x=(0.0, 2.0, "km"), y=(0.0, -2.0, "km"), name="data", **attributes):
    """Write a plane with evenly spaced coordinates given as (first, step, units)."""
    with netCDF4.Dataset(path, "w") as dataset:
        for axis, size, (first, step, units) in (("y", values.shape[0], y), ("x", values.shape[1], x)):
            dataset.createDimension(axis, size)
            coordinate = dataset.createVariable(axis, "f8", (axis,))
            coordinate[:] = first + step * np.arange(size)
            coordinate.units = units
            coordinate.standard_name = f"projection_{axis}_coordinate"
        variable = dataset.createVariable(name, "f4", ("y", "x"), fill_value=-1.0)
        # Of temperatures, values of the Earth.
        variable[:] = values + (
            200.0 if {"K", "kelvin", "Brightness temperature at 11 um"} & set(attributes.values()) else 0.0
        )
        variable.setncatts(attributes)
    return path


def _abi(path: Path, *, flags=((0, 0, 1), (2, 3, 0)), units="1", wavelength_um=0.865):
    """Write a file with the packing, flags and grid of a GOES ABI image."""
    with netCDF4.Dataset(path, "w") as dataset:
        for axis, size, step in (("y", 2, -2.8e-5), ("x", 3, 2.8e-5)):
            dataset.createDimension(axis, size)
            coordinate = dataset.createVariable(axis, "i2", (axis,))
            coordinate.setncatts({"scale_factor": np.float32(step), "add_offset": np.float32(0.03)})
            coordinate.units = "rad"
            coordinate.set_auto_maskandscale(False)
            coordinate[:] = np.arange(size)
        image = dataset.createVariable("Rad", "i2", ("y", "x"), fill_value=np.int16(4095))
        image.setncatts(
            {
                "scale_factor": 0.5,
                "add_offset": 201.0 if units == "K" else 1.0,
                "units": units,
                "ancillary_variables": "DQF",
            }
            | {"grid_mapping": "goes_imager_projection", "_Unsigned": "true"}
        )
        image.set_auto_maskandscale(False)
        image[:] = [[0, 4095, 2], [3, 4, 5]]
        quality = dataset.createVariable("DQF", "i1", ("y", "x"))
        quality[:] = flags
        quality.setncatts({"standard_name": "status_flag", "flag_values": np.array([0, 1, 2, 3], "i1")})
        quality.flag_meanings = "good_pixel_qf conditionally_usable_pixel_qf out_of_range_pixel_qf no_value_pixel_qf"
        projection = dataset.createVariable("goes_imager_projection", "i4")
        projection.setncatts({"grid_mapping_name": "geostationary", "perspective_point_height": 35786023.0})
        dataset.createDimension("band", 1)
        band = dataset.createVariable("band_wavelength", "f4", ("band",))
        band[:] = wavelength_um
        band.units = "um"
    return path


def test_abi_is_unpacked_and_flagged_pixels_are_missing(tmp_path):
    image = read_image(_abi(tmp_path / "abi.nc"))
    np.testing.assert_array_equal(image.values, [[1.0, np.nan, 2.0], [np.nan, np.nan, 3.5]])
    assert image.source == "abi.nc"
    assert image.north_first
    assert not image.east_first


def test_abi_pixel_size_is_scan_step_times_height(tmp_path):
    image = read_image(_abi(tmp_path / "abi.nc"))
    assert image.pixel_size_m == pytest.approx(2.8e-5 * 35786023.0, rel=1e-4)
    assert image.pixel_size_is_nominal


@pytest.mark.parametrize(
    ("units", "wavelength_um", "bright"),
    [
        ("1", 0.865, True),
        ("W m-2 sr-1 um-1", 0.865, True),
        ("mW m-2 sr-1 (cm-1)-1", 6.185, False),
        ("K", 10.3, False),
        ("1", 10.3, True),
    ],
)
def test_cloud_is_dark_where_the_scene_is_seen_by_its_own_heat(tmp_path, units, wavelength_um, bright):
    image = read_image(_abi(tmp_path / "abi.nc", units=units, wavelength_um=wavelength_um))
    assert image.bright_is_cloud is bright


@pytest.mark.parametrize(
    ("attributes", "bright"),
    [
        ({"units": "K"}, False),
        ({"units": "kelvin"}, False),
        ({"standard_name": "toa_brightness_temperature", "units": "celsius"}, False),
        ({"long_name": "Brightness temperature at 11 um"}, False),
        ({"units": "km", "long_name": "visible"}, True),
        ({}, True),
    ],
)
def test_temperatures_make_cold_the_cloud(tmp_path, attributes, bright):
    assert read_image(_netcdf(tmp_path / "a.nc", **attributes)).bright_is_cloud is bright


@pytest.mark.parametrize(
    ("units", "values"), [("degF", [[62.33, 8.33], [26.33, 44.33]]), ("mK", [[290e3, 260e3], [270e3, 280e3]])]
)
def test_units_of_temperature_are_converted_to_kelvin(tmp_path, units, values):
    image = SatelliteImage(np.array(values), None, True, units, "t", "t").in_kelvin()
    assert (image.units, image.bright_is_cloud) == ("K", False)
    np.testing.assert_allclose(image.values, [[290.0, 260.0], [270.0, 280.0]], atol=1e-9)


SCENE_K = np.random.default_rng(0).uniform(220.0, 300.0, (40, 50))


@pytest.mark.parametrize(
    ("factor", "offset", "unit"),
    [(10.0, 0.0, "dK"), (100.0, 0.0, "cK"), (1000.0, 0.0, "mK"), (1.0, -273.15, "degC"), (1.2, 100.0, None)],
)
def test_values_that_are_no_kelvin_are_refused_with_the_closest_reading(tmp_path, factor, offset, unit):
    values = factor * SCENE_K + offset
    with pytest.raises(CatalogError, match=f"closest is the unit {unit}: 22" if unit else "few above 400 K$") as caught:
        read_image(_netcdf(tmp_path / "a.nc", values - 200.0, units="K"))  # _netcdf adds 200 to temperatures
    assert "stated unit: K" in str(caught.value)


@pytest.mark.parametrize(("factor", "unit"), [(1.0, "kelvin"), (10.0, "dK"), (100.0, "cK")])
def test_values_without_a_unit_that_may_be_temperatures_are_doubted_by_name(tmp_path, factor, unit):
    counts = np.rint(factor * SCENE_K).astype(np.uint16)
    counts[0] = 0  # missing, as in many products
    Picture.fromarray(counts).save(tmp_path / "a.png")
    (doubt,) = (text for text in read_image(tmp_path / "a.png").described("auto") if "?" in text)
    assert f"brightness temperatures in {unit}? Then cold is cloud" in doubt
    assert "brightness" not in " ".join(read_image(tmp_path / "a.png").described("dark"))


@pytest.mark.parametrize("name", ["a.jpg", "a.png", "a.tif"])
def test_pictures_that_viewers_turn_are_refused_and_upright_ones_are_read(tmp_path, name):
    picture, stated = Picture.fromarray(SCENE_K.astype(np.uint8)), Picture.Exif()
    for orientation in (1, 6):
        stated[274] = orientation
        picture.save(tmp_path / name, exif=stated)
        if orientation == 1:
            assert read_image(tmp_path / name).values.shape == SCENE_K.shape
    with pytest.raises(CatalogError, match=rf"{name}: orientation 6 .*turned by 90 degrees clockwise.*allowed: 1"):
        read_image(tmp_path / name)


@pytest.mark.parametrize(
    ("x", "y", "size"),
    [
        ((0.0, 2.0, "km"), (0.0, -2.0, "km"), 2000.0),
        ((5e6, 30.0, "m"), (0.0, 30.1, "metres"), np.sqrt(30.0 * 30.1)),
        ((0.0, 0.01, "degrees_east"), (0.0, 0.01, "degrees_north"), None),
    ],
)
def test_pixel_size_comes_from_the_coordinates(tmp_path, x, y, size):
    image = read_image(_netcdf(tmp_path / "a.nc", x=x, y=y))
    assert image.pixel_size_m == (None if size is None else pytest.approx(size))
    assert not image.pixel_size_is_nominal
    assert image.north_first is (y[1] < 0)


def test_fill_values_are_missing(tmp_path):
    values = VALUES.copy()
    values[1, 2] = -1.0
    image = read_image(_netcdf(tmp_path / "a.nc", values))
    assert np.flatnonzero(np.isnan(image.values)).tolist() == [6]


def test_x_first_is_turned(tmp_path):
    path = _netcdf(tmp_path / "a.nc")
    with netCDF4.Dataset(path, "a") as dataset:
        dataset.createDimension("time", 1)
        dataset.createVariable("turned", "f8", ("time", "x", "y"))[:] = VALUES.T[None]
    np.testing.assert_array_equal(read_image(path, "turned").values, VALUES)


def test_several_planes_need_a_choice(tmp_path):
    path = _netcdf(tmp_path / "a.nc", coordinates="lat")
    with netCDF4.Dataset(path, "a") as dataset:
        dataset.createVariable("lat", "f8", ("y", "x"))[:] = VALUES
    assert read_image(path).long_name == "data"
    with netCDF4.Dataset(path, "a") as dataset:
        dataset.createVariable("other", "f8", ("y", "x"))[:] = 2 * VALUES
    with pytest.raises(CatalogError, match=r"set variable to one of: data, other"):
        read_image(path)
    np.testing.assert_array_equal(read_image(path, "other").values, 2 * VALUES)
    with pytest.raises(CatalogError, match="no variable 'othr'; allowed: data, other; closest is 'other'"):
        read_image(path, "othr")
    with pytest.raises(CatalogError, match="two dimensions"):
        read_image(path, "x")


@pytest.mark.parametrize(
    ("y", "message"),
    [((0.0, 3.0, "km"), "pixels of 2000 m x 3000 m are not square"), ((0.0, 0.0, "km"), "not evenly spaced")],
)
def test_pixels_must_be_square(tmp_path, y, message):
    with pytest.raises(CatalogError, match=message):
        read_image(_netcdf(tmp_path / "a.nc", y=y))


def test_colour_becomes_luminance_and_transparent_pixels_are_missing(tmp_path):
    pixels = np.zeros((2, 2, 4), dtype=np.uint8)
    pixels[..., 3] = 255
    pixels[0, 0, :3] = 255, 0, 0
    pixels[0, 1, :3] = 0, 255, 0
    pixels[1, 0, :3] = 255, 255, 255
    pixels[1, 1, 3] = 0
    Picture.fromarray(pixels).save(tmp_path / "a.png")
    image = read_image(tmp_path / "a.png")
    np.testing.assert_allclose(image.values, [[0.299 * 255, 0.587 * 255], [255, np.nan]])
    assert image.pixel_size_m is None
    assert image.bright_is_cloud


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_grey_pictures_keep_their_levels(tmp_path, dtype):
    grey = (VALUES * (np.iinfo(dtype).max // 11)).astype(dtype)
    Picture.fromarray(grey).save(tmp_path / "a.png")
    np.testing.assert_array_equal(read_image(tmp_path / "a.png").values, grey)


def test_jpeg_is_read(tmp_path):
    Picture.fromarray(np.repeat([[0, 200]], 16, axis=0).astype(np.uint8).repeat(8, axis=1)).save(tmp_path / "a.jpg")
    np.testing.assert_allclose(read_image(tmp_path / "a.jpg").values[:, [0, -1]], [[0, 200]] * 16, atol=3)


def test_the_name_of_the_file_does_not_matter(tmp_path):
    np.save(tmp_path / "a.npy", VALUES)
    (tmp_path / "a.npy").rename(tmp_path / "a.png")
    np.testing.assert_array_equal(read_image(tmp_path / "a.png").values, VALUES)


def test_archive_of_arrays(tmp_path):
    np.savez(tmp_path / "one.npz", only=VALUES)
    np.savez(tmp_path / "two.npz", a=VALUES, b=VALUES + 1)
    assert read_image(tmp_path / "one.npz").values[0, 1] == 1
    assert read_image(tmp_path / "two.npz", "b").values[0, 1] == 2
    with pytest.raises(CatalogError, match="one of: a, b"):
        read_image(tmp_path / "two.npz")


@pytest.mark.parametrize(
    ("array", "message"),
    [
        (np.zeros(5), r"shape \(5,\)"),
        (np.zeros((2, 3, 4)), r"shape \(2, 3, 4\)"),
        (np.zeros((2, 2), dtype=complex), "complex128"),
        (np.full((2, 3), np.nan), "all 6 pixels are missing"),
        (np.full((2, 3), 7.0), "all pixels have the value 7"),
        (np.array([[{}]], dtype=object), "not an array that can be read"),
    ],
)
def test_arrays_that_are_no_image(tmp_path, array, message):
    np.save(tmp_path / "a.npy", array)
    with pytest.raises(CatalogError, match=message):
        read_image(tmp_path / "a.npy")


def test_infinite_values_are_missing(tmp_path):
    np.save(tmp_path / "a.npy", np.array([[1.0, np.inf], [2.0, -np.inf]]))
    assert np.isnan(read_image(tmp_path / "a.npy").values).sum() == 2


@pytest.mark.parametrize(
    "content",
    [b"", b"not an image", b"\x89HDF\r\n\x1a\nrest", b"CDF\x01", b"\x93NUMPY", b"PK\x03\x04", b"\xff\xd8\xff\xe0xx"],
)
def test_broken_files_are_named(tmp_path, content):
    path = tmp_path / "broken.bin"
    path.write_bytes(content)
    with pytest.raises(CatalogError, match=r"broken\.bin"):
        read_image(path)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "it is empty"),
        (b"not an image", "it is not a NetCDF file, or its header is damaged"),
        (b"\x89HDF\r\n\x1a\nrest", "it is NetCDF, but damaged, truncated or unsupported"),
        (b"CDF\x01", "it is NetCDF, but damaged, truncated or unsupported"),
    ],
)
def test_a_broken_file_that_is_called_netcdf_is_said_to_be_none_or_damaged(tmp_path, content, message):
    path = tmp_path / "broken.nc"
    path.write_bytes(content)
    with pytest.raises(CatalogError) as error:
        read_image(path)
    assert f"{path}: {message}" in str(error.value)
    assert "identify" not in str(error.value)


def test_truncated_picture_is_named(tmp_path):
    Picture.fromarray(np.random.default_rng(0).integers(0, 255, (64, 64), dtype=np.uint8)).save(tmp_path / "a.png")
    whole = (tmp_path / "a.png").read_bytes()
    (tmp_path / "a.png").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(CatalogError, match=r"a\.png: not an image"):
        read_image(tmp_path / "a.png")


def test_missing_file_and_useless_variable(tmp_path):
    with pytest.raises(CatalogError, match="no image"):
        read_image(tmp_path / "nowhere.nc")
    np.save(tmp_path / "a.npy", VALUES)
    Picture.fromarray(VALUES.astype(np.uint8)).save(tmp_path / "a.png")
    for name in ("a.npy", "a.png"):
        with pytest.raises(CatalogError, match="leave it out"):
            read_image(tmp_path / name, "CMI")


def test_animation_is_refused(tmp_path):
    frames = [Picture.fromarray((VALUES * k).astype(np.uint8)) for k in (1, 2)]
    frames[0].save(tmp_path / "a.gif", save_all=True, append_images=frames[1:])
    with pytest.raises(CatalogError, match="2 pictures in one file"):
        read_image(tmp_path / "a.gif")
