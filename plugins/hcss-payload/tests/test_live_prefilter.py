"""Footprints of live pixels: against means over many points of the field itself, and closed forms."""

import numpy as np
import pytest
from camera_scenes import LWIR, MWIR, scenario
from hcss_payload.live.octaves import between, field_covariance, seen_octaves, separations, shape_of
from hcss_payload.live.prefilter import Sharpness, radiance_covariance, sharpness
from hcss_payload.live.radiance import TABLE_HALF, TABLE_PER_VALUE, edge_of, intervals
from hcss_payload.live.twin import FINENESS
from scipy.special import ndtr

import hcss_twin
from hcss_twin.engine.compile import tables_of
from hcss_twin.engine.tables.look_up import LookUp
from hcss_twin.models.clouds.fractal.field import FractalField
from hcss_twin.models.clouds.fractal.generator import FractalClouds
from hcss_twin.models.clouds.fractal.octaves import Octave
from hcss_twin.providers import Grid

PIXELS, FINE, SEED = 128, 8, 11


def neighbour_contrast(image):
    return np.sqrt(np.mean(np.diff(image, axis=0) ** 2) + np.mean(np.diff(image, axis=1) ** 2))


def field_radiance(plan):
    """The radiance (B, N) of values (N,) of the field."""
    table = tables_of(plan).at(0.0)
    look_up, exponent = LookUp(table), shape_of(plan).brightness_exponent

    def radiance(field):
        thickness = FractalClouds.field_thickness(
            np.ascontiguousarray(field, np.float32).reshape(1, -1), plan.layers[0], exponent
        )
        values = np.empty((table.clear.size, 1, field.size), np.float32)
        look_up.fill(values, [thickness])
        return values[: len(plan.bands), 0].astype(float)

    return radiance


def true_pixels(plan, radiance, width, height):
    """Means over many points of each pixel."""
    point_m = min(width, height) / FINE
    across, up = round(width / point_m), round(height / point_m)
    octaves = Octave.separate(shape_of(plan), Grid(1, 1, point_m), plan.assembly.motion, noise=False)
    field = FractalField(SEED, octaves, threads=1)
    everywhere = FractalField.PixelWindow(0, PIXELS * up, 0.0), FractalField.PixelWindow(0, PIXELS * across, 0.0)
    values = radiance(field.window(0.0, *everywhere))
    return values.reshape(-1, PIXELS, up, PIXELS, across).mean(axis=(2, 4))


def live_pixels(plan, radiance, width, height):
    """One value of the interpolated field for each pixel, as the kernels of live frames look it up."""
    point_m, first_m = np.sqrt(width * height) / FINENESS, 0.5 * min(width, height) / FINE
    seen = seen_octaves(shape_of(plan), plan.assembly.motion, point_m, np.diag([width, height]))
    x, y = (((np.arange(PIXELS) + 0.5) * size - first_m) / point_m for size in (width, height))
    size = (FractalField.PixelWindow(0, int(coordinates[-1]) + 2, 0.0) for coordinates in (y, x))
    tile = FractalField(SEED, seen.octaves, threads=1).window(0.0, *size).astype(float)
    left, top = x.astype(int), y.astype(int)
    lines = tile[:, left] + (x - left) * (tile[:, left + 1] - tile[:, left])
    field = lines[top] + (y - top)[:, None] * (lines[top + 1] - lines[top])
    edge = edge_of(plan.layers[0].coverage)
    start, end = intervals(radiance, edge, sharpness(radiance, edge, seen))
    position = np.clip((field - edge) * TABLE_PER_VALUE + TABLE_HALF, 0, 2 * TABLE_HALF - 1e-6)
    interval = position.astype(int)
    return start[:, interval] + (position - interval) * (end - start)[:, interval]


