"""Laws of clouds cut from an image: place, thickness, motion, coverage, and what does not fit."""

from __future__ import annotations

import re

import numpy as np
import pytest
from pydantic import ValidationError
from whole_frames import thickness_frame

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import CatalogError, ScenarioError
from hcss_twin.models.clouds.imagery.generator import ImageryClouds
from hcss_twin.models.clouds.imagery.parameters import ImageryParameters
from hcss_twin.providers import CloudInputs, CloudLayer, Grid, Microphysics, Motion

ROWS, COLUMNS = 40, 60
THINNEST, THICKEST = 100.0, 2000.0


def _image() -> tuple[np.ndarray, np.ndarray]:
    """Return a sea at .05 with two cloud decks at .5 and .9, and the mask of the clouds."""
    image = np.full((ROWS, COLUMNS), 0.05)
    image[5:20, 10:35] = 0.5
    image[25:33, 30:50] = 0.9
    return image, image > 0.1


def _clouds(
    folder,
    image,
    *,
    size=None,
    coverage=0.5,
    platform=0.0,
    wind=(0.0, 0.0),
    pixel_size_m=1000.0,
    catalog=None,
    limits=(THINNEST, THICKEST),
    **parameters,
):
    np.save(folder / "image.npy", image)
    microphysics = Microphysics("water", 6.0, 1.5, 1.0, 1e8, (0.1, 50.0))
    layer = CloudLayer("test", 1000.0, 1000.0 + limits[1], "base", limits[0], coverage, None, microphysics)
    inputs = CloudInputs(
        layer=layer,
        grid=Grid(*(size or image.shape), pixel_size_m),
        motion=Motion(platform, wind, np.inf, 1.0),
        seed=0,
        catalog=catalog or Catalog(base=folder),
    )
    return ImageryClouds(inputs, ImageryParameters(image="image.npy", **parameters))


@pytest.mark.parametrize("method", ["otsu", "local"])
def test_mask_is_the_known_one_and_north_is_up(tmp_path, method):
    image, cloud = _image()
    clouds = _clouds(tmp_path, image, method=method)
    thickness = thickness_frame(clouds)
    # The first stored row is the northernmost; in a scene y grows northward with the row.
    assert np.array_equal(thickness > 0, cloud[::-1])
    assert thickness.dtype == np.float32
    assert clouds.image_coverage == pytest.approx(cloud.mean())


def test_thickness_is_linear_in_grey_level_above_the_threshold(tmp_path):
    image, cloud = _image()
    thickness = thickness_frame(_clouds(tmp_path, image))[::-1]
    # The histogram's best split is the middle of the gap between sea and lower deck.
    threshold = 0.5 * (0.05 + 0.5)
    expected = THINNEST + (THICKEST - THINNEST) * (image - threshold) / (0.9 - threshold)
    np.testing.assert_allclose(thickness[cloud], expected[cloud], rtol=0.01)
    assert thickness.max() == THICKEST


def test_thickness_rises_with_grey_level_and_stays_in_the_layer(tmp_path):
    image = np.random.default_rng(0).gamma(1.5, 0.1, (80, 80))
    # 333.3 is not a single-precision number, and the nearest one is greater.
    thickness = thickness_frame(_clouds(tmp_path, image, limits=(50.1, 333.3)))[::-1].astype(np.float64)
    order = np.argsort(image, axis=None)
    assert np.all(np.diff(thickness.ravel()[order]) >= 0)
    assert thickness[thickness > 0].min() >= 50.1 - 1e-5
    assert thickness.max() <= 333.3


def test_brightest_thousandth_does_not_thin_the_rest(tmp_path):
    image, _ = _image()
    wide = np.tile(image, (4, 4))
    wide_glint = wide.copy()
    wide_glint[0, 0] = 40.0
    expected = thickness_frame(_clouds(tmp_path, wide, method="coverage", coverage=0.2))
    actual = thickness_frame(_clouds(tmp_path, wide_glint, method="coverage", coverage=0.2))
    np.testing.assert_allclose(actual[:-1], expected[:-1], rtol=0.01)


@pytest.mark.parametrize("coverage", [0.0, 0.1, 0.37, 1.0])
def test_coverage_is_exact_when_asked_for(tmp_path, coverage):
    image = np.random.default_rng(1).normal(size=(50, 70))
    clouds = _clouds(tmp_path, image, size=(20, 30), method="coverage", coverage=coverage)
    assert abs(np.count_nonzero(thickness_frame(clouds)) - coverage * 600) <= 0.5
    assert clouds.image_coverage == np.count_nonzero(thickness_frame(clouds)) / 600


