"""Laws of single clouds scattered over an unbounded sky: coverage, windows, motion, orientations."""

from __future__ import annotations

import dataclasses
import itertools
import math

import numpy as np
import pytest
from hcss_evaluate.database.cloud_import import ImportOptions, import_image
from hcss_evaluate.database.segmentation import Cleaning
from pydantic import ValidationError
from scipy.stats import kstest
from whole_frames import thickness_frame

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import CatalogError, ScenarioError
from hcss_twin.models.clouds.database import CloudEntry
from hcss_twin.models.clouds.imagery.generator import ImageryClouds, ScatteredClouds
from hcss_twin.models.clouds.imagery.parameters import ImageryParameters
from hcss_twin.models.clouds.imagery.sky import Sky, single_clouds
from hcss_twin.providers import CloudInputs, CloudLayer, Grid, Microphysics, Motion

THINNEST, THICKEST = 100.0, 2000.0
LAYER = CloudLayer(
    "test",
    1000.0,
    1000.0 + THICKEST,
    "base",
    THINNEST,
    0.4,
    None,
    Microphysics("water", 6.0, 1.5, 1.0, 1e8, (0.1, 50.0)),
    coverage_mode="field",
)

# Three whole clouds of different shape, one that the border cuts and one beside a missing pixel.
DRAWN = np.zeros((50, 60))
DRAWN[5:9, 5:12] = 1.0
DRAWN[20:30, 10:13] = DRAWN[20:23, 13:20] = 0.6
DRAWN[35:37, 40:42] = 0.8
DRAWN[10:20, 50:60] = 0.9
DRAWN[40:45, 20:25] = 0.7
AREAS = (28, 51, 4)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A scenario's folder with the entry ``drawn``."""
    base = tmp_path_factory.mktemp("scenario")
    image = DRAWN + 0.001 * np.random.default_rng(0).random(DRAWN.shape) + 0.05 * (DRAWN > 0) * _ramp()
    image[42, 25] = np.nan
    np.save(base / "image.npy", image)
    options = ImportOptions(pixel_size_m=1000.0, cleaning=Cleaning(1, 1, 0, 1))
    (base / "clouds").mkdir()
    import_image(base / "image.npy", options).write(base / "clouds" / "drawn.nc")
    return base


def _ramp():
    return np.linspace(0, 1, DRAWN.size).reshape(DRAWN.shape)


def _inputs(folder, *, size=(40, 50), seed=0, motion=None, **layer):
    return CloudInputs(
        layer=dataclasses.replace(LAYER, **layer),
        grid=Grid(*size, 1000.0),
        motion=motion or Motion(0.0, (0.0, 0.0), math.inf, 1.0),
        seed=seed,
        catalog=Catalog(base=folder),
    )


def _parameters(**options):
    return ImageryParameters(**{"entry": "drawn", "placement": "single-clouds", **options})


def _clouds(folder, *, parameters=None, **inputs):
    return ImageryClouds(_inputs(folder, **inputs), _parameters(**(parameters or {})))


def _scattered(folder, **inputs):
    """The same clouds, which have windows anywhere in the plane and not only in the scene."""
    return ScatteredClouds(_inputs(folder, **inputs), _parameters(), folder / "clouds" / "drawn.nc")


def _sky(folder, seed=0, turned=True):
    clouds = single_clouds(CloudEntry.read(folder / "clouds" / "drawn.nc"), THINNEST, THICKEST)
    return Sky(clouds, seed, turned), clouds


def test_only_whole_clouds_are_taken_and_each_is_what_it_was(folder):
    _, clouds = _sky(folder)
    assert sorted(clouds.areas) == sorted(AREAS)
    assert clouds.left_out == 2
    for number in range(3):
        height, width = clouds.heights[number], clouds.widths[number]
        shape = clouds.thickness_m[clouds.starts[number] :][: height * width].reshape(height, width)
        assert np.count_nonzero(shape) == clouds.areas[number]
        assert shape.any(axis=0).all()
        assert shape.any(axis=1).all()
    # Rows run northward: the L stands on its head in the stored image.
    tall = next(n for n in range(3) if clouds.areas[n] == 51)
    shape = clouds.thickness_m[clouds.starts[tall] :][:100].reshape(10, 10) > 0
    np.testing.assert_array_equal(shape, DRAWN[20:30, 10:20][::-1] > 0)


