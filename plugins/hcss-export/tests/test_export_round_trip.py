"""Values and places of exported cubes, read by programs that are not ours: astropy, GDAL (rasterio) and Pillow."""

import json
import shutil
import tracemalloc

import netCDF4
import numpy as np
import pytest
import rasterio
import rasterio.warp
from astropy.io import fits
from astropy.wcs import WCS
from example_cube import example_frame, example_header
from hcss_export import export_cube
from hcss_export.projection import WGS84_INVERSE_FLATTENING, WGS84_SEMI_MAJOR_M, Projection
from PIL import Image

from hcss_twin.core.errors import CubeError
from hcss_twin.cube.reader import open_cube
from hcss_twin.cube.writer import CubeWriter
from hcss_twin.physics.geodesy import to_geographic

VARIABLES = ["radiance", "cloud_mask", "cloud_top_altitude", "cloud_layer_thickness"]
"""By band, whole numbers, with missing values, by layer."""


@pytest.fixture(scope="module")
def cube(tmp_path_factory):
    path = tmp_path_factory.mktemp("cube") / "c.nc"
    header = example_header(platform_speed_m_s=3000.0, frame_times_s=(0.0, 0.5, 1.25), latitude=-62.0)
    with CubeWriter(path, header) as writer:
        for index in range(header.frames):
            writer.write_frame(index, example_frame(header, index))
    return path


def values_of(cube, variable):
    """Values (time, plane, y, x), the southernmost row first."""
    with open_cube(cube) as dataset:
        data = dataset[variable].to_numpy()
    return data if data.ndim == 4 else data[:, None]


@pytest.mark.parametrize("variable", VARIABLES)
def test_fits_holds_the_values(cube, tmp_path, variable):
    done = export_cube(cube, "fits", tmp_path, variable=variable)
    expected = values_of(cube, variable)
    with fits.open(done.files[0]) as file:
        file.verify("exception")
        found = file[0].data
        np.testing.assert_array_equal(found, expected.reshape(found.shape))
        assert found.dtype == expected.dtype.newbyteorder(">")
        assert found.ndim == (3 if variable in ("cloud_mask", "cloud_top_altitude") else 4)
    assert done.missing == (np.isnan(expected).sum() if variable == "cloud_top_altitude" else 0)


@pytest.mark.parametrize("kind", ["u2", "u4", "i2", "f8"])
def test_numbers_of_other_types_are_kept_by_every_format(cube, tmp_path, kind):
    """What sensors add to a cube: digital numbers, rates."""
    path = tmp_path / "c.nc"
    shutil.copy(cube, path)
    highest = 65535 if kind != "i2" else 30_000
    numbers = np.random.default_rng(3).integers(0, highest, (3, 2, 5, 7), endpoint=True).astype(kind)
    numbers.flat[0], numbers.flat[-1] = 0, highest
    with netCDF4.Dataset(path, "a") as file:
        variable = file.createVariable("digital_number", kind, ("time", "band", "y", "x"), fill_value=False)
        variable.setncatts({"units": "1", "grid_mapping": "local_plane"})
        variable[:] = numbers
    wanted = {"variable": "digital_number", "bands": ["MWIR"], "frames": [1]}
    expected = numbers[1, 1]
    np.testing.assert_array_equal(fits.getdata(export_cube(path, "fits", tmp_path, **wanted).files[0])[0, 0], expected)
    for to in ("envi", "geotiff"):
        with rasterio.open(export_cube(path, to, tmp_path, **wanted).files[0]) as file:
            np.testing.assert_array_equal(file.read(1), expected[::-1])
            assert file.dtypes[0] == expected.dtype
    done = export_cube(path, "png", tmp_path, **wanted)
    with Image.open(done.files[0]) as image:
        scale, offset = float(image.text["hcss_scale"]), float(image.text["hcss_offset"])
        found = offset + scale * np.asarray(image).astype(float)
    if kind == "f8":
        np.testing.assert_allclose(found, expected[::-1], rtol=0, atol=0.5 * np.ptp(expected) / 65534 + 1e-9)
    else:
        np.testing.assert_array_equal(found, expected[::-1])


def test_an_image_without_time_or_bands_is_one_image(cube, tmp_path):
    path = tmp_path / "c.nc"
    shutil.copy(cube, path)
    values = np.random.default_rng(4).random((5, 7))
    with netCDF4.Dataset(path, "a") as file:
        variable = file.createVariable("latitude_of_pixel", "f8", ("y", "x"), fill_value=False)
        variable.units = "degrees_north"
        variable[:] = values
    done = {to: export_cube(path, to, tmp_path, variable="latitude_of_pixel") for to in ("fits", "envi", "geotiff")}
    np.testing.assert_array_equal(fits.getdata(done["fits"].files[0]), values)
    for to in ("envi", "geotiff"):
        with rasterio.open(done[to].files[0]) as file:
            np.testing.assert_array_equal(file.read(1), values[::-1])
    assert [path.name for path in done["geotiff"].files] == ["c_latitude_of_pixel.tif"]