def test_coverage_that_is_not_used_is_said(tmp_path):
    image, cloud = _image()
    notes = " ".join(_clouds(tmp_path, image, coverage=0.77).declares.notes)
    assert f"{cloud.mean():.4g} of the scene's visible pixels are cloudy" in notes
    assert "0.77, is not used" in notes
    notes = " ".join(_clouds(tmp_path, image, coverage=0.2, method="coverage").declares.notes)
    assert "0.2 was requested" in notes


def test_dark_clouds_are_the_negative_of_bright_ones(tmp_path):
    image, cloud = _image()
    bright = thickness_frame(_clouds(tmp_path, image))
    dark = thickness_frame(_clouds(tmp_path, 1.0 - image, cloud_is="dark"))
    np.testing.assert_allclose(dark, bright, rtol=1e-5)
    assert np.array_equal(thickness_frame(_clouds(tmp_path, image, cloud_is="dark")) > 0, ~cloud[::-1])


def test_crop_starts_at_the_origin_counted_as_stored(tmp_path):
    image = np.random.default_rng(2).gamma(1.5, 0.1, (ROWS, COLUMNS))
    whole = thickness_frame(_clouds(tmp_path, image))[::-1]
    given = thickness_frame(_clouds(tmp_path, image, size=(10, 20), row_origin=3, column_origin=31))[::-1]
    np.testing.assert_array_equal(given, whole[3:13, 31:51])
    centred = thickness_frame(_clouds(tmp_path, image, size=(10, 20)))[::-1]
    np.testing.assert_array_equal(centred, whole[15:25, 20:40])


def test_clouds_drift_with_the_wind_and_against_the_platform(tmp_path):
    image = np.random.default_rng(3).gamma(1.5, 0.1, (ROWS, COLUMNS))
    whole = thickness_frame(_clouds(tmp_path, image))
    clouds = _clouds(tmp_path, image, size=(20, 20), platform=700.0, wind=(200.0, 100.0))
    start = thickness_frame(clouds)
    np.testing.assert_array_equal(start, whole[10:30, 20:40])
    # 10 s: 5 pixels east of the start, clouds 1 pixel further north.
    later = thickness_frame(clouds, 10.0)
    np.testing.assert_array_equal(later, whole[9:29, 25:45])
    np.testing.assert_array_equal(later[1:, :-5], start[:-1, 5:])
    # Less than half a pixel is none.
    np.testing.assert_array_equal(thickness_frame(clouds, 0.9), start)


def test_platform_that_follows_the_wind_sees_no_motion(tmp_path):
    image, _ = _image()
    clouds = _clouds(tmp_path, image, platform=10.0, wind=(10.0, 0.0))
    assert clouds.declares.depends_on == frozenset()
    np.testing.assert_array_equal(thickness_frame(clouds, 1e6), thickness_frame(clouds))


@pytest.mark.parametrize(
    ("platform", "wind", "axis", "last"),
    [
        (1000.0, (0.0, 0.0), "columns", 20.5),
        (-1000.0, (0.0, 0.0), "columns", 20.5),
        (0.0, (0.0, 500.0), "rows", 21.0),
        (0.0, (0.0, -500.0), "rows", 21.0),
    ],
)
def test_footprint_that_leaves_the_image_is_an_error_that_says_when(tmp_path, platform, wind, axis, last):
    image, _ = _image()
    clouds = _clouds(tmp_path, image, size=(20, 20), platform=platform, wind=wind)
    thickness_frame(clouds, last * 0.999)
    with pytest.raises(ScenarioError, match=rf"motion: at .* of its 20 {axis}; allowed: less than {last:g} s"):
        thickness_frame(clouds, last * 1.001)


def test_windows_outside_the_image_and_times_that_are_none_are_refused(tmp_path):
    image = np.random.default_rng(4).gamma(1.5, 0.1, (ROWS, COLUMNS))
    clouds = _clouds(tmp_path, image, size=(30, 40), platform=100.0)
    with pytest.raises(ValueError, match="inside 0 to 30"):
        clouds.thickness_m(0.0, slice(0, 31), slice(0, 5))
    with pytest.raises(ValueError, match="any finite time"):
        thickness_frame(clouds, np.nan)


def test_missing_pixels_are_an_error_unless_called_clear(tmp_path):
    image, cloud = _image()
    image[6, 12:15] = np.nan
    with pytest.raises(ScenarioError, match=r"3 of the 2400 pixels .* missing = \"clear\""):
        _clouds(tmp_path, image)
    clouds = _clouds(tmp_path, image, missing="clear")
    cloud[6, 12:15] = False
    assert np.array_equal(thickness_frame(clouds) > 0, cloud[::-1])
    assert any("3 pixels of the scene are missing" in note for note in clouds.declares.notes)


