"""Entries: what an import finds in an image whose clouds are known, and the file they live in."""

from __future__ import annotations

import dataclasses
import hashlib

import netCDF4
import numpy as np
import pytest
import xarray as xr
from hcss_evaluate.database.cloud_import import ImportOptions, import_image
from hcss_evaluate.database.folder import entry_path, list_entries, valid_entry_name
from hcss_evaluate.database.segmentation import Cleaning

from hcss_twin.core.errors import CatalogError
from hcss_twin.models.clouds.database import CloudEntry

PLAIN = Cleaning(closing=1, opening=1, largest_hole=0, min_area=1)


def _picture():
    """A sea at 20 with three clouds, one with a hole of 4 pixels, and a missing pixel."""
    values = np.full((60, 80), 20.0) + np.random.default_rng(0).normal(0, 1, (60, 80))
    cloud = np.zeros(values.shape, dtype=bool)
    cloud[5:25, 10:40] = cloud[35:45, 50:75] = cloud[50:53, 5:9] = True
    cloud[10:12, 20:22] = False
    values[cloud] += np.random.default_rng(1).uniform(120, 200, cloud.sum())
    values[58, 70] = np.nan
    return values, cloud


@pytest.fixture
def image(tmp_path):
    np.save(tmp_path / "clouds.npy", _picture()[0])
    return tmp_path / "clouds.npy"


def _entry(image, **options):
    return import_image(image, ImportOptions(pixel_size_m=1000.0, **options))


def _attribute(path, name, value):
    with netCDF4.Dataset(path, "a") as file:
        file.setncattr(name, value)


def test_import_of_temperatures_says_which_share_of_cold_cloud_it_loses(tmp_path):
    kelvin = np.full((40, 40), 290.0)
    kelvin[:10], kelvin[10:20] = 220.0, 285.0  # opaque and thin cloud
    xr.Dataset({"t": (("y", "x"), kelvin, {"units": "K"})}).to_netcdf(tmp_path / "image.nc")
    taken_for, note = _entry(tmp_path / "image.nc", cleaning=PLAIN).notes
    assert "brightness temperature in kelvin" in taken_for
    assert note.startswith("50.00% of the pixels that are 2 K colder than clear sky (290 K) are left out as clear")


def test_import_finds_the_clouds_that_were_drawn(image):
    _, cloud = _picture()
    entry = _entry(image, cleaning=PLAIN)
    np.testing.assert_array_equal(entry.mask, cloud)
    assert entry.facts.clouds == 3
    assert entry.facts.coverage == np.count_nonzero(cloud) / (cloud.size - 1)  # of the visible pixels
    assert entry.facts.missing_pixels == 1
    assert np.argwhere(entry.missing).tolist() == [[58, 70]]
    filled = _entry(image, cleaning=Cleaning(largest_hole=100))
    np.testing.assert_array_equal(filled.mask[10:12, 20:22], True)
    assert (filled.facts.holes_filled, filled.facts.hole_pixels) == (1, 4)


def test_grey_levels_rise_with_the_image_from_1_at_the_threshold(image):
    values, cloud = _picture()
    entry = _entry(image, cleaning=PLAIN)
    order = np.argsort(values[cloud])
    assert np.all(np.diff(entry.grey[cloud][order].astype(int)) >= 0)
    assert entry.grey.max() == 255
    top = np.percentile(values[cloud], 99.9)
    low = entry.facts.threshold_lowest
    expected = 1 + 254 * np.clip((values[cloud] - low) / (top - low), 0, 1)
    assert np.abs(entry.grey[cloud] - expected).max() <= 0.5 + 1e-9
    # Clear sky in a filled hole is the thinnest cloud.
    assert set(_entry(image, cleaning=Cleaning(largest_hole=100)).grey[10:12, 20:22].ravel()) == {1}


