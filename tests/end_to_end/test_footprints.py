"""Laws of pixels that are the mean of several points."""

from functools import partial
from pathlib import Path

import numpy as np
import pytest
from cheap import CHEAP

from hcss_twin import Scenario, ScenarioError, make_plan, simulate
from hcss_twin.models.clouds.fractal.generator import FractalClouds
from hcss_twin.models.clouds.imagery.reader import read_image
from hcss_twin.models.radiance.brightness_temperature import BrightnessTemperature
from hcss_twin.plan.description import describe
from hcss_twin.plan.windows import windows
from hcss_twin.reports.plan_text import plan_text

ROWS, COLUMNS, SIZE = 24, 32, 40.0
BANDS = ["mwir-3.7", "lwir-10.8"]
MEANS = ["radiance", "cloud_thickness", "cloud_layer_thickness", "cloud_optical_thickness", "cloud_fraction"]


@pytest.fixture(scope="module")
def image(tmp_path_factory):
    """Bright bumps on a dark ground, with more pixels than any of the scenes."""
    y, x = np.mgrid[0:130, 0:170]
    values = np.sin(x / 7.3) * np.sin(y / 5.1) + 0.4 * np.sin(x * y / 211.0)
    path = tmp_path_factory.mktemp("image") / "bumps.npy"
    np.save(path, values)
    return path


def layers(kind, image):
    high = {"type": "paper-cirrus", "coverage": 0.4}
    if kind == "whole frames":
        return [
            {"type": "paper-cumulus", "coverage": 0.45, "coverage_mode": "frame"},
            high | {"coverage_mode": "frame"},
        ]
    if kind == "one sky":
        return [
            {"type": "paper-cumulus", "coverage": 0.45, "coverage_mode": "field"},
            high | {"coverage_mode": "field"},
        ]
    parameters = {"image": str(image), "method": "coverage", "cloud_is": "bright"}
    low = {"type": "paper-cumulus", "coverage": 0.45, "generator": "imagery", "parameters": parameters}
    return [low] if kind == "windows" else [low, high]


def scenario(clouds, samples=1, rows=ROWS, columns=COLUMNS, size=SIZE, **overrides):
    raw = {
        "time": "2024-04-20T12:30:00+10:00",
        "place": {"latitude": 35.0, "longitude": 150.0},
        "image": {"rows": rows, "columns": columns, "pixel_size": size, "samples_per_pixel": samples},
        "frames": {"count": 2},
        "motion": {"wind_speed": 0.0, "platform_speed": 40.0},
        "bands": BANDS,
        "atmosphere": {"profile": "us-standard-1976"},
        "clouds": {"layers": clouds},
        "sea": {"temperature": 291.4, "wind_speed": 10.0},
        "output": {"variables": ["all", "cloud_layer_thickness"] if clouds else ["all"], "certificate": 0},
    }
    return Scenario.from_dict(raw, {**CHEAP, **overrides})


