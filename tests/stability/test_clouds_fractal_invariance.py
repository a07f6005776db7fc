"""Windows, order, motion and extreme parameters never change a pixel's bits or break a frame."""

import math
import random
from itertools import cycle
from pathlib import Path

import numpy as np
import pytest

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
MOVING = Motion(1000.0, (10.0, -3.0), 600.0, 1.0)
WATER = Microphysics("water", 6.0, 1.5, 1.0, 1e8, (0.1, 50.0))


def generator(shape, motion=MOVING, rows=60, columns=70, pixel=20.0, coverage=0.4, seed=11, mode="frame"):
    layer = CloudLayer("x", 0.0, 1000.0, "base", 33.0, coverage, None, WATER, coverage_mode=mode)
    grid = Grid(rows, columns, pixel)
    return FractalClouds(CloudInputs(layer, grid, motion, seed, Catalog(root=Path("none")), shape), FractalParameters())


@pytest.mark.parametrize("name", TYPES)
@pytest.mark.parametrize("origin", [(0, 0), (-431, -87), (10**9, -(10**9)), (-(10**9), 10**9)], ids=str)
def test_any_window_equals_the_whole_to_the_bit(name, origin):
    made = generator(TYPES[name])
    top, left = origin
    whole = made.field(3.7, slice(top, top + 83), slice(left, left + 101))
    draw = random.Random(f"{name}{origin}")
    windows = [(0, 1, 0, 1), (82, 83, 100, 101), (0, 83, 50, 51)]
    for _ in range(12):
        a, b = sorted(draw.sample(range(84), 2))
        c, d = sorted(draw.sample(range(102), 2))
        windows.append((a, b, c, d))
    for a, b, c, d in windows:
        part = made.field(3.7, slice(top + a, top + b), slice(left + c, left + d))
        np.testing.assert_array_equal(part, whole[a:b, c:d])


@pytest.mark.parametrize("mode", ["frame", "field"])
def test_thickness_windows_are_cuts_of_the_frame(mode):
    made = generator(TYPES["simulated"], mode=mode)
    frame = made.thickness_m(2.0, slice(None), slice(None))
    assert frame.shape == (60, 70)
    np.testing.assert_array_equal(made.thickness_m(2.0, slice(7, 31), slice(64, 70)), frame[7:31, 64:70])


@pytest.mark.parametrize("name", TYPES)
def test_frames_do_not_depend_on_order_or_instance(name):
    window = slice(0, 60), slice(0, 70)
    made = generator(TYPES[name])
    forward = [made.field(float(t), *window) for t in range(4)]
    for t in (2, 0, 3, 1):
        np.testing.assert_array_equal(made.field(float(t), *window), forward[t])
        np.testing.assert_array_equal(generator(TYPES[name]).field(float(t), *window), forward[t])


INSTANTS = (1.0, 0), (1.0, 10**6), (0.1, 3), (0.1, 10**7 - 1), (0.02, 10**7 + 7)


@pytest.mark.parametrize(("name", "at"), list(zip(cycle(TYPES), INSTANTS, strict=False)))
def test_a_push_broom_sees_the_same_bits_again(name, at):
    interval, start = at
    # 1 km/s over 20 m pixels: 50, 5 and 1 pixels per frame, at times that are often not exact in binary.
    made = generator(TYPES[name], Motion(1000.0, (0.0, 0.0), math.inf, interval))
    step = round(1000.0 * interval / 20.0)
    before = made.field(start * interval, slice(0, 40), slice(step, step + 70))
    after = made.field((start + 1) * interval, slice(0, 40), slice(0, 70))
    np.testing.assert_array_equal(after, before)


def test_displacement_is_exact_for_whole_pixels_and_half_pixels_only():
    times = np.arange(1, 200_000, 997)
    assert all(Grid(1, 1, 20.0).displacement_pixels(1000.0, int(n) * 0.1) == 5 * n for n in times)
    assert all(Grid(1, 1, 20.0).displacement_pixels(990.0, int(n) * 1.0) == 49.5 * n for n in times)
    assert Grid(1, 1, 3.0).displacement_pixels(1.0, 1.0) == 1.0 / 3.0
    assert Grid(1, 1, 20.0).displacement_pixels(-1.0, 1e-9) == -5e-11


def test_small_steps_in_time_make_small_changes_far_out_too():
    # A coordinate in single precision would be off by many cells here.
    made = generator(TYPES["stratus"], Motion(0.0, (10.0, 0.0), 600.0, 0.01))
    window = slice(10**8, 10**8 + 50), slice(-(10**8), -(10**8) + 50)
    change = made.field(5000.01, *window) - made.field(5000.0, *window)
    assert 0.0 < np.abs(change).max() < 0.02


@pytest.mark.parametrize("gamma", [1.01, 8.0])
@pytest.mark.parametrize("hurst", [0.01, 0.99])
@pytest.mark.parametrize(("octaves", "shape"), [([0, 16], (1, 37)), ([16, 16], (40, 1)), ([0, 0], (1, 1))], ids=str)
def test_extreme_parameters_give_finite_frames_with_exact_coverage(gamma, hurst, octaves, shape):
    rows, columns = shape
    made = generator({"gamma": gamma, "H": hurst, "L": [1e-3, 1e4], "k": octaves}, MOVING, rows, columns, pixel=1000.0)
    assert math.fsum(octave.variance for octave in made.octaves) == pytest.approx(1.0)
    for time in (0.0, 1e6):
        field = made.field(time, slice(0, rows), slice(0, columns))
        assert np.abs(field).max() < 7.0
        thickness = made.thickness_m(time, slice(None), slice(None))
        assert np.count_nonzero(thickness) == round(0.4 * rows * columns)


@pytest.mark.parametrize("origin", [10**9, -(10**9)])
def test_the_finest_octave_has_no_repeats_far_out(origin):
    made = generator({"gamma": 8.0, "H": 0.01, "L": [1e4, 1e4], "k": [16, 16]}, pixel=1000.0)
    v = made.field(1e6, slice(origin, origin + 50), slice(origin, origin + 60))
    assert np.unique(v).size == v.size


@pytest.mark.parametrize("window", [(slice(3, 3), slice(0, 5)), (slice(0, 5), slice(9, 2))], ids=["rows", "columns"])
def test_an_empty_window_is_an_empty_array(window):
    assert generator(TYPES["stratus"]).field(0.0, *window).size == 0