def test_dark_clouds_give_the_same_entry_with_the_sign_turned(tmp_path, image):
    np.save(tmp_path / "dark.npy", -_picture()[0])
    bright = _entry(image)
    dark = _entry(tmp_path / "dark.npy", cloud_is="dark")
    np.testing.assert_array_equal(dark.labels, bright.labels)
    np.testing.assert_array_equal(dark.grey, bright.grey)
    assert dark.facts.threshold_lowest == pytest.approx(-bright.facts.threshold_lowest)
    assert dark.facts.cloud_is == "dark"


def test_method_coverage_meets_it_before_cleaning(image):
    entry = _entry(image, method="coverage", coverage=0.1, cleaning=PLAIN)
    assert entry.facts.coverage == pytest.approx(0.1, abs=0.5 / 4800)


def test_method_valid_takes_what_has_a_value(tmp_path):
    heights = np.full((40, 50), np.nan)
    heights[5:20, 5:25] = np.linspace(2e3, 9e3, 20)
    np.save(tmp_path / "heights.npy", heights)
    entry = _entry(tmp_path / "heights.npy", method="valid")
    np.testing.assert_array_equal(entry.mask, np.isfinite(heights))
    assert entry.facts.missing_pixels == 0
    assert entry.grey[5, 5] == 1
    assert entry.grey[5, 24] == 255


def test_local_records_its_window_and_the_range_of_thresholds(image):
    facts = _entry(image, method="local", window=15).facts
    assert facts.window_pixels == 15
    assert facts.threshold_lowest <= facts.threshold_highest


def test_what_nobody_states_is_not_stated(image):
    facts = _entry(image).facts
    assert (facts.band, facts.licence, facts.source, facts.observed) == (CloudEntry.NOT_STATED,) * 4
    facts = _entry(image, band="10.8 um", licence="CC0", source="drawn").facts
    assert (facts.band, facts.licence, facts.source) == ("10.8 um", "CC0", "drawn")
    assert facts.source_sha256 == hashlib.sha256(image.read_bytes()).hexdigest()
    assert facts.pixel_size_from == "user"


def test_fractal_dimension_of_cloudy_pixels_is_near_3_for_white_noise(image):
    facts = _entry(image).facts
    # The drawn clouds are white noise.
    assert facts.fractal_dimension == pytest.approx(3.0, abs=0.1)
    assert facts.fractal_dimension_method.startswith("variogram")
    assert 2.0 < facts.box_counting_dimension < 3.0
    assert facts.box_counting_method.startswith("differential box counting")


def test_an_image_too_small_for_a_dimension_says_so(tmp_path):
    np.save(tmp_path / "a.npy", np.pad(np.ones((5, 5)), 5))
    facts = _entry(tmp_path / "a.npy").facts
    assert np.isnan(facts.fractal_dimension)
    assert facts.fractal_dimension_method.startswith("not estimated: ")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"coverage": 0.3}, "coverage: 0.3 given with the method 'otsu'"),
        ({"method": "coverage"}, "coverage: not given"),
        ({"window": 9}, "window: 9 given with the method 'otsu'"),
        ({"method": "local", "window": 1}, "window: 1 given"),
        ({"cleaning": Cleaning(min_area=5000)}, "no cloud of 5000 or more pixels among 858 cloudy ones"),
        ({"method": "coverage", "coverage": 1.5}, "allowed 0 to 1; closest is 1"),
    ],
)
def test_what_cannot_be_is_refused(image, options, message):
    with pytest.raises(CatalogError, match=message):
        _entry(image, **options)


def test_a_pixel_size_is_needed(image):
    with pytest.raises(CatalogError, match=r"gives no pixel size; .*--pixel-size"):
        import_image(image)
    with pytest.raises(CatalogError, match="pixel_size: -1 m given"):
        import_image(image, ImportOptions(pixel_size_m=-1.0))