@pytest.mark.parametrize(("coverage", "turned"), [(0.1, True), (0.4, False), (0.8, True), (0.8, False), (0.97, True)])
def test_expected_coverage_is_the_asked_one(folder, coverage, turned):
    sky, _ = _sky(folder, seed=7, turned=turned)
    density = sky.density(coverage)
    # The closed form of the Boolean model.
    assert 1.0 - math.exp(-density * np.mean(AREAS)) == pytest.approx(coverage, rel=1e-12)
    # Windows far from each other are independent.
    shares = []
    for number in range(200):
        row, column = 1000 * number, -700 * number
        window = sky.thickness_m(slice(row, row + 60), slice(column, column + 60), density)
        shares.append(np.mean(window > 0))
    error = np.std(shares) / math.sqrt(len(shares))
    assert abs(np.mean(shares) - coverage) < 4.0 * error
    assert error < 0.01


def test_two_pixels_are_clear_together_as_in_a_boolean_model(folder):
    sky, clouds = _sky(folder, seed=3, turned=False)
    density = sky.density(0.5)
    clear = sky.thickness_m(slice(0, 2500), slice(0, 2500), density) == 0
    for lag in (1, 3, 8):
        measured = np.mean(clear[:, lag:] & clear[:, :-lag])
        # P = exp(-density x mean area of the union of a cloud and its shifted copy).
        unions = []
        for n in range(3):
            shape = clouds.thickness_m[clouds.starts[n] :][: clouds.heights[n] * clouds.widths[n]]
            shape = np.pad(shape.reshape(clouds.heights[n], clouds.widths[n]) > 0, ((0, 0), (0, lag)))
            unions.append(np.count_nonzero(shape | np.roll(shape, lag, axis=1)))
        assert measured == pytest.approx(math.exp(-density * np.mean(unions)), abs=0.01)


def test_places_shapes_turns_and_arrivals_are_uniform(folder):
    sky, _ = _sky(folder, seed=11)
    layer_density = sky.density(0.5)  # every layer of arrivals covers half of the sky
    placed = sky.placed(slice(0, 1500), slice(0, 1500), 0)
    count = placed.y.size
    assert count > 20_000
    inside = (placed.y >= 0) & (placed.y < 1500) & (placed.x >= 0) & (placed.x < 1500)
    expected = 1500**2 * layer_density
    assert abs(np.count_nonzero(inside) - expected) < 4.0 * math.sqrt(expected)
    for values, kinds in ((placed.shape, 3), (placed.turn, 8)):
        counts = np.bincount(values, minlength=kinds)
        assert np.abs(counts - count / kinds).max() < 4.5 * math.sqrt(count / kinds)
    for values in (placed.y[inside] / 1500, placed.x[inside] / 1500, placed.arrival / layer_density):
        assert kstest(values + 1e-4, "uniform").pvalue > 1e-3


def test_eight_orientations_and_no_other_shape(folder):
    _, clouds = _sky(folder)
    clouds = dataclasses.replace(
        clouds, **{name: getattr(clouds, name)[1:2].copy() for name in ("starts", "heights", "widths", "areas")}
    )
    sky = Sky(clouds, 5, True)
    height, width = int(clouds.heights[0]), int(clouds.widths[0])
    shape = clouds.thickness_m[clouds.starts[0] :][: height * width].reshape(height, width)
    known = {np.rot90(part, turns).tobytes() for part in (shape, shape.T) for turns in range(4)}
    found = set()
    # So thin a sky that clouds rarely meet.
    density = sky.density(0.01)
    placed = sky.placed(slice(0, 3000), slice(0, 3000), 0)
    field = sky.thickness_m(slice(0, 3100), slice(0, 3100), density)
    for n in np.flatnonzero((placed.arrival < density) & (placed.y >= 0) & (placed.x >= 0)):
        tall, wide = (width, height) if placed.turn[n] & 4 else (height, width)
        part = field[placed.y[n] : placed.y[n] + tall, placed.x[n] : placed.x[n] + wide]
        if np.count_nonzero(part) == clouds.areas[0]:
            found.add(part.tobytes())
    assert known <= found
    assert len(known) == 8


