"""TIFF files: bands, pixel sizes from GeoTIFF tags, missing pixels, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
import tifffile
from PIL import Image as Picture

from hcss_twin.core.errors import CatalogError
from hcss_twin.models.clouds.imagery.reader import read_image

BANDS = np.random.default_rng(0).integers(1, 60_000, (5, 48, 64), dtype=np.uint16)
PROJECTED, GEOGRAPHIC = 1, 2


def _geo(scale=(30.0, 30.0), *, model=PROJECTED, keys=(), tie=(0.0, 0.0), extra=()):
    """Tags of a grid: the model's kind, further keys (key, value), and the upper left corner."""
    entries = [(1024, 0, 1, model), *((key, 0, 1, value) for key, value in keys)]
    directory = (1, 1, 0, len(entries), *(number for entry in entries for number in entry))
    return [
        (33550, "d", 3, (*scale, 0.0), True),
        (33922, "d", 6, (0.0, 0.0, 0.0, *tie, 0.0), True),
        (34735, "H", len(directory), directory, True),
        *extra,
    ]


def _write(path, values=BANDS[0], tags=(), **options):
    tifffile.imwrite(path, values, photometric="minisblack", extratags=list(tags), metadata=None, **options)
    return path


@pytest.mark.parametrize("planes", ["contig", "separate"])
@pytest.mark.parametrize("options", [{}, {"tile": (16, 32), "compression": "zlib", "predictor": True}])
def test_a_band_is_what_was_written(tmp_path, planes, options):
    values = np.moveaxis(BANDS, 0, -1) if planes == "contig" else BANDS
    path = _write(tmp_path / "a.tif", values, planarconfig=planes, **options)
    for number in (1, 5):
        image = read_image(path, str(number))
        np.testing.assert_array_equal(image.values, BANDS[number - 1])
        assert image.variable == str(number)


def test_several_bands_need_a_choice(tmp_path):
    path = _write(tmp_path / "a.tif", BANDS, planarconfig="separate")
    with pytest.raises(CatalogError, match="several images; set variable to one of: 1, 2, 3, 4, 5"):
        read_image(path)
    with pytest.raises(CatalogError, match="no variable '6'; allowed: 1, 2, 3, 4, 5"):
        read_image(path, "6")


@pytest.mark.parametrize(
    ("tags", "size"),
    [
        (_geo(), 30.0),
        (_geo((2.5, 2.51)), np.sqrt(2.5 * 2.51)),
        (_geo((100.0, 100.0), keys=[(3076, 9002)]), 30.48),
        (_geo((0.5, 0.5), keys=[(3076, 9036)]), 500.0),
        # a hundredth of a degree at the equator: the Earth's mean circumference over 36000
        (_geo((0.01, 0.01), model=GEOGRAPHIC, tie=(10.0, 0.24)), 2 * np.pi * 6371.0088 / 36e3 * 1e3),
        (_geo((0.01, 0.01), model=3), None),
        ([], None),
    ],
)
def test_pixel_size_comes_from_the_grid(tmp_path, tags, size):
    image = read_image(_write(tmp_path / "a.tif", tags=tags))
    assert image.pixel_size_m == (None if size is None else pytest.approx(size, rel=1e-6))
    assert not image.pixel_size_is_nominal
    assert image.north_first


def test_degrees_far_from_the_equator_are_not_square_and_say_so(tmp_path):
    # 48 rows from 60.24 deg: the middle lies at 60 deg, where a degree of longitude is half as long.
    path = _write(tmp_path / "a.tif", tags=_geo((0.01, 0.01), model=GEOGRAPHIC, tie=(10.0, 60.24)))
    image = read_image(path)
    assert image.pixel_size_m is None
    assert "556 m x 1112 m at latitude 60" in image.pixel_size_note
    square = _write(tmp_path / "b.tif", tags=_geo((0.02, 0.01), model=GEOGRAPHIC, tie=(10.0, 60.24)))
    assert read_image(square).pixel_size_m == pytest.approx(1111.95, rel=1e-4)


