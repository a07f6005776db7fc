"""The look-up kernels against the plain definition: linear interpolation of each point, then the mean of the pixel."""

import numpy as np
import pytest
from dense_tables import dense_table

from hcss_twin.core.errors import ProviderError
from hcss_twin.engine.tables.look_up import LookUp
from hcss_twin.engine.tables.radiance_tables import stacked_tables
from hcss_twin.plan.windows import pixel_sums, points_of, windows
from hcss_twin.providers import Grid

CHANNELS = 5


def table(*nodes_m):
    """A table of random numbers; layers without nodes never have cloud."""
    values = np.random.default_rng(7).random((*(1 + len(nodes) for nodes in nodes_m if len(nodes)), CHANNELS))
    return dense_table(nodes_m, values)


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


def test_no_layer_is_the_clear_column():
    made = dense_table((), np.arange(1.0, 6.0))
    radiance = np.zeros((CHANNELS, 3, 4), dtype=np.float32)
    LookUp(made).fill(radiance, [])
    np.testing.assert_array_equal(radiance, np.broadcast_to(np.arange(1.0, 6.0)[:, None, None], radiance.shape))


@pytest.mark.parametrize("samples", [1, 2])
def test_states_are_added_with_the_weights_of_each_pixel(samples):
    random, nodes = np.random.default_rng(1), (NODES["two"], np.array([1.0, 10.0, 100.0]))
    tables = [dense_table(nodes, random.random((3, 4, CHANNELS))) for _ in range(4)]
    thickness = [sky((6, 8), *each[[0, -1]], seed) for seed, each in enumerate(nodes)]
    shape = 6 // samples, 8 // samples
    for weights in (random.random((*shape, 1, 4)), random.random((1, shape[1], CHANNELS, 4))):
        found, expected = np.empty((CHANNELS, *shape), np.float32), np.zeros((CHANNELS, *shape))
        LookUp(stacked_tables(tables)).fill(found, thickness, samples, weights=weights)
        for number, one in enumerate(tables):
            expected += np.moveaxis(weights[..., number], 2, 0) * looked_up(one, thickness, samples)
        np.testing.assert_allclose(found, expected, rtol=1e-6)


def test_fewer_states_give_what_all_give():
    """Tables that are smooth functions of a direction, with a small part of a second shape, at their own nodes."""
    random, tables = np.random.default_rng(1), []
    for number, (a, b) in enumerate(random.uniform(-1.0, 1.0, (16, 2))):
        nodes = np.geomspace(1.0, 1000.0, 20 + number % 2)
        level = 5.0 + np.arange(CHANNELS) + 0.3 * a - 0.2 * b
        cloudy = level + (1.0 + 0.1 * a * b) * np.log(nodes)[:, None]
        tables.append(dense_table((nodes,), np.concatenate((level[None], cloudy))))
    whole = stacked_tables(tables)
    fewer, weights = whole.fewest(1e-6)
    assert weights.shape[1] <= 5
    thickness, shares = [sky((9, 11), 1.0, 1000.0, 5)], random.random((9, 11, 1, 16))
    every, few = (np.empty((CHANNELS, 9, 11), np.float32) for _ in range(2))
    LookUp(whole).fill(every, thickness, weights=shares)
    LookUp(fewer).fill(few, thickness, weights=np.ascontiguousarray(shares @ weights))
    np.testing.assert_allclose(few, every, rtol=3e-6)


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
    np.testing.assert_array_equal(found[:, 0].T, made.columns.cores[0][:, 0, [1, -1], 0].T.astype(np.float32))


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
    made = table([10.0, 1000.0], np.empty(0))
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
    nodes, values = ([1.0, 2.0, 5.0], [3.0, 4.0]), np.random.default_rng(2).random((2, 4, 3, CHANNELS))
    values[1] *= 1e-9
    found = dense_table(nodes, values[0]).blend(dense_table(nodes, values[1]), share)
    elements = np.array(list(np.ndindex(4, 3)))
    exact = (1.0 - share) * values[0] + share * values[1]
    np.testing.assert_allclose(found.columns.at(elements), exact.reshape(-1, CHANNELS), rtol=2e-7)
    np.testing.assert_allclose(found.clear[0], exact[0, 0], rtol=2e-7)