@pytest.mark.parametrize(
    "kind",
    ["stratus", "cumulus", "cirrus"]
    + [pytest.param(kind, marks=pytest.mark.campaign) for kind in ("altostratus", "stratocumulus", "altocumulus")],
)
def test_pixels_have_the_mean_and_the_contrast_between_neighbours_of_many_points(kind):
    clouds = {"type": kind, "generator": "fractal", "coverage": 0.5, "coverage_mode": "field"}
    plan = hcss_twin.make_plan(scenario({"clouds": clouds, "bands": [LWIR, MWIR]}))
    radiance = field_radiance(plan)
    for width, height in ((20.0, 20.0), (60.0, 180.0), (200.0, 200.0), (200.0, 600.0)):
        exact, live = (pixels(plan, radiance, width, height) for pixels in (true_pixels, live_pixels))
        for mine, expected in zip(live, exact, strict=True):
            assert mine.mean() == pytest.approx(expected.mean(), rel=2e-3)
            assert neighbour_contrast(mine) == pytest.approx(neighbour_contrast(expected), rel=0.05)


def test_covariance_of_a_step_is_that_of_sheppard():
    radiance = radiance_covariance(lambda field: np.stack((field > 0.0, field)).astype(float), 0.0)
    covariance = 1.0 - np.linspace(0.0, 1.0, 33) ** 2
    assert radiance[0] == pytest.approx(np.arcsin(covariance) / (2.0 * np.pi), abs=2e-4)
    assert radiance[1] == pytest.approx(covariance, abs=1e-3)


def test_variance_of_means_and_between_points_is_that_of_the_field():
    step = 1.0 / 16.0
    octave = Octave(
        0, 1.0, Octave.AxisScale(step, False), Octave.AxisScale(step, False), Octave.AxisScale(0.0, False), False
    )
    field = FractalField(5, (octave,), 1).window(
        0.0, FractalField.PixelWindow(0, 1600, 0.0), FractalField.PixelWindow(0, 1600, 0.0)
    )
    for cells in (0.5, 1.5):
        points = int(16 * cells)
        sums = np.cumsum(np.cumsum(np.pad(field.astype(float), ((1, 0), (1, 0))), axis=0), axis=1)
        means = sums[points:, points:] - sums[:-points, points:] - sums[points:, :-points] + sums[:-points, :-points]
        within, share = separations(points * np.eye(2), np.zeros(2))
        variance = field_covariance(octave, within, 1.0) @ share
        assert np.var(means / points**2) == pytest.approx(variance * np.var(field), rel=0.02)
    shares = np.linspace(0.0, 1.0, 33)[:, None, None]
    blended = (1.0 - shares) * field[:, :-12:4] + shares * field[:, 12::4]
    weight = np.full(33, 1.0)
    weight[[0, -1]] = 0.5
    assert np.average(np.mean(blended**2, axis=(1, 2)), weights=weight) == pytest.approx(
        between(0.75) * np.var(field), rel=0.02
    )
    assert between(100.0) == pytest.approx(2.0 / 3.0)


@pytest.mark.parametrize("lag", [0.25, 1.25])
def test_independent_points_covary_as_the_weights_of_linear_interpolation(lag):
    position = (np.arange(512) + 0.5) / 512
    weights = [np.maximum(0.0, 1.0 - np.abs(position[:, None] + away - np.arange(-1, 4))) for away in (0.0, lag)]
    assert between(100.0, lag) == pytest.approx(np.mean(np.sum(weights[0] * weights[1], axis=1)), abs=1e-5)


@pytest.mark.parametrize("sigma", [0.0, 0.1, 0.7])
def test_tables_of_a_step_are_the_normal_distribution(sigma):
    edge = 0.3

    def step(field):
        return np.where(np.float32(field) >= np.float32(edge), 2.0, 1.0)[None]

    start, end = intervals(step, edge, Sharpness(np.array([sigma]), np.ones(1)))
    value = edge + (np.arange(2 * TABLE_HALF + 1) - TABLE_HALF) / TABLE_PER_VALUE
    if sigma == 0.0:
        assert np.all(start[0] == np.where(np.arange(2 * TABLE_HALF) >= TABLE_HALF, 2.0, 1.0))
        assert np.array_equal(start, end)
    else:
        exact = 1.0 + ndtr((value - edge) / sigma)
        assert start[0] == pytest.approx(exact[:-1], abs=1e-3)
        assert end[0] == pytest.approx(exact[1:], abs=1e-3)
