"""Files of examples: what is written is read, damaged ones are refused in one line, the shipped ones are whole."""

import subprocess
import sys

import netCDF4
import numpy as np
import pytest
from click.testing import CliRunner
from conftest import cloud_field
from hcss_skies.command import skies
from hcss_skies.example import LEVELS, make_example, read_example, write_example
from hcss_skies.importing import import_example
from hcss_skies.library import shipped
from hcss_skies.split_window import DEPTH_RATIO, WAVELENGTHS_UM, height_above_opaque_m
from scipy.ndimage import gaussian_filter

from hcss_twin.errors import CatalogError
from hcss_twin.physics.planck import planck

TERMS = {"pixel_size_m": 3000.0, "clear_m": 300.0, "kind": "test", "source": "test", "licence": "none"}


@pytest.fixture
def written(tmp_path):
    path = tmp_path / "own.nc"
    write_example(path, make_example(cloud_field(64), np.zeros((64, 64)), **TERMS))
    return path


def test_a_file_gives_the_field_back_by_its_ranks(written):
    """256 ranks over 8 standard deviations of the score."""
    example, field = read_example(written), cloud_field(64)
    found = example.opaque_m[example.opaque]
    assert np.abs(found - field).mean() < 0.01 * np.ptp(field)
    np.testing.assert_allclose(np.quantile(found, [0.1, 0.5, 0.9]), np.quantile(field, [0.1, 0.5, 0.9]), atol=25.0)
    assert example.coverage == pytest.approx(np.mean(field > 300.0), abs=0.02)
    assert example.excess_is_known
    assert not make_example(field, None, **TERMS).excess_is_known


def test_a_file_of_256_by_256_pixels_is_small(tmp_path):
    write_example(tmp_path / "own.nc", make_example(cloud_field(256), None, **TERMS))
    assert (tmp_path / "own.nc").stat().st_size < 85_000


@pytest.mark.parametrize("part", [0.0, 0.3, 0.9])
def test_a_truncated_file_is_one_clear_error(written, part):
    content = written.read_bytes()
    written.write_bytes(content[: int(part * len(content))])
    with pytest.raises(CatalogError, match=r"own\.nc"):
        read_example(written)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda file: file.setncattr("hcss_skies_format", 9), "no example of a sky"),
        (lambda file: file.setncattr("pixel_size_m", -1.0), "pixel_size_m -1; allowed: 1 to 100000"),
        (lambda file: file.setncattr("pixel_size_m", "wide"), r"own\.nc"),
        (lambda file: file.delncattr("kind"), r"own\.nc"),
        (lambda file: file["opaque_m"].__setitem__(5, np.nan), "heights that do not ascend"),
        (lambda file: file["opaque_m"].__setitem__(LEVELS - 1, 1e6), "outside -3000 to 30000 m"),
    ],
)
def test_wrong_contents_are_named(written, change, message):
    with netCDF4.Dataset(written, "a") as file:
        change(file)
    with pytest.raises(CatalogError, match=message):
        read_example(written)


def test_the_library_has_24_examples_of_eight_kinds_in_two_megabytes():
    examples = [read_example(path) for path in shipped().values()]
    assert len(examples) >= 24
    assert len({example.kind for example in examples}) >= 8
    assert sum(path.stat().st_size for path in shipped().values()) < 2_000_000
    assert all(example.licence == "BSD-3-Clause" and 0.1 < example.coverage < 0.99 for example in examples)


def write_image(path, kelvin):
    with netCDF4.Dataset(path, "w") as file:
        for name, size in zip("yx", kelvin.shape, strict=True):
            file.createDimension(name, size)
            axis = file.createVariable(name, "f8", (name,))
            axis[:], axis.units = 3000.0 * np.arange(size), "m"
        image = file.createVariable("bt", "f4", ("y", "x"))
        image[:], image.units, image.long_name = kelvin, "K", "brightness temperature at 10.8 um"
        file.license = "of the test"


def test_an_imported_image_keeps_its_heights(tmp_path):
    """Heights by 6.5 K/km below the 99th percentile; sharpening keeps means."""
    height = gaussian_filter(cloud_field(64), 1.5, mode="wrap")
    write_image(tmp_path / "image.nc", 295.0 - 6.5e-3 * height)
    example = import_example(tmp_path / "image.nc")
    found = example.opaque_m[example.opaque]
    assert found.mean() == pytest.approx((height - np.quantile(height, 0.01)).mean(), rel=0.03)
    assert np.corrcoef(found.ravel(), height.ravel())[0, 1] > 0.97
    assert (example.pixel_size_m, example.licence, example.excess_is_known) == (3000.0, "of the test", False)


@pytest.mark.parametrize(
    ("kelvin", "message"),
    [
        (np.linspace(0, 255, 400).reshape(20, 20), "allowed: brightness temperatures, 150 to 340 K"),
        (
            np.where(np.eye(20) > 0, np.nan, np.linspace(280, 290, 400).reshape(20, 20)),
            "5.0% of the pixels are missing",
        ),
        (np.array([[280.0, 281.0], [282.0, 283.0]]), "2 x 2 pixels; allowed: sides of 4 to 4096"),
    ],
)
def test_an_image_that_is_no_brightness_temperature_is_refused(tmp_path, kelvin, message):
    write_image(tmp_path / "image.nc", kelvin)
    with pytest.raises(CatalogError, match=message):
        import_example(tmp_path / "image.nc")


def test_the_commands_list_and_import(tmp_path):
    listed = CliRunner().invoke(skies, ["list"], catch_exceptions=False)
    assert "open-cells-1" in listed.output
    write_image(tmp_path / "image.nc", 295.0 - 6.5e-3 * cloud_field(64))
    arguments = ["import", str(tmp_path / "image.nc"), "-o", str(tmp_path / "own.nc")]
    assert "64 x 64 pixels of 3000 m" in CliRunner().invoke(skies, arguments, catch_exceptions=False).output
    with pytest.raises(CatalogError, match="exists; --force replaces it"):
        CliRunner().invoke(skies, arguments, catch_exceptions=False)


def test_registration_imports_nothing_heavy():
    code = (
        "import sys, hcss_skies as e, hcss_skies.commands as c; e.hcss_register_cloud_generators(); c.hcss_commands(); "
        "print([m for m in sys.modules if m.split('.')[0] in ('numpy', 'scipy', 'numba', 'click', 'pydantic')])"
    )
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert result.stdout.strip() == "[]"


def test_a_second_channel_gives_the_height_of_thin_cloud():
    """A layer of ice at 9 km over a sea of 295 K, from opaque to thin; radiances by Planck's law."""
    height, clear = 9000.0, 295.0
    thickness = np.geomspace(0.3, 8.0, 64)[:, None] * np.ones(64)
    thickness[:, 48:] = 0.0
    kelvin = np.linspace(150.0, 320.0, 20001)
    seen = []
    for wavelength, depth in zip(WAVELENGTHS_UM, (thickness, DEPTH_RATIO * thickness), strict=True):
        black = planck(np.asarray(1e4 / wavelength), kelvin)
        cloud, sea = (np.interp(each, kelvin, black) for each in (clear - 6.5e-3 * height, clear))
        seen.append(np.interp(cloud + (sea - cloud) * np.exp(-depth), black, kelvin))
    found = height_above_opaque_m(*seen, clear, 6.5e-3) + (clear - seen[0]) / 6.5e-3
    inside = found[8:-8, 8:40]
    assert np.abs(inside - height).max() < 2000.0
    assert np.abs(np.median(inside) - height) < 400.0
