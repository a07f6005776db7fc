"""Cubes of cameras are exported as images that lie nowhere on a grid on the ground."""

import shutil
import subprocess

import numpy as np
import pytest
from camera_scenes import PASS, SCENE, merged, scenario

import hcss_twin
from hcss_twin.core.errors import CubeError

hcss_export = pytest.importorskip("hcss_export")


@pytest.fixture(scope="module")
def cube(tmp_path_factory):
    path = tmp_path_factory.mktemp("pass") / "pass.nc"
    hcss_twin.simulate(scenario(merged(SCENE, PASS)), path).close()
    return path


def test_rows_of_an_export_are_those_of_the_camera_and_have_no_place_on_the_ground(cube, tmp_path):
    hcss_export.export_cube(cube, "envi", tmp_path / "image.img")
    with hcss_twin.open_cube(cube) as dataset:
        radiance = dataset["radiance"].to_numpy()
    raw = np.fromfile(tmp_path / "image.img", np.float32).reshape(radiance.shape)
    np.testing.assert_array_equal(raw, radiance)  # both begin with the highest row
    header = (tmp_path / "image.hdr").read_text(encoding="ascii")
    assert "map info" not in header
    assert "the first line is the highest" in header
    fits = pytest.importorskip("astropy.io.fits")
    hcss_export.export_cube(cube, "fits", tmp_path / "image.fits")
    with fits.open(tmp_path / "image.fits") as file:
        np.testing.assert_array_equal(np.squeeze(file[0].data[..., ::-1, :]), np.squeeze(radiance))
        assert (file[0].header["CTYPE1"], file[0].header["CTYPE2"]) == ("COLUMN", "ROW")
        assert "LAT0" not in file[0].header


def test_a_format_that_places_pixels_on_the_ground_is_refused_with_those_that_do_not(cube, tmp_path):
    with pytest.raises(CubeError, match="allowed: envi, fits, png"):
        hcss_export.export_cube(cube, "geotiff", tmp_path / "image.tif")
    assert not list(tmp_path.iterdir())


def test_cdo_takes_the_places_of_pixels_for_the_grid_of_the_radiance(cube, tmp_path):
    if shutil.which("cdo") is None:
        pytest.skip("cdo is not installed")
    with hcss_twin.open_cube(cube) as dataset:
        latitude, longitude = (dataset[f"pixel_{name}"].to_numpy()[0] for name in ("latitude", "longitude"))
        expected = dataset["radiance"].to_numpy()[0, 0, 20, 24]
    place = f"lon={float(longitude[20, 24])}_lat={float(latitude[20, 24])}"
    found = subprocess.run(
        ["cdo", "-s", "output", f"-remapnn,{place}", "-seltimestep,1", "-selname,radiance", str(cube)],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert float(found.stdout.split()[0]) == pytest.approx(float(expected), rel=1e-5)