def test_fits_says_units_axes_times_bands_and_the_scenario(cube, tmp_path):
    path = export_cube(cube, "fits", tmp_path / "a.fits").files[0]
    with fits.open(path) as file, open_cube(cube) as dataset:
        header = file[0].header
        assert (header["BUNIT"], header["BTYPE"], header["TIMESYS"]) == ("W m-2 sr-1", "radiance", "UTC")
        assert header["DATE-OBS"] == "2024-06-01T12:00:00.000000"
        # frame times are uneven: the axis counts frames, the table knows
        assert header["CTYPE4"] == "FRAME"
        frames, bands = file["FRAMES"].data, file["BANDS"].data
        np.testing.assert_array_equal(frames["seconds_since_start"], [0.0, 0.5, 1.25])
        np.testing.assert_array_equal(frames["centre_displacement"], dataset["centre_displacement"])
        assert list(bands["name"]) == ["SWIR", "MWIR"]
        np.testing.assert_array_equal(bands["lower"], dataset["wavelength_bounds"][:, 0])
        attributes = {row["name"]: json.loads(row["json"]) for row in file["ATTRIBUTES"].data}
        assert attributes["hcss_scenario"] == dataset.attrs["hcss_scenario"]
        assert attributes["id"] == header["CUBEID"] == dataset.attrs["id"]
        x, y = WCS(header).sub([1, 2]).pixel_to_world_values(6, 0)
        assert (x, y) == (float(dataset["x"][6]), float(dataset["y"][0]))


@pytest.mark.parametrize("bands", [(), ("MWIR",)])
def test_the_header_of_digital_numbers_turns_them_into_radiance(cube, tmp_path, bands):
    known = {"SWIR": (2e-4, -0.5), "MWIR": (3e-5, 0.0)}
    worked_out = {
        name: {"radiance_per_number": gain, "radiance_at_number_0": zero} for name, (gain, zero) in known.items()
    }
    copy = tmp_path / "numbers.nc"
    copy.write_bytes(cube.read_bytes())
    with netCDF4.Dataset(copy, "a") as dataset:
        like = dataset["radiance"]
        numbers = dataset.createVariable("digital_number", "i4", like.dimensions)
        numbers[:] = np.arange(like.size).reshape(like.shape)
        numbers.coordinates, numbers.units = "band_name", "1"
        dataset.hcss_sensor = json.dumps({"stages": [{"worked_out": {"bands": worked_out}}, {"worked_out": {}}]})
    path = export_cube(copy, "fits", tmp_path / "a.fits", variable="digital_number", bands=bands).files[0]
    header = fits.getheader(path)
    for number, name in enumerate(bands or known, 1):
        assert (header[f"DNGAIN{number}"], header[f"DNZERO{number}"]) == known[name]
        assert header.comments[f"DNGAIN{number}"].endswith(name)
    assert (header["ROWORDER"], header.comments["ROWORDER"]) == (
        "BOTTOM-UP",
        "the first row of the array is the southernmost",
    )
    assert "DNGAIN1" not in fits.getheader(export_cube(copy, "fits", tmp_path / "b.fits").files[0])


def test_the_time_axis_of_fits_is_our_clock(cube, tmp_path):
    header = fits.getheader(export_cube(cube, "fits", tmp_path / "a.fits", frames=[1, 2]).files[0])
    assert (header["CTYPE4"], header["CUNIT4"]) == ("TIME", "s")
    seconds = WCS(header).sub([4]).pixel_to_world_values([0, 1])
    np.testing.assert_allclose(seconds, [0.5, 1.25])


@pytest.mark.parametrize("variable", VARIABLES)
def test_envi_holds_the_values_northernmost_line_first(cube, tmp_path, variable):
    done = export_cube(cube, "envi", tmp_path, variable=variable)
    expected = values_of(cube, variable)
    with rasterio.open(done.files[0]) as file:
        assert file.driver == "ENVI"
        found = file.read()
        assert found.dtype == expected.dtype
        assert (file.nodata is not None) == (expected.dtype.kind == "f")
    np.testing.assert_array_equal(found, expected.reshape(-1, *expected.shape[2:])[:, ::-1])


