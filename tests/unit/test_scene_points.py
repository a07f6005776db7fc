"""Values between the points of the scene."""

import numpy as np
import pytest

from hcss_twin.engine.scene_points import interpolated, linear
from hcss_twin.plan.scene_plane import ScenePlane
from hcss_twin.providers import Grid


def test_interpolated_clouds_are_never_thinner_than_the_thinnest():
    rng = np.random.default_rng(5)
    field = np.where(rng.random((40, 50)) < 0.5, rng.uniform(20.0, 300.0, (40, 50)), 0.0).astype(np.float32)
    places = rng.uniform(-0.5, 39.5, (1, 10_000)), rng.uniform(-0.5, 49.5, (1, 10_000))
    between = interpolated(field, *places, (0, 0))
    assert between[between > 0.0].min() >= 20.0 * (1 - 1e-6)
    assert np.mean(between > 0.0) == pytest.approx(0.5, abs=0.03)
    assert interpolated(field, *np.indices(field.shape, dtype=float), (0, 0)) == pytest.approx(field)


def test_linear_interpolation_is_exact_for_planes_and_nothing_where_rays_miss():
    y, x = np.mgrid[-2:12, 5:20]
    planes = np.stack((3.0 + 2.0 * x - y, x * y)).astype(np.float32)
    row, column = np.random.default_rng(2).uniform((-2.0, 5.0), (11.0, 19.0), (50, 2)).T[:, :, None]
    row[3] = column[3] = np.nan
    found = linear(planes, row, column, (-2, 5))
    expected = np.nan_to_num(np.stack((3.0 + 2.0 * column - row, column * row)))
    np.testing.assert_allclose(found, expected, atol=1e-4)


def test_a_place_within_half_a_point_of_the_border_is_at_the_border_whatever_the_window():
    scene = ScenePlane(Grid(10, 20, 4.0), 2)
    row, column = scene.in_points(np.array([-20.9, -19.0, 0.0, 39.9, 40.5]), np.array([-20.0, -19.1, 0.0, 19.5, 22.0]))
    assert row.tolist() == [0.0, 0.0, 9.5, 19.0, 20.5]
    assert column.tolist() == pytest.approx([9.05, 10.0, 19.5, 39.0, 39.75])
    assert scene.around(row[:4], column[:3]) == (slice(0, 10), slice(4, 11))
