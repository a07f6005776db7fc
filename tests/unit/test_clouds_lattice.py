"""Laws of the counter-based lattice of normals."""

import numpy as np
import pytest
from scipy import stats

from hcss_twin.models.clouds.fractal.lattice import lattice_normals, unit_offset

SIDE = np.arange(-500, 500)
# Four standard errors of a correlation of 1e6 independent pairs.
LIMIT = 4e-3


def block(seed=1, octave=0, t=0, y=SIDE, x=SIDE):
    return lattice_normals(seed, octave, t, y, x)


@pytest.mark.parametrize("indices", [(1, 0, 0), (2**63, 16, -(10**12)), (-1, 3, 10**12)])
def test_a_million_nodes_are_standard_normal(indices):
    values = block(*indices).ravel()
    assert abs(values.mean()) < 4e-3
    assert abs(values.var() - 1.0) < 6e-3
    assert abs(stats.skew(values)) < 0.012
    assert abs(stats.kurtosis(values)) < 0.025
    assert np.abs(values).max() < 7.0
    assert stats.kstest(values, "norm").pvalue > 1e-3


@pytest.mark.parametrize(
    "other",
    [
        {"x": SIDE + 1},
        {"x": SIDE + 2},
        {"y": SIDE + 1},
        {"t": 1},
        {"t": -1},
        {"octave": 1},
        {"seed": 2},
        {"seed": 1 + 2**32},
        {"y": SIDE + 1, "x": SIDE + 1},
        {"y": SIDE + 1, "x": SIDE - 1},
        {"y": SIDE + 2**32},
        {"x": SIDE + 2**32},
    ],
    ids=str,
)
def test_neighbouring_nodes_are_uncorrelated_also_in_their_squares(other):
    here, there = block().ravel(), block(**other).ravel()
    assert abs(np.corrcoef(here, there)[0, 1]) < LIMIT
    assert abs(np.corrcoef(here**2, there**2)[0, 1]) < LIMIT


def test_swapping_the_axes_gives_other_numbers():
    values = block()
    assert abs(np.corrcoef(values.ravel(), values.T.ravel())[0, 1]) < LIMIT


def test_no_row_repeats_or_is_a_shifted_copy_of_another():
    # Single values repeat, because there are only 2**32 of them; neighbouring pairs do not.
    values = block(y=np.arange(2000), x=np.arange(64)).view(np.uint32).astype(np.uint64)
    pairs = values[:, :-1] << np.uint64(32) | values[:, 1:]
    assert np.unique(pairs).size == pairs.size


def test_a_spectrum_of_a_block_is_flat():
    # Power of white noise is exponentially distributed; its greatest of n ordinates is near ln n.
    power = np.abs(np.fft.rfft2(block())) ** 2 / SIDE.size**2
    inner = power[:, 1:-1].ravel()
    assert inner.max() < np.log(inner.size) + 12.0
    assert abs(inner.mean() - 1.0) < 0.01


@pytest.mark.parametrize("origin", [0, -(10**12), 10**12, 2**62])
def test_a_value_depends_on_its_own_indices_only(origin):
    y, x = origin + np.arange(40), -origin + np.arange(50)
    whole = lattice_normals(5, 2, 7, y, x)
    picked_y, picked_x = np.array([39, 3, 3, 17]), np.array([0, 49, 21])
    part = lattice_normals(5, 2, 7, y[picked_y], x[picked_x])
    np.testing.assert_array_equal(part, whole[np.ix_(picked_y, picked_x)])


def test_offsets_are_uniform_and_differ_between_axes_octaves_and_seeds():
    offsets = [unit_offset(seed, octave, axis) for seed in range(100) for octave in range(17) for axis in range(3)]
    assert min(offsets) >= 0.0
    assert max(offsets) < 1.0
    assert len(set(offsets)) == len(offsets)
    assert stats.kstest(offsets, "uniform").pvalue > 1e-3
