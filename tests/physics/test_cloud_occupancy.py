"""Voxels hold exactly the volume of the cloud that is cut into them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from hcss_twin.providers import CloudLayer, Microphysics
from hcss_twin.reports.cloud_columns import altitude_edges, occupancy

PARTICLES = Microphysics("water", 6.0, 1.5, 1.0, 1e8, (0.1, 50.0))


def layer(base=500.0, top=1500.0, anchor="base"):
    return CloudLayer("x", base, top, anchor, 10.0, 0.5, None, PARTICLES)


def layer_occupancy(thickness, layer, edges):
    """Shares of the voxels that a layer fills, with base and top by its anchor; thickness 0 is clear sky."""
    top = layer.cloud_top_m(thickness)
    cloudy = thickness > 0.0
    return occupancy(np.where(cloudy, top - thickness, np.nan), np.where(cloudy, top, np.nan), edges)


@settings(max_examples=60, deadline=None)
@given(
    thickness=arrays(np.float32, (3, 4), elements=st.one_of(st.just(0.0), st.floats(0.0, 1000.0, width=32))),
    inner=st.lists(st.floats(300.0, 1700.0), max_size=12, unique_by=lambda edge: round(edge, 3)),
    anchor=st.sampled_from(["base", "top"]),
)
def test_the_volume_of_the_voxels_is_the_volume_of_the_cloud_for_any_edges(thickness, inner, anchor):
    edges = np.array([250.0, *sorted(inner), 1750.0])
    shares = layer_occupancy(thickness, layer(anchor=anchor), edges)
    assert shares.dtype == np.float32
    assert shares.min() >= 0.0
    assert shares.max() <= 1.0
    volume = np.sum(shares * np.diff(edges)[:, None, None], axis=0, dtype=np.float64)
    # Single precision: half a unit in the last place of each share, times its height.
    np.testing.assert_allclose(volume, thickness, atol=1500.0 * 2.0**-24 + 1e-9)


@pytest.mark.parametrize(
    ("anchor", "expected"), [("base", [0.0, 1.0, 1.0, 0.5, 0.0, 0.0]), ("top", [0.0, 0.0, 0.5, 1.0, 1.0, 0.0])]
)
def test_the_anchor_stays_and_the_other_face_moves(anchor, expected):
    edges = np.arange(0.0, 601.0, 100.0)
    shares = layer_occupancy(np.full((1, 1), 250.0), layer(100.0, 500.0, anchor), edges)
    np.testing.assert_array_equal(shares[:, 0, 0], np.float32(expected))


def test_a_level_cut_in_two_holds_the_mean_of_its_parts():
    random = np.random.default_rng(1)
    thickness = random.uniform(0.0, 1000.0, (20, 30)) * (random.random((20, 30)) < 0.6)
    coarse = layer_occupancy(thickness, layer(), np.arange(400.0, 1601.0, 100.0))
    fine = layer_occupancy(thickness, layer(), np.arange(400.0, 1601.0, 50.0))
    np.testing.assert_allclose(0.5 * (fine[::2] + fine[1::2]), coarse, atol=1e-7)


def test_clear_columns_are_empty_and_full_ones_full():
    edges = np.array([500.0, 1000.0, 1500.0])
    shares = layer_occupancy(np.array([[0.0, 1000.0]]), layer(), edges)
    np.testing.assert_array_equal(shares[:, 0, 0], 0.0)
    np.testing.assert_array_equal(shares[:, 0, 1], 1.0)
    clear = np.full((1, 2), np.nan)
    np.testing.assert_array_equal(occupancy(clear, clear, edges), 0.0)


@settings(max_examples=100, deadline=None)
@given(base=st.floats(0.0, 9000.0), depth=st.floats(0.0, 6000.0), step=st.floats(1.0, 700.0))
def test_edges_are_multiples_of_the_step_that_enclose_the_cloud(base, depth, step):
    edges = altitude_edges(base, base + depth, step)
    assert edges[0] <= base
    assert edges[-1] >= base + depth
    np.testing.assert_allclose(edges / step, np.round(edges / step), atol=1e-9)
    np.testing.assert_allclose(np.diff(edges), step, rtol=1e-9)
    # A level more than needed at most.
    assert edges.size - 1 <= depth / step + 3


@pytest.mark.parametrize(
    ("base", "top", "edges", "message"),
    [
        (100.0, 300.0, [0.0, 200.0], r"0 to 200 m given, but cloud reaches from 100 to 300 m"),
        (100.0, 300.0, [150.0, 400.0], "enclose"),
        (300.0, 100.0, [0.0, 400.0], "base lies above its top"),
        (np.nan, 100.0, [0.0, 400.0], "only one of the two is missing"),
        (100.0, 300.0, [0.0, 500.0, 400.0], "400 m follows 500 m"),
        (100.0, 300.0, [0.0], "at least 2 ascending"),
    ],
)
def test_what_would_lose_volume_is_refused(base, top, edges, message):
    with pytest.raises(ValueError, match=message):
        occupancy(np.full((1, 1), base), np.full((1, 1), top), np.array(edges))


@pytest.mark.parametrize(
    ("base", "top", "step"), [(0.0, 1.0, 0.0), (0.0, 1.0, np.nan), (2.0, 1.0, 1.0), (0.0, 1e9, 1.0), (0.0, np.inf, 1.0)]
)
def test_edges_that_cannot_be_made_are_refused(base, top, step):
    with pytest.raises(ValueError, match="given"):
        altitude_edges(base, top, step)
