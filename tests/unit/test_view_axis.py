"""Nodes over the image, what they count in pixels, and how many are taken."""

from types import SimpleNamespace

import numpy as np
import pytest
from dense_tables import dense_table

from hcss_twin.engine.tables import frame_look_up
from hcss_twin.engine.tables.frame_look_up import FrameLookUp
from hcss_twin.engine.tables.look_up import LookUp
from hcss_twin.engine.tables.over_views import GridViews
from hcss_twin.physics import quadrature
from hcss_twin.physics.viewing import LinesOfSight
from hcss_twin.plan.rays import GridRays
from hcss_twin.plan.views import ImageViews, ViewAxis
from hcss_twin.providers import Grid

GRID = Grid(30, 41, 5000.0)


@pytest.mark.parametrize("order", [0, 1, 2, 3, 5, 8, 16])
def test_polynomials_up_to_the_order_are_exact(order):
    places = np.linspace(-1.0, 1.0, 23)
    power = np.arange(order + 1)
    found = quadrature.weights(order, places) @ quadrature.nodes(order)[:, None] ** power
    np.testing.assert_allclose(found, places[:, None] ** power, atol=1e-13)


@pytest.mark.parametrize(("order", "following"), [(0, 2), (1, 4), (2, 4), (4, 8), (8, 16)])
def test_nodes_and_those_between_them_are_the_nodes_of_a_following_order(order, following):
    both = np.concatenate((quadrature.nodes(order), quadrature.between(order)))
    assert np.array_equal(np.sort(both), quadrature.nodes(following))


def test_weights_make_the_value_at_pixel_centres():
    axis = ViewAxis(3, 5, 0.0)
    across, up = axis.weights(GRID)
    assert across.shape == (41, 4)
    assert up.shape == (30, 6)
    values = np.array([2.0 + x**3 - y * x + y**5 for x, y in axis.places]).reshape(6, 4)
    x, y = (np.arange(41) - 20.0) / 20.5, (np.arange(30) - 14.5) / 15.0
    expected = 2.0 + x**3 - y[:, None] * x + y[:, None] ** 5
    np.testing.assert_allclose(up @ values @ across.T, expected, atol=1e-13)


def test_the_views_of_pixels_are_those_of_their_places():
    views = ImageViews(GRID, LinesOfSight(35.0, 150.0, 40.0, 70.0, 700e3))
    by_pixel = GridRays(SimpleNamespace(grid=GRID), 1, views).views_of_pixels([0, 29, 14], [0, 40, 20], 0.0)
    by_place = views.at([(-20.0 / 20.5, -14.5 / 15.0), (20.0 / 20.5, 14.5 / 15.0), (0.0, -0.5 / 15.0)])
    assert by_pixel == by_place
    # The sensor stands in the east: what lies there sees it higher.
    assert by_pixel[1].zenith_deg < by_pixel[2].zenith_deg < by_pixel[0].zenith_deg


@pytest.mark.parametrize("layers", [0, 1, 2, 3])
@pytest.mark.parametrize("samples", [1, 3])
def test_a_frame_is_the_weighted_sum_of_look_ups_in_whatever_strips(layers, samples, monkeypatch):
    random, axis = np.random.default_rng(layers), ViewAxis(2, 1, 0.0)
    nodes = [np.array([100.0, 200.0, 400.0])] * layers
    tables = [dense_table(nodes, 1.0 + random.random((*(4,) * layers, 2))) for _ in axis.places]
    shape = GRID.rows * samples, GRID.columns * samples
    thickness = [
        np.where(random.random(shape) < 0.5, 0.0, random.uniform(100.0, 400.0, shape)).astype(np.float32)
        for _ in range(layers)
    ]
    whole = np.empty((2, GRID.rows, GRID.columns), dtype=np.float32)
    plan = SimpleNamespace(bands=[0, 1], image=GRID)
    viewed = FrameLookUp(plan, [GridViews(axis, GRID)], [len(tables)], tables)
    viewed.fill(whole, thickness, samples)
    across, up = axis.weights(GRID)
    expected = np.zeros(whole.shape)
    for node, table in enumerate(tables):
        part = np.empty_like(whole)
        LookUp(table).fill(part, thickness, samples)
        expected += part * up[:, node // 3, None] * across[:, node % 3]
    np.testing.assert_allclose(whole, np.maximum(expected, 0.0), rtol=1e-6, atol=1e-8)  # parts have single precision
    monkeypatch.setattr(frame_look_up, "VALUES_AT_ONCE", 400)
    strips = np.empty_like(whole)
    viewed.fill(strips, thickness, samples)
    assert np.array_equal(strips, whole)
    if layers:
        pieces = np.empty_like(whole)
        corners = ((0, 11, 0, 41), (11, 30, 0, 7), (11, 30, 7, 41))
        for top, bottom, left, right in corners:
            at = slice(top * samples, bottom * samples), slice(left * samples, right * samples)
            viewed.fill(pieces, [each[at] for each in thickness], samples, (top, left))
        assert np.array_equal(pieces, whole)
