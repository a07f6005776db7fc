"""Clouds with a shape in height, displaced: their shape goes with them, and parallax moves the picture as a whole."""

import numpy as np
import pytest
from hcss_light.stage import shares_of
from light_scene import DAY, scene

from hcss_twin import simulate
from hcss_twin.engine.clouds import FrameClouds
from hcss_twin.plan.make_plan import make_plan

CLOUDS = {"type": "stratocumulus", "generator": "fractal-relief", "coverage": 0.5, "coverage_mode": "field"}
WINDOW = slice(-3, 17), slice(0, 20)


def plan_of(shadows, parallax, **changes):
    slant = {"shadows": shadows, "parallax": parallax}
    return make_plan(scene("source", clouds=CLOUDS, slant=slant, **changes))


def columns_of(plan, window):
    layer, thickness = plan.layers[0], FrameClouds(plan, 0.0).thickness_m(window)[0]
    return thickness, shares_of(plan, 0, 0.0, window, thickness, np.linspace(layer.base_m, layer.top_m, 17))


def test_room_for_the_sun_around_the_image_leaves_each_column_its_own_shape():
    """The plane of the clouds is larger then, and its rows and columns count from elsewhere."""
    for one, other in zip(*(columns_of(plan_of(key, "off", time=DAY), WINDOW) for key in ("off", "on")), strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("view", ["parallel", "from an altitude"])
def test_columns_have_the_shape_of_the_place_where_they_are(view):
    changes = {} if view == "parallel" else {"platform": {"altitude": 4e5}}
    moved, still = plan_of("off", "on", **changes), plan_of("off", "off")
    shift = moved.assembly.slant.of_view(moved.layers[0], 100.0)
    thickness, shares = columns_of(moved, WINDOW)
    for y, x in ((0, 0), (5, 11), (19, 19)):
        row, column = WINDOW[0].start + y, WINDOW[1].start + x
        pixel = slice(row, row + 1), slice(column, column + 1)
        down, right = shift if isinstance(shift, tuple) else shift.at(*pixel)[:, 0, 0].tolist()
        there = slice(row + down - 1, row + down + 2), slice(column + right - 1, column + right + 2)
        own_thickness, own_shares = columns_of(still, there)
        assert thickness[y, x] == own_thickness[1, 1]
        np.testing.assert_allclose(shares[:, y, x], own_shares[:, 1, 1], atol=1e-6)
    assert np.any(thickness > 0.0)


def test_parallax_moves_the_radiance_of_clouds_with_sides_by_the_height_of_their_flat_side():
    moved, still = (plan_of("off", parallax) for parallax in ("on", "off"))
    rows, columns = moved.assembly.slant.of_view(moved.layers[0], 100.0)
    zenith, azimuth = np.radians([50.0, 30.0])
    away = moved.layers[0].top_m * np.tan(zenith) / 100.0  # from which stratocumulus hangs
    assert (rows, columns) == (round(away * np.cos(azimuth)), round(away * np.sin(azimuth)))
    seen, flat = (simulate(plan.scenario)["radiance"].values[0, 0] for plan in (moved, still))
    # Squares on which light is computed begin elsewhere: their blocks of two points differ.
    np.testing.assert_allclose(seen[: 40 - rows, : 30 - columns], flat[rows:, columns:], rtol=5e-3)
    assert np.max(np.abs(seen / flat - 1.0)) > 0.05
