"""The store of lattice nodes: never another value, and no growth without need."""

import numpy as np
import pytest

from hcss_twin.models.clouds.fractal import blocks
from hcss_twin.models.clouds.fractal.blocks import BLOCK_COLUMNS, BLOCK_ROWS, BlockCache, NodeWindow
from hcss_twin.models.clouds.fractal.lattice import lattice_normals, plane_key
from hcss_twin.models.clouds.fractal.octaves import Octave
from hcss_twin.models.clouds.fractal.parameters import FractalParameters
from hcss_twin.providers import Grid, Motion


def at_once(part, count):
    part(0, count)


def window(t=0, rows=(-5, 70), columns=(-300, 30)):
    return NodeWindow((plane_key(1, 2, t),), rows, columns)


def nodes(cache, table, wanted):
    """All nodes of the blocks of a window with one plane."""
    block = cache.pool[table[0]].reshape(*table.shape[1:], BLOCK_ROWS, BLOCK_COLUMNS)
    return np.concatenate(np.concatenate(block, axis=1), axis=1)


def expected(t, wanted):
    y = np.arange(wanted.block_rows[0] * BLOCK_ROWS, (wanted.block_rows[-1] + 1) * BLOCK_ROWS)
    x = np.arange(wanted.block_columns[0] * BLOCK_COLUMNS, (wanted.block_columns[-1] + 1) * BLOCK_COLUMNS)
    return lattice_normals(1, 2, t, y, x)


def test_stored_nodes_are_those_of_the_lattice_whatever_was_loaded_before():
    cache = BlockCache()
    rng = np.random.default_rng(5)
    for step in range(40):
        top, left = (int(value) for value in rng.integers(-2000, 2000, 2))
        t = step // 3
        wanted = window(t, (top, top + 130), (left, left + 300))
        (table,) = cache.load(float(t), [wanted], at_once)
        np.testing.assert_array_equal(nodes(cache, table, wanted), expected(t, wanted))


def test_blocks_of_this_frame_and_the_last_are_not_generated_again():
    cache, filled = BlockCache(), []
    strips = [window(rows=(top, top + 60), columns=(0, 900)) for top in range(0, 1200, 60)]

    def counting(part, count):
        filled.append(count)
        part(0, count)

    for frame in range(3):
        for strip in strips:
            cache.load(float(frame), [strip], counting)
        if frame == 0:
            once = sum(filled)
    assert sum(filled) == once == -(-1200 // BLOCK_ROWS) * -(-900 // BLOCK_COLUMNS)


def test_a_long_sequence_of_moving_frames_does_not_grow():
    cache, sizes = BlockCache(), []
    for frame in range(400):
        cache.load(float(frame), [window(frame // 20, (0, 800), (50 * frame, 50 * frame + 800))], at_once)
        sizes.append(cache.slots)
    assert sizes[-1] == sizes[30]


def test_a_full_store_throws_out_the_oldest(monkeypatch):
    monkeypatch.setattr(blocks, "MAX_BLOCKS", 16)
    cache = BlockCache()
    for top in range(0, BLOCK_ROWS * 100, BLOCK_ROWS):
        wanted = window(rows=(top, top + BLOCK_ROWS), columns=(0, 4 * BLOCK_COLUMNS))
        (table,) = cache.load(0.0, [wanted], at_once)
        np.testing.assert_array_equal(nodes(cache, table, wanted), expected(0, wanted))
    assert cache.slots == 16


def test_a_window_larger_than_the_store_is_held_whole(monkeypatch):
    monkeypatch.setattr(blocks, "MAX_BLOCKS", 16)
    cache, wanted = BlockCache(), window(rows=(0, BLOCK_ROWS * 30), columns=(0, 4 * BLOCK_COLUMNS))
    (table,) = cache.load(0.0, [wanted], at_once)
    np.testing.assert_array_equal(nodes(cache, table, wanted), expected(0, wanted))


@pytest.mark.parametrize(
    ("cloud_speed_m_s", "evolution_time_s", "is_new"),
    [(0.0, 1e6, False), (50.0, 1e6, True), (100.0, 1e6, False), (0.0, 0.01, True)],
)
def test_noise_is_new_in_a_frame_if_it_evolves_or_drifts_by_a_part_of_a_pixel(
    cloud_speed_m_s, evolution_time_s, is_new
):
    """Pixels of 100 m and frames each second, over cells of 4 m."""
    shape = FractalParameters(gamma=8.0, H=0.5, L=(1.0, 1.0), k=(4, 4))
    motion = Motion(0.0, (0.0, cloud_speed_m_s), evolution_time_s, 1.0)
    (octave,) = Octave.separate(shape, Grid(8, 8, 100.0), motion)
    assert octave.is_white
    assert octave.t.nearest == is_new
    assert Octave.separate(shape, Grid(8, 8, 100.0), motion, noise=False)[0].t.nearest is False


@pytest.mark.parametrize(("step", "phases"), [(0.5, 0), (2.7, 2), (4.0, 4), (1000.0, 4)])
def test_noise_divides_a_pixel_into_its_cells_up_to_four(step, phases):
    assert Octave.AxisScale(step, True).phases == phases
