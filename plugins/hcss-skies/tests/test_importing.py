"""Examples from images: heights, channels, missing pixels, detail; wrong files are refused in one line."""

import os
import re
from pathlib import Path

import netCDF4
import numpy as np
import pytest
from click.testing import CliRunner
from conftest import cloud_field, rough_field
from hcss_skies.command import skies
from hcss_skies.detail import deviation_of, moments_of
from hcss_skies.detail_of_image import fit_detail
from hcss_skies.fibres import textures
from hcss_skies.importing import import_example
from hcss_skies.missing import filled, largest_rectangle
from hcss_skies.refining import MARGIN, refine
from hcss_skies.split_window import DEPTH_RATIO, WAVELENGTHS_UM, height_above_opaque_m
from scipy.ndimage import gaussian_filter

from hcss_twin.physics.planck import planck
from hcss_twin.providers import CatalogError


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
    example = import_example(tmp_path / "image.nc").example
    found = example.opaque_m[example.opaque]
    assert found.mean() == pytest.approx((height - np.quantile(height, 0.01)).mean(), rel=0.03)
    assert np.corrcoef(found.ravel(), height.ravel())[0, 1] > 0.97
    assert (example.pixel_size_m, example.licence, example.excess_is_known) == (3000.0, "of the test", False)