def test_missing_pixels_outside_the_scene_do_not_matter_until_they_come_in(tmp_path):
    image, _ = _image()
    image[:, 45] = np.nan
    clouds = _clouds(tmp_path, image, size=(40, 20), platform=1000.0)
    thickness_frame(clouds, 5.0)
    with pytest.raises(ScenarioError, match="40 of the 800 pixels of the scene at 6 s"):
        thickness_frame(clouds, 6.0)


def test_all_that_does_not_fit_is_said_at_once(tmp_path):
    image, _ = _image()
    with pytest.raises(ScenarioError) as caught:
        _clouds(tmp_path, image, size=(800, 20), column_origin=41)
    text = str(caught.value)
    assert re.search(r"image\.rows: 800 .*closest is 40", text)
    assert re.search(r"column_origin: 41 .*allowed: 0 to 40, closest is 40", text)


def test_coverage_is_of_the_visible_pixels_and_the_missing_ones_are_counted(tmp_path):
    image = np.random.default_rng(6).uniform(size=_image()[0].shape)  # without equal levels
    image[:4] = -9999.0  # a fill value that the file does not declare
    whole = (slice(0, image.shape[0]), slice(0, image.shape[1]))
    clouds = _clouds(tmp_path, image, missing="clear", method="coverage", coverage=0.1)
    cloudy = clouds.thickness_m(0.0, *whole) > 0.0
    assert np.count_nonzero(cloudy) == pytest.approx(0.1 * image[4:].size, abs=0.5)
    notes = " ".join(clouds.declares.notes)
    assert "0.1 of the scene's visible pixels are cloudy" in notes
    fill = f"-9999 ({image[:4].size} pixels) is far from the rest"
    assert fill in notes
    with pytest.raises(ScenarioError, match=rf"missing in the image \({re.escape(fill)}"):
        _clouds(tmp_path, image, method="coverage", coverage=0.1)


def test_file_is_recorded_and_a_missing_one_named(tmp_path):
    image, _ = _image()
    catalog = Catalog(base=tmp_path)
    _clouds(tmp_path, image, catalog=catalog)
    assert [key.rsplit("/", 1)[-1] for key in catalog.used] == ["image.npy"]
    with pytest.raises(CatalogError, match=r"no file 'image\.npy'"):
        _clouds(tmp_path, image, catalog=Catalog(base=tmp_path / "elsewhere"))


@pytest.mark.parametrize(
    "wrong",
    [
        {},
        {"image": ""},
        {"image": "a", "method": "watershed"},
        {"image": "a", "window_pixels": 2},
        {"image": "a", "row_origin": -1},
        {"image": "a", "threshold": 3},
    ],
)
def test_parameters_out_of_range_are_refused(wrong):
    with pytest.raises(ValidationError):
        ImageryParameters(**wrong)


@pytest.mark.parametrize("beyond", ["clear", "mirror"])
def test_around_the_scene_is_the_rest_of_the_image_and_beyond_it_what_is_said(tmp_path, beyond):
    image = np.random.default_rng(0).gamma(1.5, 0.1, (ROWS, COLUMNS))
    given = {"size": (12, 10), "row_origin": 6, "column_origin": 40, "wind": (-3000.0, -2000.0)}
    clouds = _clouds(tmp_path, image, beyond=beyond, **given)
    whole = thickness_frame(_clouds(tmp_path, image))
    modes = {"clear": {"mode": "constant"}, "mirror": {"mode": "symmetric"}}
    padded = np.pad(whole, 100, **modes[beyond])
    for time_s in (0.0, 2.0):
        # The scene moves against the wind, to the east and north; rows of the file run southward.
        south, west = ROWS - 12 - 6 + int(2 * time_s), 40 + int(3 * time_s)
        around = clouds.thickness_around_m(time_s, slice(-70, 80), slice(-90, 85))
        expected = padded[100 + south - 70 : 100 + south + 80, 100 + west - 90 : 100 + west + 85]
        np.testing.assert_array_equal(around, expected)
        inside = clouds.thickness_m(time_s, slice(0, 12), slice(0, 10))
        np.testing.assert_array_equal(inside, around[70:82, 90:100])


def test_what_is_beyond_an_image_is_not_known_unless_said(tmp_path):
    image, _ = _image()
    assert not hasattr(_clouds(tmp_path, image), "thickness_around_m")


def test_missing_pixels_around_the_scene_are_an_error_only_where_they_are_met(tmp_path):
    image, _ = _image()
    image[:, 20] = np.nan
    clouds = _clouds(tmp_path, image, size=(ROWS, 15), column_origin=0, beyond="clear")
    clouds.thickness_around_m(0.0, slice(-5, 5), slice(-5, 20))
    with pytest.raises(ScenarioError, match=r"clouds.parameters.missing: 10 of the 260 pixels .* are missing"):
        clouds.thickness_around_m(0.0, slice(0, 10), slice(-5, 21))