def blocks(values, samples):
    *others, rows, columns = values.shape
    shape = (*others, rows // samples, samples, columns // samples, samples)
    return values.astype(np.float64).reshape(shape)


@pytest.fixture(scope="module", params=["windows", "whole frames", "both", "one sky"])
def pair(request, image):
    """A cube of pixels of n x n points, and one whose pixels are those points."""
    samples = 3 if request.param == "both" else 2
    clouds = layers(request.param, image)
    coarse = simulate(scenario(clouds, samples))
    fine = simulate(scenario(clouds, 1, ROWS * samples, COLUMNS * samples, SIZE / samples))
    return coarse, fine, samples


@pytest.mark.parametrize("name", MEANS)
def test_a_pixel_is_the_mean_of_its_points(pair, name):
    coarse, fine, samples = pair
    expected = blocks(fine[name].values, samples).mean(axis=(-3, -1))
    np.testing.assert_allclose(coarse[name], expected, rtol=3e-7)
    assert len(np.unique(coarse.cloud_fraction)) > 3  # there are mixed pixels


def test_terms_of_a_pixel_are_means_too_and_sum_to_the_total(pair):
    coarse, fine, samples = pair
    terms = [name for name in coarse if name.startswith("radiance_")]
    for name in terms:
        expected = blocks(fine[name].values, samples).mean(axis=(-3, -1))
        np.testing.assert_allclose(coarse[name], expected, rtol=3e-7, atol=1e-12)
    np.testing.assert_allclose(sum(coarse[name].astype(np.float64) for name in terms), coarse.radiance, rtol=3e-7)


def test_the_mask_is_where_any_point_is_cloudy(pair):
    coarse, fine, samples = pair
    np.testing.assert_array_equal(coarse.cloud_mask, blocks(fine.cloud_mask.values, samples).max(axis=(-3, -1)))
    np.testing.assert_array_equal(coarse.cloud_mask, coarse.cloud_fraction > 0)


@pytest.mark.parametrize("name", ["cloud_top_altitude", "cloud_top_temperature"])
def test_cloud_tops_are_means_over_the_cloudy_points(pair, name):
    coarse, fine, samples = pair
    points = blocks(fine[name].values, samples)
    count = np.isfinite(points).sum(axis=(-3, -1))
    expected = np.where(count > 0, np.nansum(points, axis=(-3, -1)) / np.maximum(count, 1), np.nan)
    np.testing.assert_allclose(coarse[name], expected, rtol=3e-7)


def test_brightness_temperature_is_that_of_the_mean_radiance(pair):
    coarse, fine, samples = pair
    plan = make_plan(scenario([]))
    inverse = BrightnessTemperature(plan.spectral_grid, BANDS)
    np.testing.assert_array_equal(coarse.brightness_temperature[0], inverse(coarse.radiance[0].values))
    mean_of_points = blocks(fine.brightness_temperature.values, samples).mean(axis=(-3, -1))
    assert np.abs(coarse.brightness_temperature.values - mean_of_points).max() > 0.1


def test_coordinates_are_those_of_the_pixels(pair):
    coarse, fine, samples = pair
    for axis in ("x", "y"):
        np.testing.assert_allclose(coarse[axis], fine[axis].values.reshape(-1, samples).mean(axis=1), atol=1e-9)
    np.testing.assert_allclose(coarse.footprint_latitude, fine.footprint_latitude, rtol=1e-12)


@pytest.mark.parametrize(("samples", "coverage"), [(2, 1.0), (3, 0.0), (7, 1.0)])
def test_more_points_of_a_homogeneous_scene_give_the_same_numbers(samples, coverage):
    clouds = [{"type": "paper-stratus", "coverage": coverage, "thickness_min": 967.0}]
    small = {"rows": 4, "columns": 5, "frames.count": 1}
    one, many = (simulate(scenario(clouds, n, **small)) for n in (1, samples))
    for name in one.data_vars:
        np.testing.assert_allclose(many[name], one[name], rtol=1.2e-7)  # a bit of single precision
    np.testing.assert_array_equal(many.cloud_fraction, coverage)


@pytest.mark.parametrize("kind", ["both", "one sky"])
def test_windows_of_any_size_give_the_same_cube(image, kind):
    # Few pixels, as windows of one point are as many; of two rows where 30 points fit.
    asked = scenario(layers(kind, image), 2, 7, 9)
    whole = simulate(asked)
    for most_points in (1, 30, 100):
        # A patch of its own, by which no analysis of the scene changes: it is made once.
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr("hcss_twin.engine.stream.windows", partial(windows, most_points=most_points))
            pieces = simulate(asked)
        for name in whole.data_vars:
            np.testing.assert_array_equal(pieces[name], whole[name])


@pytest.mark.parametrize("coverage", [0.01, 0.37, 0.9])
def test_coverage_by_frame_is_exact_over_all_points(coverage):
    clouds = [{"type": "paper-cumulus", "coverage": coverage, "coverage_mode": "frame"}]
    asked = scenario(clouds, 4, **{"output.variables": ["cloud_fraction"]})
    cube = simulate(asked)
    points = ROWS * COLUMNS * 16
    assert np.all(np.abs(cube.cloud_fraction.sum(("y", "x")) * 16 - coverage * points) <= 1)


def test_whole_frames_of_too_many_points_are_refused_with_what_to_do(monkeypatch):
    clouds = [{"type": "paper-cumulus", "coverage": 0.3, "coverage_mode": "frame"}]
    # The fractal generator can sum a frame up instead.
    make_plan(scenario(clouds, 40, rows=800, columns=800))
    monkeypatch.delattr(FractalClouds, "frame_summary")
    with pytest.raises(ScenarioError) as caught:
        make_plan(scenario(clouds, 40, rows=800, columns=800))
    (problem,) = caught.value.problems
    assert problem.field == "image.samples_per_pixel"
    for part in ("32000 x 32000 points", "allowed: 67108864 points", "closest valid choice is 10;"):
        assert part in problem.message
    assert 'clouds.layers[0].coverage_mode = "field"' in problem.message
    make_plan(scenario(clouds, 10, rows=800, columns=800))


def test_the_size_of_an_images_pixels_is_that_of_the_points():
    sample = pytest.importorskip("iris_sample_data")
    path = Path(sample.path) / "toa_brightness_stereographic.nc"
    native = read_image(path).pixel_size_m
    parameters = {"image": str(path), "missing": "clear"}
    clouds = [{"type": "paper-cumulus", "generator": "imagery", "parameters": parameters}]
    still = {"motion.platform_speed": 0.0}
    make_plan(scenario(clouds, 2, size=2 * native, **still))
    with pytest.raises(ScenarioError) as caught:
        make_plan(scenario(clouds, 2, size=native, **still))
    (problem,) = caught.value.problems
    assert problem.field == "image.pixel_size"
    assert "sizes here are those of points" in problem.message
    assert "samples_per_pixel = 2" in problem.message


def test_the_plan_says_how_many_points_a_pixel_has():
    plan = make_plan(scenario([], 4))
    assert describe(plan)["samples_per_pixel"] == 4
    assert "mean of 4 x 4 points, 10 m apart" in plan_text(plan)
    assert "points" not in plan_text(make_plan(scenario([])))