def test_envi_says_bands_times_and_units(cube, tmp_path):
    done = export_cube(cube, "envi", tmp_path / "a.img")
    text = (tmp_path / "a.hdr").read_text()
    assert "data units = W m-2 sr-1\n" in text
    assert "wavelength = {2.85, 4.0, 2.85, 4.0, 2.85, 4.0}\n" in text
    assert "MWIR frame 2 (2024-06-01T12:00:01.250000Z)" in text
    document = json.loads((tmp_path / "a.img.json").read_text())
    with open_cube(cube) as dataset:
        assert document["attributes"]["hcss_scenario"] == dataset.attrs["hcss_scenario"]
    assert [frame["seconds"] for frame in document["frames"]] == [0.0, 0.5, 1.25]
    assert {path.name for path in done.files} == {path.name for path in tmp_path.iterdir()}


@pytest.mark.parametrize("variable", VARIABLES)
def test_geotiff_holds_the_values_northernmost_row_first(cube, tmp_path, variable):
    done = export_cube(cube, "geotiff", tmp_path / "a.tif", variable=variable)
    expected = values_of(cube, variable)
    assert [path.name for path in done.files] == ["a_000.tif", "a_001.tif", "a_002.tif"]
    for path, frame in zip(done.files, expected, strict=True):
        with rasterio.open(path) as file:
            found = file.read()
            np.testing.assert_array_equal(found, frame[:, ::-1])
            assert found.dtype == expected.dtype
            assert (file.nodata is not None and np.isnan(file.nodata)) == (expected.dtype.kind == "f")


def test_geotiff_says_units_bands_and_time(cube, tmp_path):
    path = export_cube(cube, "geotiff", tmp_path / "a.tif", frames=[2]).files[0]
    assert path.name == "a.tif"
    with rasterio.open(path) as file:
        assert file.descriptions == ("SWIR", "MWIR")
        assert file.units == ("W m-2 sr-1", "W m-2 sr-1")
        assert file.tags()["time"] == "2024-06-01T12:00:01.250000Z"
        assert file.tags(2)["central_um"] == "4.0"
        document = json.loads(file.tags()["TIFFTAG_IMAGEDESCRIPTION"])
    with open_cube(cube) as dataset:
        assert document["attributes"]["hcss_scenario"] == dataset.attrs["hcss_scenario"]


@pytest.mark.parametrize("to", ["geotiff", "envi"])
@pytest.mark.parametrize("frame", [0, 2])
def test_pixels_of_a_frame_lie_where_the_cube_says(cube, tmp_path, to, frame):
    """By GDAL and PROJ, from the file alone, against Snyder's equations; the platform moves."""
    path = export_cube(cube, to, tmp_path, frames=[frame]).files[0]
    with rasterio.open(path) as file, open_cube(cube) as dataset:
        named = dataset["local_plane"].attrs
        figure = (
            f"+R={named['earth_radius']}"
            if "earth_radius" in named
            else f"+a={named['semi_major_axis']} +rf={named['inverse_flattening']}"
        )
        globe = f"+proj=longlat {figure} +no_defs"
        # row 1 from the north, column 5
        x, y = file.xy(1, 5)
        (longitude,), (latitude,) = rasterio.warp.transform(file.crs, globe, [x], [y])
        shift = float(dataset["centre_displacement"][frame])
        assert shift == 3000.0 * (0.0, 0.5, 1.25)[frame]
        east, north = float(dataset["x"][5]) + shift, float(dataset["y"][-2])
        expected = to_geographic(np.array([east]), np.array([north]), -62.0, 135.0)
    assert (latitude, longitude) == pytest.approx([float(coordinate[0]) for coordinate in expected], abs=1e-8)


def test_frames_in_several_places_have_none_in_one_envi_file(cube, tmp_path):
    path = export_cube(cube, "envi", tmp_path / "a.img").files[0]
    with rasterio.open(path) as file:
        assert not file.crs.is_projected
        assert not file.crs.is_geographic
        assert file.xy(4, 0) == (-300.0, -200.0)


@pytest.mark.parametrize("name", ["wgs84", "ellipsoid"])
def test_geotiff_of_a_plane_on_an_ellipsoid_is_read_as_such(cube, tmp_path, name, monkeypatch):
    figure = {"wgs84": (WGS84_SEMI_MAJOR_M, WGS84_INVERSE_FLATTENING), "ellipsoid": (6378388.0, 297.0)}[name]
    projection = Projection(35.0, -150.0, *figure)
    monkeypatch.setattr("hcss_export.cube_export.projection_of", lambda dataset, data: projection)
    for to in ("geotiff", "envi"):
        with rasterio.open(export_cube(cube, to, tmp_path, frames=[0]).files[0]) as file:
            read = file.crs.to_dict()
            assert (read["proj"], read["lat_0"], read["lon_0"]) == ("aeqd", 35.0, -150.0)
            if name == "wgs84":
                assert read["datum"] == "WGS84"
            else:
                found = float(read["rf"]) if "rf" in read else read.get("ellps")
                assert found in (297.0, "intl")


