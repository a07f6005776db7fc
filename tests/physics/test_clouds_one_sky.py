"""One sky: what a scene shows does not depend on who looks, with which pixels or in which tiles."""

import dataclasses
import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.special import ndtri

from hcss_twin.core.catalog import Catalog
from hcss_twin.models.clouds.fractal.generator import FractalClouds
from hcss_twin.models.clouds.fractal.parameters import FractalParameters
from hcss_twin.providers import CloudInputs, CloudLayer, Grid, Microphysics, Motion

TYPES = {
    "stratus": {"gamma": 3, "H": 0.8, "L": [10, 10], "k": [0, 4]},
    "cumulus": {"gamma": 3, "H": 0.7, "L": [30, 30], "k": [0, 7]},
    "cirrus": {"gamma": 3, "H": 0.8, "L": [50, 10], "k": [0, 4]},
    "simulated": {"gamma": 4, "H": 0.8, "L": [3, 7], "k": [0, 10]},
}
LAYER = CloudLayer(
    "x", 0.0, 1000.0, "base", 30.0, 0.4, None, Microphysics("water", 6.0, 1.5, 1.0, 1e8, (0.1, 50.0)), "field"
)
MOVING = Motion(1000.0, (10.0, -3.0), 600.0, 1.0)


def clouds(shape, size=60, pixel=20.0, motion=MOVING, layer=LAYER, seed=1, threads=None):
    inputs = CloudInputs(layer, Grid(size, size, pixel), motion, seed, Catalog(root=Path("none")), shape)
    return FractalClouds(inputs, FractalParameters(), threads)


def whole(made, time, size):
    return made.field(time, slice(0, size), slice(0, size))


@pytest.mark.parametrize("name", TYPES)
def test_instruments_of_other_pixel_size_see_the_same_field_at_the_same_points(name):
    # Pixel centres of 60 m are centres of every third pixel of 20 m.
    fine = whole(clouds(TYPES[name], 60, 20.0), 7.0, 60)[1::3, 1::3]
    coarse = whole(clouds(TYPES[name], 20, 60.0), 7.0, 20)
    # Octaves that are white at the coarse pixels take the nearest node there: within a few of their sigmas.
    made = clouds(TYPES[name], 20, 60.0)
    unresolved = math.fsum(octave.variance for octave in made.octaves if octave.x.nearest or octave.y.nearest)
    assert np.abs(fine - coarse).max() < 6.0 * math.sqrt(2.0 * unresolved) + 1e-5


@pytest.mark.parametrize("interval", [0.02, 1.0, 300.0])
def test_the_frame_rate_does_not_change_what_is_there(interval):
    motion = dataclasses.replace(MOVING, frame_interval_s=interval)
    seen = whole(clouds(TYPES["simulated"], motion=motion), 300.0, 60)
    np.testing.assert_array_equal(seen, whole(clouds(TYPES["simulated"]), 300.0, 60))


@pytest.mark.parametrize("mode", ["frame", "field"])
@pytest.mark.parametrize("name", TYPES)
def test_the_number_of_threads_does_not_change_a_bit(name, mode):
    layer = dataclasses.replace(LAYER, coverage_mode=mode)
    one, three = (clouds(TYPES[name], 600, layer=layer, threads=n) for n in (1, 3))
    np.testing.assert_array_equal(whole(one, 5.0, 600), whole(three, 5.0, 600))


def test_a_buffer_of_the_caller_is_filled_with_the_same_bits():
    made, out = clouds(TYPES["cumulus"]), np.full((60, 60), np.nan, dtype=np.float32)
    assert made.field(2.0, slice(0, 60), slice(0, 60), out) is out
    np.testing.assert_array_equal(out, whole(made, 2.0, 60))
    with pytest.raises(ValueError, match="out: float64"):
        made.field(2.0, slice(0, 60), slice(0, 60), np.zeros((60, 60)))


def test_a_tile_too_large_to_be_stored_at_once_equals_its_parts(monkeypatch):
    from hcss_twin.models.clouds.fractal import field as module

    whole_tile = whole(clouds(TYPES["stratus"], 300), 5.0, 300)
    monkeypatch.setattr(module, "MAX_BLOCKS", 1)
    np.testing.assert_array_equal(whole(clouds(TYPES["stratus"], 300), 5.0, 300), whole_tile)


@pytest.mark.parametrize("coverage", [0.1, 0.5, 0.9])
def test_coverage_is_exact_in_the_mean_over_the_sky(coverage):
    shape = {**TYPES["stratus"], "L": [400, 400]}  # many independent clouds in one image
    layer = dataclasses.replace(LAYER, coverage=coverage)
    shares = [
        np.mean(clouds(shape, 400, layer=layer, seed=seed).thickness_m(0.0, slice(None), slice(None)) > 0)
        for seed in range(12)
    ]
    assert np.mean(shares) == pytest.approx(coverage, abs=4 * np.std(shares) / math.sqrt(12) + 1e-4)


def test_the_threshold_is_the_normal_quantile_and_thickness_linear_in_p():
    layer = dataclasses.replace(LAYER, coverage=0.25)
    made = clouds(TYPES["stratus"], 200, layer=layer)
    from scipy.special import ndtr

    field = whole(made, 0.0, 200).astype(np.float64)
    expected = np.where(field >= -ndtri(0.25), 30.0 + 970.0 * (ndtr(field) - 0.75) / 0.25, 0.0)
    np.testing.assert_allclose(made.thickness_m(0.0, slice(None), slice(None)), expected, atol=0.02)


@pytest.mark.parametrize("mode", ["frame", "field"])
def test_a_taper_thins_the_edges_smoothly_and_leaves_coverage_and_summits(mode):
    plain, tapered = (
        clouds(
            TYPES["stratus"], 300, layer=dataclasses.replace(LAYER, coverage_mode=mode, edge_taper=taper)
        ).thickness_m(0.0, slice(None), slice(None))
        for taper in (0.0, 0.5)
    )
    np.testing.assert_array_equal(tapered > 0, plain > 0)
    u = (plain[plain > 0].astype(np.float64) - 30.0) / 970.0
    s = np.minimum(u / 0.5, 1.0)
    np.testing.assert_allclose(tapered[plain > 0], 30.0 + 970.0 * u * s * s * (3 - 2 * s), atol=0.01)


def test_clouds_change_smoothly_in_time_without_jumps_of_the_coverage():
    still = Motion(0.0, (0.0, 0.0), 600.0, 0.1)
    made = clouds(TYPES["stratus"], 200, motion=still)
    masks = [made.thickness_m(0.1 * step, slice(None), slice(None)) > 0 for step in range(5)]
    assert max(np.mean(a != b) for a, b in pairwise(masks)) < 2e-3


@pytest.mark.parametrize(
    "frames", [pytest.param(6, marks=pytest.mark.long), pytest.param(63, marks=pytest.mark.campaign)]
)
def test_a_hundred_million_samples_hold_no_hot_pixel(frames):
    """With 63 frames a thousand million."""
    made = clouds(TYPES["cumulus"], 4000)
    worst = 0.0
    out = np.empty((4000, 4000), dtype=np.float32)
    for frame in range(frames):
        made.field(977.0 * frame, slice(0, 4000), slice(0, 4000), out)
        worst = max(worst, float(out.max()), -float(out.min()))
    # The highest of the 6 frames is 5.18, and of more frames more: below 5 the tail would be cut.
    assert 5.0 < worst < 7.0
