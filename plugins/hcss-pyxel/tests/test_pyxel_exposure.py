"""What an exposure sees of the frames."""

import itertools

import numpy as np
import pytest
from hcss_pyxel.exposure import frame_weights

TIMES = np.array([0.0, 1.0, 2.5, 3.0])


def test_a_held_frame_is_there_until_the_next_and_the_last_as_long_as_the_one_before():
    for index, (start, end) in enumerate([(0.0, 1.0), (1.0, 2.5), (2.5, 3.0), (3.0, 3.5)]):
        for low, high in ((start, end), (start, start + 1e-3), (end - 1e-3, end)):
            np.testing.assert_allclose(frame_weights(TIMES, low, high, "hold"), np.eye(4)[index], rtol=0, atol=1e-12)


def test_an_exposure_over_several_frames_has_each_for_its_time():
    np.testing.assert_allclose(frame_weights(TIMES, 0.75, 2.75, "hold"), np.array([0.25, 1.5, 0.25, 0.0]) / 2.0)


def test_radiance_that_changes_evenly_is_that_of_the_middle_of_the_exposure():
    random = np.random.default_rng(1)
    for low, high in np.sort(random.uniform(0.0, 3.0, (50, 2)), axis=1):
        weights = frame_weights(TIMES, low, high, "interpolate")
        assert weights @ (5.0 + 2.0 * TIMES) == pytest.approx(5.0 + (low + high), rel=1e-12)


@pytest.mark.parametrize("between", ["hold", "interpolate"])
def test_photons_do_not_depend_on_how_an_exposure_is_split(between):
    random = np.random.default_rng(2)
    edges = np.sort(random.uniform(0.0, 3.0, 12))
    whole = frame_weights(TIMES, edges[0], edges[-1], between) * (edges[-1] - edges[0])
    parts = sum(frame_weights(TIMES, low, high, between) * (high - low) for low, high in itertools.pairwise(edges))
    np.testing.assert_allclose(parts, whole, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("start", "end", "between"),
    [(-0.1, 1.0, "hold"), (3.0, 3.6, "hold"), (2.5, 3.1, "interpolate"), (7.0, 8.0, "hold")],
)
def test_an_exposure_outside_the_cube_is_refused_with_what_the_cube_covers(start, end, between):
    last = "3.5" if between == "hold" else "3"
    with pytest.raises(ValueError, match=rf"the cube covers 0 to {last} s \(frames: {between}\)"):
        frame_weights(TIMES, start, end, between)


def test_rounding_of_times_is_not_outside():
    times = np.array([0.0, 0.1, 0.2])
    np.testing.assert_allclose(frame_weights(times, 0.2, 0.30000000000000004, "hold"), [0, 0, 1], atol=1e-9)


def test_the_only_frame_is_a_still_scene():
    np.testing.assert_array_equal(frame_weights(np.array([4.0]), 100.0, 200.0, "hold"), [1.0])