def test_an_entry_comes_back_as_it_was_written(image, tmp_path):
    entry = _entry(image)
    entry.write(tmp_path / "a.nc")
    back = CloudEntry.read(tmp_path / "a.nc")
    for name in ("grey", "labels", "missing", "image"):
        written, read = getattr(entry, name), getattr(back, name)
        np.testing.assert_array_equal(read, written)
        assert read.dtype == written.dtype
    expected, found = dataclasses.asdict(entry.facts), dataclasses.asdict(back.facts)
    for name, value in expected.items():
        assert found[name] == value or (np.isnan(value) and np.isnan(found[name])), name
    assert CloudEntry.read_facts(tmp_path / "a.nc")[1] == (60, 80)


def test_other_programs_see_where_north_is(image, tmp_path):
    _entry(image).write(tmp_path / "a.nc")
    with xr.open_dataset(tmp_path / "a.nc") as file:
        assert file.y.values[0] == 59_500.0
        assert file.y.values[-1] == 500.0
        assert file.x.values[0] == 500.0
        assert file.mask.attrs["flag_meanings"] == "clear cloud missing"
        np.testing.assert_array_equal(np.unique(file.mask), [0, 1, 2])


def test_a_failed_write_keeps_the_older_file(image, tmp_path, monkeypatch):
    folder = tmp_path / "entries"
    folder.mkdir()
    entry = _entry(image)
    entry.write(folder / "a.nc")
    before = (folder / "a.nc").read_bytes()

    def full(*_arguments):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.fsync", full)
    with pytest.raises(CatalogError, match=r"cannot write .*a\.nc: No space left"):
        entry.write(folder / "a.nc")
    assert [path.name for path in folder.iterdir()] == ["a.nc"]
    assert (folder / "a.nc").read_bytes() == before


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("format", "other", "format 'other' version 1"),
        ("format_version", np.int32(9), "version 9; allowed"),
        ("pixel_size_m", -5.0, "pixel_size_m: -5.0"),
        ("clouds", np.int32(7), "allowed: each number from 1 to 7"),
        ("pixel_size_is_nominal", "perhaps", "pixel_size_is_nominal"),
    ],
)
def test_entries_with_wrong_attributes_are_refused(image, tmp_path, name, value, message):
    _entry(image).write(tmp_path / "a.nc")
    _attribute(tmp_path / "a.nc", name, value)
    with pytest.raises(CatalogError, match=message):
        CloudEntry.read(tmp_path / "a.nc")


@pytest.mark.parametrize("variable", ["grey", "mask"])
def test_entries_that_contradict_themselves_are_refused(image, tmp_path, variable):
    _entry(image).write(tmp_path / "a.nc")
    with netCDF4.Dataset(tmp_path / "a.nc", "a") as file:
        file.variables[variable][0, 0] = 1
    with pytest.raises(CatalogError, match=f"{variable} and label disagree about cloud in 1 pixels"):
        CloudEntry.read(tmp_path / "a.nc")


def test_a_folder_lists_entries_and_what_is_none(image, tmp_path):
    folder = tmp_path / "entries"
    assert list_entries(folder) == []
    folder.mkdir()
    _entry(image).write(folder / "b.nc")
    _entry(image).write(folder / "a.nc")
    (folder / "c.nc").write_bytes(b"nothing")
    listed = list_entries(folder)
    assert [entry.name for entry in listed] == ["a", "b", "c"]
    assert listed[0].facts is not None
    assert listed[0].shape == (60, 80)
    assert "not a readable NetCDF file" in listed[2].trouble
    assert entry_path(folder, "a") == folder / "a.nc"
    with pytest.raises(CatalogError, match=r"no entry 'aa' in .*; allowed: a, b, c; closest is 'a'"):
        entry_path(folder, "aa")


@pytest.mark.parametrize(("name", "closest"), [("a b", "a-b"), ("../x", "x"), (".hidden", "hidden"), ("", "clouds")])
def test_names_are_those_of_plain_files(name, closest):
    with pytest.raises(CatalogError, match=f"closest is '{closest}'"):
        valid_entry_name(name)
    assert valid_entry_name("GOES-16_C03.2") == "GOES-16_C03.2"