def test_a_transformation_gives_size_and_direction(tmp_path):
    directory = (1, 1, 0, 1, 1024, 0, 1, PROJECTED)
    for step_y, north_first in ((-20.0, True), (20.0, False)):
        matrix = (20.0, 0, 0, 5e5, 0, step_y, 0, 4e6, 0, 0, 0, 0, 0, 0, 0, 1)
        path = _write(tmp_path / "a.tif", tags=[(34264, "d", 16, matrix, True), (34735, "H", 8, directory, True)])
        image = read_image(path)
        assert image.pixel_size_m == 20.0
        assert image.north_first is north_first
    matrix = (20.0, 1.0, 0, 5e5, 1.0, -20.0, 0, 4e6, 0, 0, 0, 0, 0, 0, 0, 1)
    path = _write(tmp_path / "a.tif", tags=[(34264, "d", 16, matrix, True), (34735, "H", 8, directory, True)])
    with pytest.raises(CatalogError, match="rotated relative to north"):
        read_image(path)


def test_oblong_pixels_are_refused(tmp_path):
    with pytest.raises(CatalogError, match="30 m x 60 m are not square"):
        read_image(_write(tmp_path / "a.tif", tags=_geo((30.0, 60.0))))


def test_the_no_data_value_is_missing(tmp_path):
    values = BANDS[0].copy()
    values[3, 4:9] = 0
    path = _write(tmp_path / "a.tif", values, tags=_geo(extra=[(42113, "s", 2, "0", True)]))
    assert np.isnan(read_image(path).values).sum() == 5
    assert np.isnan(read_image(path).values[3, 4:9]).all()


def test_overviews_are_passed_over_but_pages_are_not(tmp_path):
    path = tmp_path / "a.tif"
    with tifffile.TiffWriter(path) as writer:
        writer.write(BANDS[0], photometric="minisblack", metadata=None)
        writer.write(BANDS[0, ::2, ::2], photometric="minisblack", subfiletype=1, metadata=None)
    np.testing.assert_array_equal(read_image(path).values, BANDS[0])
    with tifffile.TiffWriter(path) as writer:
        for band in BANDS[:2]:
            writer.write(band, photometric="minisblack", metadata=None)
    with pytest.raises(CatalogError, match="2 pictures in one file"):
        read_image(path)


@pytest.mark.parametrize("compression", [None, "tiff_lzw", "tiff_adobe_deflate", "packbits"])
def test_pictures_of_other_writers_are_read_in_any_compression(tmp_path, compression):
    path = tmp_path / "a.tif"
    Picture.fromarray(BANDS[0]).save(path, compression=compression)
    np.testing.assert_array_equal(read_image(path).values, BANDS[0])


@pytest.mark.parametrize("compression", [None, "tiff_lzw"])
def test_colour_becomes_the_luminance_that_pillow_gives(tmp_path, compression):
    colours = np.random.default_rng(1).integers(0, 255, (20, 30, 3), dtype=np.uint8)
    picture = Picture.fromarray(colours)
    picture.save(tmp_path / "a.tif", compression=compression)
    # Pillow rounds to whole grey levels.
    np.testing.assert_allclose(read_image(tmp_path / "a.tif").values, np.asarray(picture.convert("L")), atol=1)
    np.testing.assert_array_equal(read_image(tmp_path / "a.tif", "2").values, colours[..., 1])


def test_paper_that_is_white_at_0_is_turned(tmp_path):
    tifffile.imwrite(tmp_path / "a.tif", BANDS[0], photometric="miniswhite", metadata=None)
    order = np.argsort(read_image(tmp_path / "a.tif").values, axis=None)
    assert np.all(np.diff(BANDS[0].ravel()[order].astype(int)) <= 0)


def test_damaged_files_are_named(tmp_path):
    whole = _write(tmp_path / "whole.tif", tags=_geo()).read_bytes()
    path = tmp_path / "cut.tif"
    for size in (4, 9, 100, 200, len(whole) // 2):
        path.write_bytes(whole[:size])
        with pytest.raises(CatalogError, match=r"cut\.tif"):
            read_image(path)
