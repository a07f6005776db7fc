"""Which pixels a certificate checks."""

from dataclasses import replace

import numpy as np
import pytest
from cheap import CHEAP
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import kstest

from hcss_twin import Scenario, make_plan
from hcss_twin.engine.certificate.certificate import Certificate, StratumCheck
from hcss_twin.engine.certificate.certificate_pixels import PixelSample, allot
from hcss_twin.engine.certificate.part_sample import PartSample
from hcss_twin.engine.stages.stage import SeenWindow
from hcss_twin.plan.sunlight import checked_frames

SIZES = st.lists(st.integers(0, 400), min_size=1, max_size=10)


@pytest.fixture(scope="module")
def plan():
    return make_plan(Scenario.load("stratus", {**CHEAP, "image.rows": 6, "image.columns": 9}))


@pytest.fixture(scope="module")
def layer(plan):
    """Its thickness is 10 to 1000 m, with a geometric mean of 100 m."""
    return plan.layers[0]


def names(layers, thickness, shape, samples=1):
    table = np.array(Certificate.stratum_names(len(layers)))
    return table[
        Certificate.stratum_of(layers, [np.array(each, np.float32) for each in thickness], shape, samples)
    ].tolist()


def test_a_cloud_has_edges_and_is_thick_or_thin_inside(layer):
    thickness = np.zeros((5, 7))
    thickness[:, 2:] = 50.0
    thickness[:, 5:] = 200.0
    row = ["clear", "clear", "edge", "thin", "thin", "thick", "thick"]
    assert names([layer], [thickness], (5, 7)) == [row] * 5


def test_neighbours_above_and_below_make_edges_and_diagonal_ones_do_not(layer):
    thickness = np.full((5, 5), 50.0)
    thickness[2, 2] = 0.0
    found = np.array(names([layer], [thickness], (5, 5)))
    edge = np.zeros((5, 5), bool)
    edge[[1, 3, 2, 2], [2, 2, 1, 3]] = True
    assert np.all((found == "edge") == edge)
    assert found[2, 2] == "clear"
    assert found[1, 1] == "thin"


def test_a_pixel_that_is_clear_in_part_is_an_edge_and_its_clear_points_do_not_make_it_thin(layer):
    thickness = np.full((2, 8), 150.0)
    thickness[0, 0] = 0.0
    thickness[:, 6:] = 50.0
    assert names([layer], [thickness], (1, 4), 2) == [["edge", "edge", "thick", "thin"]]


def test_two_layers_are_told_apart(layer):
    low, high = np.full((3, 9), 20.0), np.full((3, 9), 20.0)
    low[:, :3] = 0.0
    high[:, 6:] = 0.0
    low[:, 7:] = 500.0
    found = names([layer, replace(layer, name="other")], [low, high], (3, 9))
    row = ["thin (high only)"] * 3 + ["edge (both)"] + ["thin (both)"] + ["edge (both)"]
    assert found == [[*row, "thin (low only)", "thick (low only)", "thick (low only)"]] * 3


@pytest.mark.parametrize("layers", [1, 2, 3])
def test_clear_pixels_in_shadow_are_a_stratum_and_shadow_changes_no_other(layer, layers):
    thickness = np.zeros((3, 9), np.float32)
    thickness[:, 4:] = 50.0
    shaded = np.zeros((3, 9), np.bool_)
    shaded[:, 2:6] = True
    table, of_layers = np.array(Certificate.stratum_names(layers, shadows=True)), [layer] * layers
    assert table[:-1].tolist() == list(Certificate.stratum_names(layers))
    here, without = (
        table[Certificate.stratum_of(of_layers, [thickness] * layers, (3, 9), 1, light)] for light in (shaded, None)
    )
    assert np.all((here == "clear in shadow") == (shaded & (thickness == 0.0)))
    np.testing.assert_array_equal(here[:, 4:], without[:, 4:])
    assert np.all(here[:, :2] == "clear")


def test_without_layers_all_is_clear():
    assert names([], [], (2, 2)) == [["clear"] * 2] * 2


@given(st.integers(0, 60), SIZES)
def test_every_stratum_gets_a_pixel_as_far_as_they_go_and_none_more_than_it_has(count, sizes):
    sizes = np.array(sizes)
    taken = allot(count, sizes)
    assert np.all(taken <= sizes)
    assert taken.sum() == min(count, sizes.sum())
    if count >= np.count_nonzero(sizes):
        assert np.all(taken[sizes > 0] >= 1)


def test_half_of_the_draws_go_by_size():
    assert allot(100, np.array([8000, 2000, 0])).tolist() == [65, 35, 0]


def drawn(plan, thickness):
    sample = PixelSample(plan)
    for index in range(plan.frame_times_s.size):
        part_sample = sample.of_part(index)
        if part_sample is not None:
            for rows in (slice(0, 4), slice(4, 6)):
                part_sample.observe(SeenWindow((rows, slice(0, 9)), [thickness[rows]]))
            radiance = np.arange(3 * 54, dtype=np.float32).reshape(1, 3, 6, 9)
            sample.add_frame(index, [part_sample.drawn(radiance)])
    return sample.frames


def test_pixels_carry_the_cloud_and_radiance_of_their_own_place(plan):
    thickness = np.linspace(10, 999, 54, dtype=np.float32).reshape(6, 9)
    (frame,) = drawn(plan, thickness)
    np.testing.assert_array_equal(frame.thickness_m[:, 0, 0], thickness[frame.row, frame.column])
    np.testing.assert_array_equal(frame.radiance[:, 0, 1], 54 + 9 * frame.row + frame.column)
    assert len({(y, x) for y, x in zip(frame.row, frame.column, strict=True)}) == 24
    assert frame.pixels.sum() == 54