def test_the_thickest_of_overlapping_clouds_counts(folder):
    sky, clouds = _sky(folder, seed=2)
    density = sky.density(0.9)
    field = sky.thickness_m(slice(0, 80), slice(0, 90), density)
    expected = np.zeros((80, 90), dtype=np.float32)
    for layer in range(10):
        placed = sky.placed(slice(0, 80), slice(0, 90), layer)
        for n in np.flatnonzero(placed.arrival < density):
            start, height, width = (getattr(clouds, name)[placed.shape[n]] for name in ("starts", "heights", "widths"))
            shape = clouds.thickness_m[start : start + height * width].reshape(height, width)
            shape = shape[:: -1 if placed.turn[n] & 1 else 1, :: -1 if placed.turn[n] & 2 else 1]
            shape = shape.T if placed.turn[n] & 4 else shape
            for (i, j), value in np.ndenumerate(shape):
                y, x = placed.y[n] + i, placed.x[n] + j
                if 0 <= y < 80 and 0 <= x < 90:
                    expected[y, x] = max(expected[y, x], value)
    np.testing.assert_array_equal(field, expected)


def test_more_coverage_only_adds_cloud(folder):
    fields = [thickness_frame(_clouds(folder, coverage=coverage)) for coverage in (0.0, 0.2, 0.5, 0.7, 0.99)]
    for thin, dense in itertools.pairwise(fields):
        assert np.all(dense >= thin)
        assert np.any(dense > thin)


def test_coverage_0_is_clear_and_coverage_1_has_no_gap(folder):
    assert not thickness_frame(_clouds(folder, coverage=0.0)).any()
    overcast = _clouds(folder, coverage=1.0)
    assert np.all(thickness_frame(overcast) == thickness_frame(overcast).max())
    assert any("limit of infinitely many" in note for note in overcast.declares.notes)


@pytest.mark.parametrize("corner", [(0, 0), (10**9, -(10**9)), (-(2**59), 2**59)])
def test_windows_agree_bit_for_bit_wherever_they_lie(folder, corner):
    clouds = _scattered(folder, coverage=0.6, seed=4)
    row, column = corner
    whole = clouds.field(slice(row, row + 90), slice(column, column + 70))
    assert 0 < np.count_nonzero(whole) < whole.size
    # Narrow ones at every place relative to the cells in which clouds are drawn.
    narrow = [(0, 90, left, left + 1) for left in range(70)] + [(top, top + 1, 0, 70) for top in range(90)]
    for top, bottom, left, right in ((13, 14, 5, 66), (50, 90, 31, 70), (7, 7, 0, 70), *narrow):
        part = clouds.field(slice(row + top, row + bottom), slice(column + left, column + right))
        np.testing.assert_array_equal(part, whole[top:bottom, left:right])


@pytest.mark.parametrize("mode", ["field", "frame"])
def test_around_the_image_is_the_same_sky(folder, mode):
    """Twelve rows and columns more on each side of the first frame are the second one, which the motion brings in."""
    motion = Motion(0.0, (-20_000.0, -12_000.0), math.inf, 1.0)
    clouds = _clouds(folder, motion=motion, coverage_mode=mode)
    around = clouds.thickness_around_m(0.0, slice(-12, 52), slice(-20, 70))
    for time_s in (-1.0, 0.0, 1.0):
        down, right = 12 + int(12 * time_s), 20 + int(20 * time_s)
        frame = clouds.thickness_m(time_s, slice(0, 40), slice(0, 50))
        np.testing.assert_array_equal(frame, around[down : down + 40, right : right + 50])
    assert around.any()


