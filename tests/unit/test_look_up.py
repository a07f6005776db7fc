"""The look-up kernels against the plain definition: linear interpolation of each point, then the mean of the pixel."""

from dataclasses import replace

import numpy as np
import pytest

from hcss_twin.core.errors import ProviderError
from hcss_twin.engine.tables.look_up import LookUp
from hcss_twin.engine.tables.radiance_tables import DenseTable
from hcss_twin.plan.windows import pixel_sums, points_of, windows
from hcss_twin.providers import Grid

CHANNELS = 5


def table(*nodes_m, both=True):
    """A table of random numbers."""
    random = np.random.default_rng(7)
    nodes = tuple(np.asarray(each, dtype=np.float64) for each in nodes_m)
    shape = [each.size for each in nodes]
    return DenseTable(
        clear=random.random(CHANNELS),
        nodes_m=nodes,
        alone=tuple(random.random((size, CHANNELS)) for size in shape),
        both=random.random((*shape, CHANNELS)).astype(np.float32) if both and len(shape) == 2 else None,
    )


def plain(made, thickness_m, samples):
    """(C, y, x), written out: numpy's interpolation of each channel, points of each kind apart, then the mean."""
    points = np.empty((CHANNELS, *thickness_m[0].shape))
    values = [each.astype(np.float64) for each in thickness_m]
    cloudy = [each > 0 for each in values]
    for channel in range(CHANNELS):
        plane = points[channel]
        plane[:] = made.clear[channel]
        for nodes, alone, value, where in zip(made.nodes_m, made.alone, values, cloudy, strict=True):
            plane[where] = np.interp(value[where], nodes, alone[:, channel])
        if made.both is not None:
            where = cloudy[0] & cloudy[1]
            rows = np.stack([np.interp(values[1][where], made.nodes_m[1], row) for row in made.both[..., channel]])
            plane[where] = [
                np.interp(value, made.nodes_m[0], rows[:, index]) for index, value in enumerate(values[0][where])
            ]
    rows, columns = (size // samples for size in points.shape[1:])
    return points.reshape(CHANNELS, rows, samples, columns, samples).mean(axis=(2, 4))


def looked_up(made, thickness_m, samples=1):
    rows, columns = (size // samples for size in thickness_m[0].shape)
    radiance = np.full((CHANNELS, rows, columns), np.nan, dtype=np.float32)
    LookUp(made).fill(radiance, thickness_m, samples)
    return radiance


def sky(shape, low, high, seed, cover=0.6):
    random = np.random.default_rng(seed)
    thickness = random.uniform(low, high, shape)
    return np.where(random.random(shape) < cover, thickness, 0.0).astype(np.float32)


NODES = {
    "even": np.linspace(10.0, 3000.0, 333),
    "geometric": np.geomspace(1.0, 20_000.0, 57),
    "crowded": np.unique(np.concatenate([np.linspace(100.0, 100.1, 400), np.geomspace(100.1, 4000.0, 9)])),
    "two": np.array([999.999, 1000.0]),
    "across powers of two": np.array([255.9, 256.0, 256.1, 511.0, 512.0, 2048.0]),
}


"""With two layers, the four weights and their products with the table are in single precision."""


def test_no_layer_is_the_clear_column():
    made = DenseTable(np.arange(1.0, 6.0), (), (), None)
    radiance = np.zeros((CHANNELS, 3, 4), dtype=np.float32)
    LookUp(made).fill(radiance, [])
    np.testing.assert_array_equal(radiance, np.broadcast_to(np.arange(1.0, 6.0)[:, None, None], radiance.shape))


@pytest.mark.parametrize("samples", [1, 4])
@pytest.mark.parametrize("most_points", [1, 64, 500, 10**6])
def test_windows_together_are_the_whole(samples, most_points):
    grid = Grid(21, 34, 10.0)
    made = table(NODES["even"], NODES["geometric"])
    shape = (grid.rows * samples, grid.columns * samples)
    thickness = [sky(shape, 10.0, 3000.0, 3), sky(shape, 1.0, 20_000.0, 4)]
    whole = looked_up(made, thickness, samples)
    pieces = np.full_like(whole, np.nan)
    seen = np.zeros((grid.rows, grid.columns), dtype=int)
    for rows, columns in windows(grid, samples, most_points):
        seen[rows, columns] += 1
        assert (rows.stop - rows.start) * (columns.stop - columns.start) * samples**2 <= max(most_points, samples**2)
        part = [each[points_of(rows, samples), points_of(columns, samples)] for each in thickness]
        LookUp(made).fill(pieces, part, samples, (rows.start, columns.start))
    assert np.all(seen == 1)
    np.testing.assert_array_equal(pieces, whole)


def test_rounding_beyond_the_outermost_nodes_is_taken_for_the_node():
    made = table([10.0, 100.0, 1000.0])
    thickness = np.array([[10.0 * (1 - 5e-7), 1000.0 * (1 + 5e-7)]], dtype=np.float32)
    assert thickness[0, 0] < 10.0 < 1000.0 < thickness[0, 1]
    found = looked_up(made, [thickness])
    np.testing.assert_array_equal(found[:, 0].T, made.alone[0][[0, -1]].astype(np.float32))


@pytest.mark.parametrize("wrong", [9.9, 1001.0, 1e-30, 3e38])
def test_thickness_outside_the_layer_is_refused_with_its_range(wrong):
    thickness = np.full((3, 3), 50.0, dtype=np.float32)
    thickness[1, 2] = wrong
    with pytest.raises(ProviderError, match="the layer allows 10 to 1000 m"):
        looked_up(table([10.0, 1000.0]), [thickness])
    two = table([10.0, 1000.0], [10.0, 1000.0])
    with pytest.raises(ProviderError, match="the layer allows 10 to 1000 m"):
        looked_up(two, [np.zeros((3, 3), np.float32), thickness])


def test_cloud_in_a_layer_whose_coverage_is_0_is_refused():
    made = table([10.0, 1000.0], np.empty(0), both=False)
    low = np.full((2, 2), 50.0, dtype=np.float32)
    none = np.zeros((2, 2), dtype=np.float32)
    for samples in (1, 2):
        alone = looked_up(table([10.0, 1000.0]), [low], samples)
        np.testing.assert_array_equal(looked_up(made, [low, none], samples), alone)
    with pytest.raises(ProviderError, match="coverage is 0"):
        looked_up(made, [low, low])


@pytest.mark.parametrize("dtype", [np.float32, np.float64, np.bool_])
def test_sums_over_the_points_of_a_pixel(dtype):
    values = (np.random.default_rng(0).random((12, 18)) * 2).astype(dtype)
    expected = values.astype(np.float64).reshape(4, 3, 6, 3).sum(axis=(1, 3))
    np.testing.assert_allclose(pixel_sums(values, 3), expected, rtol=1e-14)


@pytest.mark.parametrize("shape", [(1, 1), (3, 64), (5, 65), (2, 200)])
def test_one_point_per_pixel_has_the_bits_of_the_general_kernel(shape):
    made = table(np.geomspace(10.0, 3000.0, 300))
    thickness = sky(shape, 10.0, 3000.0, seed=3)
    whole = np.repeat(np.repeat(thickness, 2, axis=0), 2, axis=1)
    # Sums of four equal numbers, and a quarter of them, are exact.
    np.testing.assert_array_equal(looked_up(made, [thickness]), looked_up(made, [whole], samples=2))


@pytest.mark.parametrize("share", [0.0, 0.25, 1.0 - 1e-9, 1.0])
def test_night_beside_day_keeps_its_digits(share):
    """In 2.7-3.0 um night is eight orders of magnitude darker than day."""
    day, night = table([1.0, 2.0, 5.0], [3.0, 4.0]), table([1.0, 2.0, 5.0], [3.0, 4.0])
    night = replace(
        night,
        clear=1e-9 * night.clear,
        alone=tuple(1e-9 * each for each in night.alone),
        both=np.float32(1e-9) * night.both,
    )
    found = day.blend(night, share)
    for name in ("clear", "both"):
        exact = (1.0 - share) * getattr(day, name).astype(np.float64) + share * getattr(night, name)
        np.testing.assert_allclose(getattr(found, name), exact, rtol=2e-7)
    for one, before, after in zip(found.alone, day.alone, night.alone, strict=True):
        np.testing.assert_allclose(one, (1.0 - share) * before + share * after, rtol=2e-7)
