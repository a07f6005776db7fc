"""Tables toward all views as combinations of few states, and tables of different sizes brought to one."""

from types import SimpleNamespace

import numpy as np
import pytest

from hcss_twin.engine.tables.radiance_tables import ShadowTables, WaveTables
from hcss_twin.engine.tables.tensor_train import LOST
from hcss_twin.engine.tables.view_states import view_states
from hcss_twin.plan.views import ONE_VIEW, ViewAxis
from hcss_twin.providers import Grid

PLAN = SimpleNamespace(views=ViewAxis(3, 2, 0.0), grid=Grid(30, 41, 5000.0), is_grid=True)


def tables_toward(plan, rank):
    """Tables (K, 5, 7) that are sums of so many products of a function of the view and one of the rest."""
    random = np.random.default_rng(rank)
    x, y = np.array(plan.views.places).T
    of_view = np.stack([np.ones_like(x), x, y, x * y, x**2][:rank], axis=1)
    return np.einsum("kr,rab->kab", of_view, random.normal(size=(rank, 5, 7)))


@pytest.mark.parametrize("rank", [1, 3, 5])
def test_as_few_states_as_there_are_products_tell_all_tables(rank):
    tables = tables_toward(PLAN, rank)
    states = view_states(PLAN, tables, 0.0)
    assert len(states.values) == rank
    again = np.tensordot(states.shares.reshape(12, -1), states.values, 1)
    assert np.max(np.abs(again - tables) / np.abs(tables).max(axis=0)) <= LOST


def test_states_of_pixels_are_the_polynomials_through_the_nodes():
    window = slice(4, 9), slice(30, 41)
    states = view_states(PLAN, tables_toward(PLAN, 4), 0.0)
    found = np.tensordot(states.weights(window), states.values, 1)
    x, y = (2.0 * np.arange(30, 41) - 40.0) / 41.0, (2.0 * np.arange(4, 9) - 29.0) / 30.0
    x, y = np.meshgrid(x, y)
    parts = np.random.default_rng(4).normal(size=(4, 5, 7))
    expected = np.einsum("ryx,rab->yxab", np.stack([np.ones_like(x), x, y, x * y]), parts)
    np.testing.assert_allclose(found, expected, atol=10.0 * LOST)


class Askew:
    """Rays of a frame, whose pixels lie askew in a small part of all directions; one misses the ground."""

    def positions(self, window, time_s):
        y, x = np.mgrid[window].astype(float)
        x, y = 0.2 + 0.01 * x + 0.002 * y, -0.4 + 0.01 * y - 0.003 * x
        x[0, 0] = y[0, 0] = np.nan
        return x, y

    def bounds(self, time_s):
        return (0.2, 0.7), (-0.6, 0.0)


def test_states_of_pixels_of_a_camera_are_the_polynomials_at_their_directions():
    plan, window = SimpleNamespace(views=PLAN.views, is_grid=False, rays=Askew()), (slice(0, 30), slice(3, 41))
    states = view_states(plan, tables_toward(PLAN, 5), 0.0)
    found = np.tensordot(states.weights(window), states.values, 1)
    x, y = Askew().positions(window, 0.0)
    parts = np.random.default_rng(5).normal(size=(5, 5, 7))
    expected = np.einsum("ryx,rab->yxab", np.stack([np.ones_like(x), x, y, x * y, x**2]), parts)
    met = ~np.isnan(x)
    np.testing.assert_allclose(found[met], expected[met], atol=20.0 * LOST)
    assert np.all(np.isfinite(found))


def test_one_view_is_one_state_with_weight_one_anywhere():
    states = view_states(SimpleNamespace(views=ONE_VIEW), np.ones((1, 3)), 0.0)
    assert states.values.shape == (1, 3)
    assert np.all(states.weights((slice(-4, 2), slice(39, 45))) == np.ones((6, 6, 1)))


def test_waves_have_the_same_cubics_at_more_nodes():
    def cubic(upwind, crosswind):
        return 1.0 + upwind**3 - 2.0 * upwind * crosswind**2 + crosswind**3

    change, finer = (
        cubic(np.linspace(-1, 1, n)[:, None], np.linspace(-1, 1, m)).astype(np.float32)[:, :, None]
        for n, m in ((9, 17), (33, 17))
    )
    waves = WaveTables((0.1, 0.1), (change,), (np.ones((1, 1)),), 0.0, (0.5 * change,))
    whole, sunlit = waves.at(0.0, (0.0,), (33, 17))
    np.testing.assert_allclose(whole[0], finer[:, :, 0], atol=1e-6)
    np.testing.assert_allclose(sunlit[0], 0.5 * finer[:, :, 0], atol=1e-6)


def test_shadows_are_the_same_lines_at_more_nodes():
    """Nodes are uniform in the root of the path, between which the depth is linear in the path."""
    depth = np.cumsum(np.random.default_rng(0).random((1, 2, 17, 3)), axis=2)
    tables = ShadowTables((0.0,), np.ones(2), np.ones((1, 1, 3)), depth)
    _, finer = tables.at(0.0, 64)
    assert finer.shape == (2, 65, 3)
    path = np.linspace(0.0, 1.0, 65) ** 2
    for layer in range(2):
        for band in range(3):
            expected = np.interp(path, np.linspace(0.0, 1.0, 17) ** 2, depth[0, layer, :, band])
            np.testing.assert_allclose(finer[layer, :, band], expected, rtol=1e-12)
    np.testing.assert_array_equal(tables.at(0.0, 16)[1], depth[0])