@pytest.mark.parametrize(
    ("kelvin", "message"),
    [
        (np.linspace(0, 255, 400).reshape(20, 20), "allowed: brightness temperatures of 100 to 500 K"),
        (
            np.where(np.arange(400).reshape(20, 20) == 7, np.nan, np.linspace(270, 350, 400).reshape(20, 20)),
            r"values of 27.* to 350; allowed: brightness temperatures",
        ),
        (np.linspace(2200, 3000, 400).reshape(20, 20), "closest is the unit dK: 220.8 to 299.2 K"),
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
    again = CliRunner().invoke(skies, arguments, catch_exceptions=False)
    assert again.exit_code == 1
    assert "exists; give another name with -o, or --force" in again.output


def test_a_second_channel_gives_the_height_of_thin_cloud():
    """A layer of ice at 9 km over a sea of 295 K, from opaque to thin; radiances by Planck's law."""
    height, clear = 9000.0, 295.0
    thickness = np.geomspace(0.3, 8.0, 64)[:, None] * np.ones(64)
    thickness[:, 48:] = 0.0
    kelvin = np.linspace(150.0, 320.0, 20001)
    seen = []
    for wavelength, depth in zip(WAVELENGTHS_UM, (thickness, DEPTH_RATIO * thickness), strict=True):
        black = planck(np.asarray(1e4 / wavelength), kelvin)
        cloud, sea = (np.interp(kelvin_at, kelvin, black) for kelvin_at in (clear - 6.5e-3 * height, clear))
        seen.append(np.interp(cloud + (sea - cloud) * np.exp(-depth), black, kelvin))
    found = height_above_opaque_m(*seen, clear, 6.5e-3) + (clear - seen[0]) / 6.5e-3
    inside = found[8:-8, 8:40]
    assert np.abs(inside - height).max() < 2000.0
    assert np.abs(np.median(inside) - height) < 400.0


def write_stack(path, kelvin, spacing_deg=0.03):
    """Two scenes and two times in two channels, the first row northernmost; the second channel is 1 K colder."""
    with netCDF4.Dataset(path, "w") as file:
        for name, size in zip(("scene", "time", "y", "x"), kelvin.shape, strict=True):
            file.createDimension(name, size)
        for name, cold in (("ir_108", 0.0), ("ir_120", 1.0), ("wv_062", 50.0)):
            variable = file.createVariable(name, "f4", ("scene", "time", "y", "x"), fill_value=-1.0)
            variable[:], variable.units = np.nan_to_num(kelvin - cold, nan=-1.0), "K"
        axes = np.meshgrid(
            60.0 - spacing_deg * np.arange(kelvin.shape[2]),
            2.0 * spacing_deg * np.arange(kelvin.shape[3]),
            indexing="ij",
        )
        for name, values in zip(("latitude", "longitude"), axes, strict=True):
            file.createVariable(name, "f8", ("scene", "y", "x"))[:] = np.stack([values] * kelvin.shape[0])


def test_a_file_of_many_images_and_channels_is_imported_in_one_command(tmp_path):
    """0.03 degrees along a meridian are 3335.8 m; 0.06 along the parallel of the middle, 59.04 N, 2 cos 59.04 of it."""
    kelvin = 295.0 - 6.5e-3 * np.stack([[cloud_field(64, seed) for seed in (3, 4)], [cloud_field(64, 5)] * 2])
    write_stack(tmp_path / "stack.nc", kelvin)
    arguments = ["import", str(tmp_path / "stack.nc"), "-o", str(tmp_path / "own.nc"), "--at", "scene=0"]
    done = CliRunner().invoke(skies, [*arguments, "--at", "time=1"], catch_exceptions=False)
    size = 6.371e6 * np.radians(0.03) * np.sqrt(2.0 * np.cos(np.radians(60.0 - 0.03 * 31.5)))
    assert f"64 x 64 pixels of {size:.5g}" in done.output
    assert "from ir_108 and ir_120" in done.output
    example = import_example(tmp_path / "stack.nc", at={"scene": 0, "time": 1}).example
    found = example.opaque_m[example.opaque]
    assert np.corrcoef(found.ravel(), cloud_field(64, 4)[::-1].ravel())[0, 1] > 0.9  # north last
    with pytest.raises(CatalogError, match="ir_108 has 2 images along time; allowed: one, chosen with at time=0 to 1"):
        CliRunner().invoke(skies, [*arguments, "--force"], catch_exceptions=False)
    with pytest.raises(CatalogError, match="at scene=2; allowed: 0 to 1"):
        import_example(tmp_path / "stack.nc", at={"scene": 2, "time": 0})
    with pytest.raises(CatalogError, match="no such dimension of ir_108; allowed: scene, time; closest is 'scene'"):
        import_example(tmp_path / "stack.nc", at={"scen": 0})


def test_missing_pixels_are_filled_by_harmonic_functions():
    """x^2 - y^2 solves Laplace's equation exactly, on the grid, too."""
    y, x = np.mgrid[-20:20, -20:20].astype(float)
    exact = x**2 - y**2 + 3.0 * x * y
    holes = exact.copy()
    holes[5:12, 20:31] = holes[30, 3] = np.nan
    np.testing.assert_allclose(filled(holes), exact, atol=1e-8)


def test_the_largest_rectangle_is_that_of_all_rectangles():
    rng = np.random.default_rng(2)
    for density in (0.5, 0.9, 1.0):
        known = rng.random((7, 9)) < density
        rows, columns = largest_rectangle(known)
        assert known[rows, columns].all()
        areas = [
            (i1 - i0) * (j1 - j0)
            for i0 in range(7) for i1 in range(i0 + 1, 8) for j0 in range(9) for j1 in range(j0 + 1, 10)
            if known[i0:i1, j0:j1].all()
        ]  # fmt: skip
        assert (rows.stop - rows.start) * (columns.stop - columns.start) == max(areas, default=0)


def test_missing_pixels_are_filled_cropped_or_refused_with_their_share(tmp_path):
    kelvin = 295.0 - 6.5e-3 * gaussian_filter(cloud_field(96), 1.5, mode="wrap")
    few = np.where(np.random.default_rng(1).random((96, 96)) < 0.02, np.nan, kelvin)
    border = kelvin.copy()
    border[:8] = np.nan
    half = kelvin.copy()
    half[:, ::2] = np.nan
    for name, image in (("few", few), ("border", border), ("half", half), ("all", kelvin)):
        write_image(tmp_path / f"{name}.nc", image)
    of_few, of_border, of_all = (import_example(tmp_path / f"{name}.nc") for name in ("few", "border", "all"))
    heights = [imported.example.opaque_m[imported.example.opaque] for imported in (of_few, of_all)]
    assert np.corrcoef(heights[0].ravel(), heights[1].ravel())[0, 1] > 0.99
    assert f"{np.isnan(few).mean():.2%} of the pixels are filled by interpolation" in of_few.example.source
    assert of_border.example.opaque.shape == (88, 96)
    assert "cropped to 88 x 96 pixels (91.7%), because 8.33% of all pixels are missing" in of_border.notes[-1]
    with pytest.raises(CatalogError, match=r"50.0% of the pixels are missing; allowed: 5% to be filled, .* 96 x 1 pix"):
        import_example(tmp_path / "half.nc")
    with pytest.raises(CatalogError, match=r"8.3% of the pixels are missing; allowed: 5% to be filled"):
        import_example(tmp_path / "border.nc", missing="fill")


@pytest.mark.parametrize("density", [2.9, 3.4])
def test_detail_continues_the_octaves_of_the_image(density):
    """Fitted to a field at half of its resolution, detail has the variance and the exponent that the field has there.

    A field k^-density of two dimensions has the exponent density - 1 along a line.
    """
    height = 1500.0 * np.exp(0.6 * rough_field(512, density))
    fitted = fit_detail(height.reshape(256, 2, 256, 2).mean(axis=(1, 3)))
    assert fitted.exponent == pytest.approx(density - 1.0, abs=0.15)
    parents = height.reshape(256, 2, 256, 2).mean(axis=(1, 3))
    children = divided(parents, fitted.strength, fitted.exponent, 1)
    cut = slice(MARGIN, -MARGIN)
    variance = [
        np.mean((cells - np.kron(parents[cut, cut], np.ones((2, 2)))) ** 2)
        for cells in (children, height[2 * MARGIN : -2 * MARGIN, 2 * MARGIN : -2 * MARGIN])
    ]
    assert abs(10.0 * np.log10(variance[0] / variance[1])) < 1.5


def divided(cells, strength, exponent, halvings, most=1e9, visible=100.0):
    """Return cells with detail, without those at the border."""
    side = 2**halvings
    out = np.empty(tuple((size - 2 * MARGIN) * side for size in cells.shape))
    law = np.array([deviation_of(exponent, halving) for halving in range(halvings)])
    moments = moments_of(range(halvings), [np.nan] * halvings)
    refine(out, cells, np.zeros(2, np.int64), strength, law, most, visible, textures(), *moments)
    return out


def test_changes_over_the_sides_of_divided_cells_are_like_those_inside():
    """Within a tenth: a measured image has 1.02 (``make/scores.md``)."""
    step = np.diff(np.log(divided(1500.0 * np.exp(0.6 * rough_field(128, 2.9)), 0.44, 2.2, 2)), axis=1)
    over = np.arange(step.shape[1]) % 4 == 3
    assert step[:, over].std() / step[:, ~over].std() == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e3])