def test_the_draw_is_the_same_each_time_and_another_with_another_seed(plan):
    thickness = np.linspace(10, 999, 54, dtype=np.float32).reshape(6, 9)
    (one,), (two,) = drawn(plan, thickness), drawn(plan, thickness)
    np.testing.assert_array_equal(one.row, two.row)
    np.testing.assert_array_equal(one.column, two.column)
    places = set()
    for seed in range(4):
        scenario = plan.scenario.model_copy(update={"seed": seed})
        (frame,) = drawn(replace(plan, scenario=scenario), thickness)
        places.add((frame.frame, *frame.row.tolist(), *frame.column.tolist()))
    assert len(places) == 4


@pytest.mark.parametrize(
    ("asked", "frames", "samples", "checked", "from_frames"),
    [
        (24, 8, 1, 24, 1),
        (47, 8, 1, 47, 1),
        (48, 8, 1, 48, 2),
        (3000, 8, 1, 432, 8),
        (24, 1, 1, 24, 1),
        (24, 8, 2, 24, 1),
        (24, 8, 4, 6, 1),
        (24, 8, 64, 1, 1),
    ],
)
def test_few_pixels_come_from_one_frame_and_many_from_several(plan, asked, frames, samples, checked, from_frames):
    output = plan.scenario.output.model_copy(update={"certificate": asked})
    image = plan.scenario.image.model_copy(update={"samples_per_pixel": samples})
    scenario = plan.scenario.model_copy(update={"output": output, "image": image})
    few = replace(plan, scenario=scenario, samples_per_pixel=samples, frame_times_s=plan.frame_times_s[:frames])
    found = drawn(few, np.full((6 * samples, 9 * samples), 50.0, np.float32)) if samples == 1 else None
    if found is not None:
        assert sum(frame.row.size for frame in found) == checked
        assert len({frame.frame for frame in found}) == len(found) == from_frames
    else:
        counts = PixelSample(few).counts
        assert sum(counts.values()) == checked
        assert len(counts) == from_frames


def test_checked_frames_are_one_of_each_part_and_the_same_for_all_scenes():
    for parts, frames in ((1, 1), (1, 8), (5, 8), (8, 8), (12, 500)):
        chosen = checked_frames(parts, frames)
        assert chosen == checked_frames(parts, frames)
        ends = [part * frames // parts for part in range(parts + 1)]
        assert all(low <= frame < high for low, frame, high in zip(ends, chosen, ends[1:], strict=False))
        assert len(chosen) == parts


def numbers_of(plan, index, size):
    """The random number (size, size) of every pixel of a frame, drawn in two parts of its rows."""
    number, half = np.empty((size, size)), size // 2
    for first in (0, half):
        every = PartSample(plan, index, size**2, first * size, (first, 0))
        window = slice(0, half), slice(0, size)
        every.observe(SeenWindow(window, [np.zeros((half, size), np.float32)]))
        found = every.drawn(np.zeros((1, 1, half, size), np.float32))
        assert found.key.size == half * size
        number[found.place[:, 1], found.place[:, 2]] = found.key
    return number


@pytest.mark.parametrize("rare", [0, 5, 200])
def test_of_each_stratum_those_with_the_smallest_numbers_are_drawn(plan, rare):
    """However few pixels a stratum has: the numbers are those of the frame, however it is divided."""
    size = 300
    thickness = np.full((size, size), 50.0, np.float32)
    thickness[: size // 2] = 500.0
    clear = np.random.default_rng(1).choice(size, rare, replace=False)
    thickness[clear, clear] = 0.0
    index = checked_frames(1, plan.frame_times_s.size)[0]
    kind, window = Certificate.stratum_of(plan.layers, [thickness], (size, size), 1), (slice(0, size), slice(0, size))
    sample = PixelSample(plan).of_part(index)
    number = numbers_of(plan, index, size)
    assert kstest(number.ravel(), "uniform").pvalue > 1e-3
    sample.observe(SeenWindow(window, [thickness]))
    found = sample.drawn(np.zeros((1, 1, size, size), np.float32))
    for stratum in range(len(Certificate.stratum_names(1))):
        places = np.argwhere(kind == stratum)
        wanted = places[np.argsort(number[kind == stratum])][:24]
        own = found.place[:, 0] == stratum
        np.testing.assert_array_equal(found.place[own, 1:], wanted)
        np.testing.assert_array_equal(found.points[own, 0, 0], thickness[wanted[:, 0], wanted[:, 1]])


def test_a_certificate_counts_over_its_strata_and_reports_the_worst_of_each_band(plan):
    strata = (
        StratumCheck("clear", 50, 10, 1, (1e-4, 5e-3), {}),
        StratumCheck("thin", 20, 7, 2, (3e-4, 2e-4), {}),
        StratumCheck("thick", 9, 0, 0, (), {}),
    )
    certificate = Certificate(plan.accuracy, 1e-4, ("mwir", "lwir"), strata, (0,), 0.1, {}, {}, (), ())
    assert (certificate.checked, certificate.exceeding, certificate.passed) == (17, 3, False)
    assert certificate.achieved == {"mwir": 3e-4, "lwir": 5e-3}
    assert replace(certificate, strata=(replace(strata[0], exceeding=0),)).passed
