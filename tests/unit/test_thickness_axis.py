"""Nodes of the thickness axis: where radiance has kinks, and where it has none to speak of."""

from itertools import pairwise

import numpy as np
import pytest

from hcss_twin.providers import CloudLayer, Microphysics
from hcss_twin.scene.tables.thickness_axis import breakpoints, place_axis

PARTICLES = Microphysics("water", 6.0, 1.5, 1.0, 1e8, (0.1, 50.0))
LEVELS = np.array([0.0, 1000.0, 2000.0, 3500.0, 7000.0])
KELVIN = np.array([300.0, 288.0, 289.0, 270.0, 240.0])


def layer(anchor, base=400.0, top=4000.0, least=10.0):
    return CloudLayer("x", base, top, anchor, least, 0.5, None, PARTICLES)


@pytest.mark.parametrize(
    ("anchor", "inner"), [("base", [600.0, 1600.0, 3100.0]), ("top", [500.0, 2000.0, 3000.0])]
)
def test_an_axis_breaks_where_the_face_that_moves_crosses_a_level(anchor, inner):
    assert breakpoints(layer(anchor), LEVELS) == [10.0, *inner, 3600.0]


@pytest.mark.parametrize("anchor", ["base", "top"])
def test_radiance_with_a_kink_at_each_level_needs_few_columns(anchor):
    """Emission of the air's temperature at the face that moves: smooth between levels only."""
    made = layer(anchor)
    asked = []

    def columns(thickness_m):
        asked.append(thickness_m.size)
        face = made.base_m + thickness_m if anchor == "base" else made.top_m - thickness_m
        return (np.interp(face, LEVELS, KELVIN) ** 4)[:, None, None]

    axis = place_axis(columns, made, LEVELS, 1e-6)
    assert sum(asked) < 400
    places = np.geomspace(10.0, 3600.0, 3001)
    dense = axis.interpolate(columns(axis.exact_m))[:, 0, 0]
    exact = columns(places)[:, 0, 0]
    assert np.abs(np.interp(places, axis.dense_m, dense) / exact - 1.0).max() <= 1e-6
    assert all(high > low for low, high in pairwise(axis.dense_m))


@pytest.mark.parametrize("value", [1e-30, 1.0, 1e12])
def test_radiance_that_does_not_depend_on_thickness_takes_the_first_columns(value):
    axis = place_axis(lambda m: np.full((m.size, 2, 3), value), layer("base"), LEVELS, 1e-9)
    assert axis.exact_m.size == 4 * 8 + 1
    np.testing.assert_allclose(axis.interpolate(np.full((axis.exact_m.size, 2, 3), value)), value, rtol=1e-14)