def test_divided_cells_keep_their_mean_within_the_layer(scale):
    """Cells of 0 to the greatest thickness, clear ones beside full ones, and thicknesses that are hardly any."""
    rng = np.random.default_rng(4)
    cells = rng.choice([0.0, 1e-12, 0.02, 0.6, 0.999, 1.0], (40, 40)) * rng.choice([1.0, 1.0, 0.5], (40, 40)) * scale
    parts = divided(cells, 0.7, 2.2, 4, most=scale, visible=0.1 * scale)
    means = parts.reshape(26, 16, 26, 16).mean(axis=(1, 3))
    np.testing.assert_allclose(means, cells[MARGIN:-MARGIN, MARGIN:-MARGIN], rtol=1e-9, atol=1e-12 * scale)
    assert parts.min() >= 0.0
    assert parts.max() <= scale * (1.0 + 1e-12)


def test_clouds_end_inside_their_cells():
    """Beside clear cells, parts of cells at the side hold far less than the cell: its square is not seen."""
    y, x = np.mgrid[-20:20, -20:20] + 0.5
    cells = np.where(np.hypot(y, x) < 9.0, 600.0, 0.0)
    parts = divided(cells, 0.3, 2.3, 4, most=1000.0, visible=50.0)
    fine = np.kron(cells[MARGIN:-MARGIN, MARGIN:-MARGIN], np.ones((16, 16)))
    at_side = (fine[:, 1:-1] > 0.0) & ((fine[:, :-2] == 0.0) | (fine[:, 2:] == 0.0))
    assert np.median(parts[:, 1:-1][at_side]) < 0.1 * 600.0


def test_too_little_cloud_gives_no_detail_and_an_example_its_own(make, tmp_path):
    assert fit_detail(np.zeros((64, 64))) is None
    assert fit_detail(cloud_field(64)[:24]) is None
    write_image(tmp_path / "image.nc", 295.0 - 6.5e-3 * gaussian_filter(cloud_field(256), 1.0, mode="wrap"))
    (tmp_path / "skies").mkdir()
    arguments = ["import", str(tmp_path / "image.nc"), "-o", str(tmp_path / "skies" / "image.nc")]
    answer = CliRunner().invoke(skies, arguments, catch_exceptions=False).output
    assert "Detail below the pixel, extrapolated from octaves of 2 to 8 pixels" in answer
    notes = make(500.0, example="image").declares.notes
    assert any("from octaves of 2 to 8 pixels of the image, extrapolated" in note for note in notes)


def test_real_files_are_imported(tmp_path):
    """SEVIRI blocks with coordinates, radiance of GOES ABI, and a product with missing pixels."""
    folder = os.environ.get("HCSS_SAMPLE_DATA")
    if folder is None:
        pytest.skip("HCSS_SAMPLE_DATA names no folder")
    (blocks,) = Path(folder, "seviri").glob("sea-blocks*.nc")
    done = import_example(blocks, at={"block": 3, "time": 1})
    assert (done.variable, done.second) == ("ir_108", "ir_120")
    assert 3000.0 < done.example.pixel_size_m < 4500.0
    (product,) = Path(folder, "images").glob("*Cloud_Top_Height.nc")
    with pytest.raises(CatalogError, match=r"HT has the unit 'm'; allowed: K"):
        import_example(product)


def test_match_and_fit_know_the_detail_below_the_pixel(tmp_path):
    """Of the spectrum that the image was made with, seen through the blur of a sensor; other images have no note."""
    from hcss_evaluate.matching.target import ImageChoice, read_target

    height = 1500.0 * np.exp(0.6 * rough_field(512, 3.2)).reshape(256, 2, 256, 2).mean(axis=(1, 3))
    write_image(tmp_path / "image.nc", 300.0 - 6.5e-3 * gaussian_filter(height, 0.5, mode="wrap"))
    (note,) = (note for note in read_target(tmp_path / "image.nc").notes if "below the pixel" in note)
    exponent, dimension = (float(number) for number in re.findall(r"(?:exponent|dimension) (\d\.\d+)", note))
    assert exponent == pytest.approx(2.2, abs=0.2)
    assert dimension == pytest.approx((7.0 - exponent) / 2.0, abs=0.01)
    assert "extrapolated" in note
    assert "sensor's blur" in note
    np.save(tmp_path / "grey.npy", height / height.max())
    notes = read_target(tmp_path / "grey.npy", ImageChoice(pixel_size_m=3000.0)).notes
    assert not any("below the pixel" in note for note in notes)