def test_windows_too_far_out_to_count_are_refused(folder):
    clouds = _clouds(folder, motion=Motion(1e30, (0.0, 0.0), math.inf, 1.0))
    with pytest.raises(ScenarioError, match=r"motion: at 1 s the scene is .* pixels away"):
        thickness_frame(clouds, 1.0)
    with pytest.raises(ValueError, match=r"rows: .* allowed: -2"):
        _scattered(folder).field(slice(2**61, 2**61 + 1), slice(0, 1))


def test_push_broom_sees_the_same_bits_again(folder):
    clouds = _clouds(folder, size=(30, 60), motion=Motion(3000.0, (0.0, -2000.0), math.inf, 1.0), seed=9)
    start = thickness_frame(clouds)
    later = thickness_frame(clouds, 4.0)
    np.testing.assert_array_equal(later[:-8, :-12], start[8:, 12:])
    # It goes on for ever, and back: 3e9 pixels from here.
    far = thickness_frame(clouds, 1e9)
    np.testing.assert_array_equal(thickness_frame(clouds, 1e9 + 4.0)[:-8, :-12], far[8:, 12:])
    assert 0.2 < np.mean(far > 0) < 0.6
    assert np.any(thickness_frame(clouds, -1e6) > 0)
    assert clouds.declares.depends_on == {"time"}


def test_frame_mode_comes_closest_in_the_first_frame(folder):
    for coverage in (0.003, 0.2, 0.5, 0.95):
        clouds = _clouds(folder, coverage=coverage, coverage_mode="frame", seed=6)
        found = np.mean(thickness_frame(clouds) > 0)
        # One cloud more or less makes at most 51 pixels of 2000.
        assert abs(found - coverage) <= 0.5 * 51 / 2000
        assert any(f"{found:.4g} of the first frame's pixels" in note for note in clouds.declares.notes)
    assert clouds.image_coverage is None


def test_frame_mode_is_the_best_of_all_densities(folder):
    clouds = _clouds(folder, coverage=0.35, coverage_mode="frame", seed=8)
    best = abs(np.mean(thickness_frame(clouds) > 0) - 0.35)
    sky, _ = _sky(folder, seed=8)
    for density in np.linspace(0.0, 4.0 * sky.density(0.35), 400):
        window = sky.thickness_m(slice(0, 40), slice(0, 50), density)
        assert abs(np.mean(window > 0) - 0.35) >= best - 1e-12


def test_clouds_can_be_chosen_by_size(folder):
    clouds = _clouds(folder, coverage=0.01, parameters={"cloud_pixels": [4, 30]})
    assert "2 clouds of 4 to 28 pixels" in clouds.declares.notes[0]
    with pytest.raises(ScenarioError, match=r"cloud_pixels: \[100, 200\] given; allowed: a range that meets 4 to 51"):
        _clouds(folder, parameters={"cloud_pixels": [100, 200]})


def test_a_cloud_that_will_be_seen_again_and_again_is_said(folder):
    assert any("One cloud makes up 61%" in note for note in _clouds(folder).declares.notes)


def test_an_image_whose_clouds_are_all_cut_is_refused(tmp_path):
    image = np.zeros((40, 40))
    image[:, :10] = 1.0
    np.save(tmp_path / "image.npy", image)
    (tmp_path / "clouds").mkdir()
    entry = import_image(tmp_path / "image.npy", ImportOptions(pixel_size_m=1000.0))
    entry.write(tmp_path / "clouds" / "drawn.nc")
    with pytest.raises(CatalogError, match="cut all 1 clouds"):
        _clouds(tmp_path)


# --- whole scenes from entries ----------------------------------------------------------