@pytest.mark.parametrize("variable", VARIABLES)
def test_png_leads_back_to_the_values(cube, tmp_path, variable):
    done = export_cube(cube, "png", tmp_path / "a.png", variable=variable)
    document = json.loads(done.files[-1].read_text())
    expected = values_of(cube, variable)
    pictures = document["pictures"]
    assert len(pictures) == len(done.files) - 1 == expected.shape[0] * expected.shape[1]
    names = [plane["name"] for plane in document["planes"]]
    for picture in pictures:
        with Image.open(tmp_path / picture["file"]) as image:
            samples = np.asarray(image)
            notes = dict(image.text)
        assert samples.dtype == np.uint16
        assert float(notes["hcss_scale"]) == picture["scale"]
        assert float(notes["hcss_offset"]) == picture["offset"]
        assert notes["hcss_units"] == document["units"]
        found = picture["offset"] + picture["scale"] * samples.astype(float)
        if picture["missing_sample"] is not None:
            found[samples == picture["missing_sample"]] = np.nan
        wanted = expected[picture["frame"], names.index(picture["plane"])][::-1]
        np.testing.assert_array_equal(np.isnan(found), np.isnan(wanted))
        span = np.nanmax(expected) - np.nanmin(expected)
        np.testing.assert_allclose(found, wanted, rtol=0, atol=picture["largest_error"] + 1e-12 * span)
        assert picture["largest_error"] <= 0.5 * span / 65534
        if variable == "cloud_mask":
            assert (picture["scale"], picture["offset"], picture["missing_sample"]) == (1.0, 0.0, None)


def test_png_uses_all_of_its_samples(cube, tmp_path):
    done = export_cube(cube, "png", tmp_path / "a.png", bands=["MWIR"])
    samples = []
    for path in done.files[:-1]:
        with Image.open(path) as image:
            samples.append(np.asarray(image))
    assert (np.min(samples), np.max(samples)) == (1, 65535)


def test_pictures_with_the_same_limits_have_the_same_scale(cube, tmp_path):
    scales = set()
    for frame in (0, 1):
        done = export_cube(cube, "png", tmp_path / f"{frame}.png", frames=[frame], limits=(0.0, 2.0))
        for picture in json.loads(done.files[-1].read_text())["pictures"]:
            scales.add((picture["scale"], picture["offset"]))
    assert len(scales) == 1


@pytest.mark.filterwarnings("ignore::rasterio.errors.NotGeoreferencedWarning")
def test_gdal_reads_the_png_as_pillow_does(cube, tmp_path):
    path = export_cube(cube, "png", tmp_path / "a.png", bands=["MWIR"], frames=[0]).files[0]
    with rasterio.open(path) as file, Image.open(path) as image:
        np.testing.assert_array_equal(file.read(1), np.asarray(image))


MEMORY_FRAMES, MEMORY_PIXELS = (3, 12), 140


@pytest.fixture(scope="module")
def short_and_long(tmp_path_factory):
    """Two cubes that differ in their number of frames."""
    paths = []
    for count in MEMORY_FRAMES:
        path = tmp_path_factory.mktemp("memory") / f"{count}.nc"
        angles = {"solar_zenith_deg": (20.0,) * count, "solar_azimuth_deg": (180.0,) * count}
        variables = tuple(spec for spec in example_header().variables if spec.name == "radiance")
        header = example_header(
            rows=MEMORY_PIXELS,
            columns=MEMORY_PIXELS,
            frame_times_s=tuple(np.arange(count) * 1.0),
            variables=variables,
            **angles,
        )
        with CubeWriter(path, header) as writer:
            for index in range(header.frames):
                writer.write_frame(index, example_frame(header, index))
        paths.append(path)
    return paths


@pytest.mark.parametrize("to", ["fits", "envi", "geotiff", "png"])
def test_memory_does_not_grow_with_the_number_of_frames(short_and_long, tmp_path, to):
    peaks = []
    for path in short_and_long:
        export_cube(path, to, tmp_path, frames=[0])  # what is imported is not counted
        tracemalloc.start()
        export_cube(path, to, tmp_path, replace=True)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    frame_bytes = 2 * MEMORY_PIXELS**2 * 4
    assert peaks[1] < peaks[0] + 2 * frame_bytes


@pytest.mark.parametrize("to", ["envi", "geotiff", "png"])
def test_a_file_that_cannot_be_written_whole_is_an_error_and_leaves_nothing(cube, tmp_path, to):
    resource = pytest.importorskip("resource", reason="POSIX limits")
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (64, hard))
    try:
        with pytest.raises(CubeError, match="cannot write"):
            export_cube(cube, to, tmp_path)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert not list(tmp_path.iterdir())