def test_the_whole_scene_of_an_entry_is_that_of_its_image(folder):
    whole = {"placement": "scene", "missing": "clear"}
    entry = thickness_frame(_clouds(folder, size=DRAWN.shape, parameters=whole))
    inputs = CloudInputs(
        LAYER, Grid(*DRAWN.shape, 1000.0), Motion(0.0, (0.0, 0.0), math.inf, 1.0), 0, Catalog(base=folder)
    )
    image = thickness_frame(ImageryClouds(inputs, ImageryParameters(image="image.npy", missing="clear")))
    np.testing.assert_array_equal(entry > 0, image > 0)
    # An entry has 255 grey levels.
    assert np.abs(entry - image).max() <= 0.5 / 254 * (THICKEST - THINNEST) + 1e-3
    np.testing.assert_array_equal(entry[::-1] > 0, DRAWN > 0)


def test_missing_pixels_of_an_entry_are_an_error_unless_called_clear(folder):
    with pytest.raises(ScenarioError, match="1 of the 3000 pixels"):
        _clouds(folder, size=DRAWN.shape, parameters={"placement": "scene"})


def test_a_whole_scene_ends_where_its_image_ends(folder):
    motion = Motion(1000.0, (0.0, 0.0), math.inf, 1.0)
    clouds = _clouds(
        folder, size=(20, 20), motion=motion, parameters={"placement": "scene", "column_origin": 0, "row_origin": 0}
    )
    np.testing.assert_array_equal(thickness_frame(clouds, 7.0)[::-1] > 0, DRAWN[:20, 7:27] > 0)
    with pytest.raises(ScenarioError, match="lies outside the image"):
        thickness_frame(clouds, 41.0)


# --- what does not fit ------------------------------------------------------------------


def test_an_entry_is_found_by_name_beside_the_scenario_and_recorded(folder):
    catalog = Catalog(base=folder)
    found = catalog.find("drawn", "clouds", ".nc", beside=True)
    assert found == folder / "clouds" / "drawn.nc"
    assert list(catalog.used) == [str(found.resolve())]
    assert catalog.find("clouds/drawn.nc", "clouds", ".nc", beside=True) == found
    with pytest.raises(CatalogError, match=r"'dawn' is neither in .*; allowed: drawn, .*; closest is 'drawn'"):
        catalog.find("dawn", "clouds", ".nc", beside=True)
    with pytest.raises(CatalogError):
        catalog.find("drawn", "clouds", ".nc")


def test_other_pixels_are_refused_unless_accepted(folder):
    inputs = CloudInputs(LAYER, Grid(20, 20, 20.0), Motion(0.0, (0.0, 0.0), math.inf, 1.0), 0, Catalog(base=folder))
    with pytest.raises(ScenarioError, match=r"image\.pixel_size: 20 m differs"):
        ImageryClouds(inputs, ImageryParameters(entry="drawn", placement="single-clouds"))
    parameters = ImageryParameters(entry="drawn", placement="single-clouds", reinterpret_pixel_size=True)
    assert any("taken for pixels of 20 m" in note for note in ImageryClouds(inputs, parameters).declares.notes)


def test_an_edge_taper_is_refused_because_images_have_their_own_edges(folder):
    with pytest.raises(ScenarioError, match=r"clouds\.edge_taper: 0\.2 given"):
        _clouds(folder, edge_taper=0.2)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({}, "image, entry: neither given"),
        ({"image": "a", "entry": "b"}, "image, entry: both given"),
        ({"image": "a", "placement": "single-clouds"}, "needs an entry"),
        ({"entry": "a", "method": "otsu"}, "method: has no meaning with an entry"),
        ({"entry": "a", "variable": "CMI", "cloud_is": "dark"}, "variable, cloud_is: has no meaning"),
        ({"entry": "a", "placement": "single-clouds", "row_origin": 3}, "row_origin: has no meaning"),
        ({"entry": "a", "turned": False}, "turned: has no meaning without"),
        ({"entry": "a", "cloud_pixels": [1, 5]}, "cloud_pixels: has no meaning without"),
        ({"entry": "a", "placement": "single-clouds", "cloud_pixels": [9, 5]}, "closest is .5, 9"),
    ],
)
def test_parameters_that_would_be_ignored_are_refused(wrong, message):
    with pytest.raises(ValidationError, match=message):
        ImageryParameters(**wrong)
